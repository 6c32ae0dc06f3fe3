"""`cad_shadow.light_view`: what the light sees of this view, each place in the colour of its shadow map."""

from __future__ import annotations

import bpy

from .. import image_editor
from ..errors import UserError
from ..job import Outcome
from ..light_view import SIZE, light_picture
from .background import JobOperator


class CAD_SHADOW_OT_light_view(JobOperator, bpy.types.Operator):
    """Show what the light sees: the outlines of the shadow maps over the camera's view, and each surface in the colour of its map"""

    bl_idname = "cad_shadow.light_view"
    bl_label = "Light's View"
    bl_options = {"REGISTER"}

    def finish(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Draw and show the picture."""
        try:
            picture = light_picture(outcome.job, outcome.frame.plan, SIZE)
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return
        image_editor.show(
            context, image_editor.to_image(image_editor.displayed(picture), f"{image_editor.NAME}: light's view", is_data=True)
        )


OPERATOR = CAD_SHADOW_OT_light_view
