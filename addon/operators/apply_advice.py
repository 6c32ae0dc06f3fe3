"""`cad_shadow.apply_advice`: the proposal of `cad_shadow.advise` written into the scene's settings."""

from __future__ import annotations

import bpy

from ..blender import session
from ..blender.properties import store
from .row import OperatorRow


class CAD_SHADOW_OT_apply_advice(bpy.types.Operator):
    """Write the proposed warp, partition, fit and map size into the scene's settings"""

    bl_idname = "cad_shadow.apply_advice"
    bl_label = "Apply Advice"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Grey until there is a proposal."""
        advice = session.last_advice()
        if advice is None or advice["proposal"] is None:
            cls.poll_message_set("There is no proposal yet: press Advise first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write it; a warp set by hand is given up."""
        store(context.scene.cad_shadow, {"eta": None, "warp_parameter": None, **session.last_advice()["proposal"]["options"]})
        return {"FINISHED"}


ROW = OperatorRow("apply_advice", 80, (CAD_SHADOW_OT_apply_advice,), group="picture")
