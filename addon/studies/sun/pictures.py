"""The pictures of a sun study, one after another, and their contact sheet. No bpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...images.contact_sheet import TILE, contact_sheet, fitted
from ...pipeline.job import Job
from ..pending import Cancels, Progress
from ..run import run
from .moments import Moment


def job_at(job: Job, moment: Moment) -> Job:
    """The same view under the moment's sun, nothing measured."""
    return replace(job, light=moment.light(job.light), settings=moment.settings(job.settings), passes=("combined",), measure=False)


def study(job: Job, moments: list[Moment], say: Progress, is_given_up: Cancels) -> np.ndarray:
    """(h, w, 4) the contact sheet, scene linear; only the small pictures are kept. Waits for the worker; raises as `run.run` does."""
    small = []
    for i, moment in enumerate(moments):
        begin, step = i / len(moments), 1.0 / len(moments)
        outcome = run(job_at(job, moment), lambda fraction, _, b=begin, s=step, m=moment: say(b + s * fraction, m.time), is_given_up)
        small.append(fitted(outcome.frame.passes["combined"], TILE))
    return contact_sheet(small, [moment.caption for moment in moments], tile=TILE)
