"""`cad_shadow.compare`: the current view against ray-traced truth, as numbers and as a picture of the differences."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from ..blender import image_editor
from ..pipeline.job import Job
from ..pipeline.render_passes import ENGINE_PASSES
from ..studies.pending import Cancels, Progress
from ..studies.run import Outcome, run
from .background import PictureOperator
from .row import OperatorRow

if TYPE_CHECKING:
    import numpy as np

TRACED_PASSES = (*ENGINE_PASSES, "object", "partition")  # those that Compare needs, and those that are shown anyway
SHARE_OF_PICTURE = 0.2  # of the progress; the rays take longer


def compared(job: Job, say: Progress, is_given_up: Cancels) -> tuple[Outcome, np.ndarray]:
    """The view rendered, then traced: the outcome with `truth` in its report, and the differences as an editor shows them.

    Raises `Cancelled` soon after it is given up.
    """
    from ..studies.truth.against import against_truth  # loaded with the first comparison, so that enabling the add-on stays quick

    outcome = run(replace(job, passes=TRACED_PASSES), lambda fraction, stage: say(SHARE_OF_PICTURE * fraction, stage), is_given_up)
    say(SHARE_OF_PICTURE, "tracing rays")
    return outcome, image_editor.displayed(against_truth(outcome, is_given_up))


class CAD_SHADOW_OT_compare(PictureOperator, bpy.types.Operator):
    """Trace rays through the current view and count the pixels whose shadow is wrong: misclassified, acne, leaks, displaced edges.
    Shows where: red acne, blue leaks, yellow edges"""

    bl_idname = "cad_shadow.compare"
    bl_label = "Compare with Ray-Traced Truth"
    bl_options = {"REGISTER"}

    work = staticmethod(compared)
    title = "difference from ray-traced truth"

    def finish(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Say the most telling numbers."""
        from ..studies.truth.against import sentence

        self.report({"INFO"}, sentence(outcome.report["truth"]))


ROW = OperatorRow("compare", 30, (CAD_SHADOW_OT_compare,), group="picture")
