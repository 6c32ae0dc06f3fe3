"""`cad_shadow.light_view`: what the light sees of this view, each place in the colour of its shadow map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..blender import image_editor
from ..pipeline.job import Job
from ..studies.light_view import SIZE, light_picture
from ..studies.pending import Cancels, Progress
from ..studies.run import Outcome, run
from .background import PictureOperator
from .row import OperatorRow

if TYPE_CHECKING:
    import numpy as np


def seen_by_light(job: Job, say: Progress, is_given_up: Cancels) -> tuple[Outcome, np.ndarray]:
    """The view's outcome, and the light's picture as an editor shows it."""
    outcome = run(job, lambda fraction, stage: say(0.5 * fraction, stage), is_given_up)
    say(0.5, "the light's view")
    return outcome, image_editor.displayed(light_picture(outcome.job, outcome.frame.plan, SIZE))


class CAD_SHADOW_OT_light_view(PictureOperator, bpy.types.Operator):
    """Show what the light sees: the outlines of the shadow maps over the camera's view, and each surface in the colour of its map"""

    bl_idname = "cad_shadow.light_view"
    bl_label = "Light's View"
    bl_options = {"REGISTER"}

    work = staticmethod(seen_by_light)
    title = "light's view"

    def finish(self, _context: bpy.types.Context, _outcome: Outcome) -> None:
        """The picture says it all."""


ROW = OperatorRow("light_view", 40, (CAD_SHADOW_OT_light_view,), group="picture")
