"""`cad_shadow.preview`: render what the 3D viewport (or the camera) sees into an image and show it. Esc cancels."""

from __future__ import annotations

import bpy

from ..blender import image_editor
from ..studies.run import Outcome
from .background import JobOperator
from .row import OperatorRow


class CAD_SHADOW_OT_preview(JobOperator, bpy.types.Operator):
    """Render the current view with its shadows and show the picture; the Quality panel then tells how sharp they are"""

    bl_idname = "cad_shadow.preview"
    bl_label = "CAD Shadow Preview"
    bl_options = {"REGISTER"}

    def finish(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Show the picture."""
        is_data = outcome.job.settings.shading.display != "shaded"  # its colours mean numbers: no view transform may change them
        image_editor.show(context, image_editor.to_image(outcome.frame.passes["combined"], is_data=is_data))


ROW = OperatorRow("preview", 10, (CAD_SHADOW_OT_preview,), group="picture")
