"""`cad_shadow.live_view`: the 3D viewport shows shadows as they are while one works; again, and it is as before."""

from __future__ import annotations

import bpy

from ..blender.render_wish import ENGINE
from .row import OperatorRow


def viewport_of(context: bpy.types.Context) -> bpy.types.SpaceView3D | None:
    """The 3D viewport that the operator is called from, else the screen's largest; None where there is none."""
    if context.space_data is not None and context.space_data.type == "VIEW_3D":
        return context.space_data
    areas = [area for area in context.screen.areas if area.type == "VIEW_3D"] if context.screen else []
    largest = max(areas, key=lambda area: area.width * area.height, default=None)
    return largest.spaces.active if largest else None


class CAD_SHADOW_OT_live_view(bpy.types.Operator):
    """Show the model with its shadows in this viewport while you work: sets the render engine and Rendered shading. Again: back to Solid"""

    bl_idname = "cad_shadow.live_view"
    bl_label = "Live View"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Grey where there is no 3D viewport."""
        if viewport_of(context) is None:
            cls.poll_message_set("There is no 3D viewport in this window: open one")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Switch the engine and the shading."""
        shading, render = viewport_of(context).shading, context.scene.render
        if shading.type == "RENDERED" and render.engine == ENGINE:
            shading.type = "SOLID"
        else:
            render.engine = ENGINE
            shading.type = "RENDERED"
        return {"FINISHED"}


ROW = OperatorRow("live_view", 12, (CAD_SHADOW_OT_live_view,), group="picture")
