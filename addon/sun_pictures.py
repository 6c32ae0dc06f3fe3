"""The pictures of a sun study on the worker, one after another, and their contact sheet. No bpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .errors import UserError
from .images.contact_sheet import TILE, contact_sheet, fitted
from .job import Job, Outcome, Pending
from .sun_study import Moment


def job_at(job: Job, moment: Moment) -> Job:
    """The same view under the moment's sun, nothing measured."""
    return replace(job, light=moment.light(job.light), settings=moment.settings(job.settings), passes=("combined",), measure=False)


class PendingStudy:
    """A study under way; used like `job.Pending`, `result` gives the sheet. Only the small pictures are kept."""

    def __init__(self, job: Job, moments: list[Moment], tile: tuple[int, int] = TILE) -> None:
        self.job, self.moments, self._tile = job, moments, tile
        self._pictures: list[np.ndarray] = []
        self._error: UserError | None = None
        self._current = Pending(job_at(job, moments[0]))

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the time of the day it is at."""
        done = len(self._pictures)
        if self._is_over:
            return 1.0, ""
        return (done + self._current.progress[0]) / len(self.moments), self.moments[done].time

    @property
    def _is_over(self) -> bool:
        return self._error is not None or len(self._pictures) == len(self.moments)

    def done(self) -> bool:
        """True when `result` will not wait; takes finished pictures and asks for the next one."""
        if not self._is_over and self._current.done():
            self._take()
        return self._is_over

    def cancel(self) -> None:
        """Give it up."""
        self._current.cancel()

    def result(self) -> np.ndarray:
        """(h, w, 4) the contact sheet, scene linear. Raises as `Pending.result` does."""
        while not self._is_over:
            self._take()
        if self._error is not None:
            raise self._error
        return contact_sheet(self._pictures, [moment.caption for moment in self.moments], tile=self._tile)

    def _take(self) -> None:
        try:
            outcome: Outcome = self._current.result()
        except UserError as error:
            self._error = error
            return
        self._pictures.append(fitted(outcome.frame.passes["combined"], self._tile))
        if not self._is_over:
            self._current = Pending(job_at(self.job, self.moments[len(self._pictures)]))
