"""`cad_shadow.compare`: the current view against ray-traced truth, as numbers and as a picture of the differences."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from .. import image_editor
from ..errors import UserError
from ..job import ENGINE_PASSES, Job, Outcome, run
from .background import JobOperator

if TYPE_CHECKING:
    import numpy as np

PASSES = (*ENGINE_PASSES, "object", "partition")
TITLE = "difference from ray-traced truth"
SHARE_OF_PICTURE = 0.2  # of the progress; the rays take longer


def _compared(job: Job) -> tuple[Outcome, np.ndarray]:
    from ..comparing import against_truth  # loaded with the first comparison, so that enabling the add-on stays quick

    outcome = run(replace(job, passes=PASSES))
    return outcome, against_truth(outcome)


class PendingComparison:
    """A view being rendered, then its rays being traced on a thread of their own; asked as `Pending` is."""

    def __init__(self, view: object) -> None:
        self._view = view
        self._future: Future[tuple[Outcome, np.ndarray]] | None = None

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the stage it is in."""
        if self._future is not None:
            return SHARE_OF_PICTURE, "tracing rays"
        fraction, stage = self._view.progress
        return SHARE_OF_PICTURE * fraction, stage

    def done(self) -> bool:
        """True when `result` will not wait."""
        if self._future is None and self._view.done():
            self._trace()
        return self._future is not None and self._future.done()

    def cancel(self) -> None:
        """Give it up; rays under way are traced to their end and dropped."""
        self._view.cancel()

    def result(self) -> tuple[Outcome, np.ndarray]:
        """The outcome with the contract's `truth` in its report, and the picture of the differences; raises what its parts raise."""
        if self._future is None:
            self._trace()
        return self._future.result()

    def _trace(self) -> None:
        self._future = Future()
        try:
            job = self._view.result().job
        except UserError as error:
            self._future.set_exception(error)
            return
        executor = ThreadPoolExecutor(1, "cad-shadow-rays")
        self._future = executor.submit(_compared, job)
        executor.shutdown(wait=False)


class CAD_SHADOW_OT_compare(JobOperator, bpy.types.Operator):
    """Trace rays through the current view and count the pixels whose shadow is wrong: misclassified, acne, leaks, displaced edges.
    Shows where: red acne, blue leaks, yellow edges"""

    bl_idname = "cad_shadow.compare"
    bl_label = "Compare with Ray-Traced Truth"
    bl_options = {"REGISTER"}

    def start(self, context: bpy.types.Context) -> PendingComparison:
        """Ask the worker for the picture; the rays follow."""
        return PendingComparison(super().start(context))

    def take(self, context: bpy.types.Context, result: tuple[Outcome, np.ndarray]) -> None:
        """Show the picture of the differences; the Quality panel lists the numbers."""
        outcome, difference = result
        super().take(context, outcome)
        image = image_editor.to_image(image_editor.displayed(difference), f"{image_editor.NAME}: {TITLE}", is_data=True)
        image_editor.show(context, image)

    def finish(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Say the most telling numbers."""
        from ..comparing import sentence

        self.report({"INFO"}, sentence(outcome.report["truth"]))


OPERATOR = CAD_SHADOW_OT_compare
