"""`cad_shadow.sun_study`: the current view at several times of the day, as one sheet. Esc cancels."""

from __future__ import annotations

import bpy
import numpy as np

from ..blender import image_editor
from ..blender.sun_properties import hours_of, sky_of
from ..studies.pending import Pending
from ..studies.sun.moments import moments
from ..studies.sun.pictures import study
from .background import JobOperator, on_thread
from .row import OperatorRow

IMAGE = f"{image_editor.NAME}: sun study"


class CAD_SHADOW_OT_sun_study(JobOperator, bpy.types.Operator):
    """Render the current view under the sun of several times of the day and show the pictures side by side"""

    bl_idname = "cad_shadow.sun_study"
    bl_label = "Sun Study"
    bl_options = {"REGISTER"}

    def start(self, context: bpy.types.Context) -> Pending:
        """Ask for the pictures."""
        props = context.scene.cad_shadow.sun
        clock, place = sky_of(props)
        times = moments(clock, place, *hours_of(props), props.steps)
        return on_thread(context, study, times)

    def take(self, context: bpy.types.Context, sheet: np.ndarray) -> None:
        """Show the sheet; the view's last report stays what it was."""
        image_editor.show(context, image_editor.to_image(sheet, IMAGE))


ROW = OperatorRow("sun_study", 50, (CAD_SHADOW_OT_sun_study,), group="picture")
