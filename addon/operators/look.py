"""`cad_shadow.look`: the scene gets a look, colours, edges and ground at once."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from ..blender.properties import store
from ..settings.looks import LOOKS, look_values
from .row import OperatorRow

PLAIN = "Standard"


class CAD_SHADOW_OT_look(bpy.types.Operator):
    """Give the picture this look. Sets the scene's view transform to Standard, which shows colors as the model has them"""

    bl_idname = "cad_shadow.look"
    bl_label = "CAD Shadow Look"
    bl_options = {"REGISTER", "UNDO"}

    look: EnumProperty(name="Look", items=[(name, look.label, look.text) for name, look in LOOKS.items()], default="cad")

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """What one will see."""
        return f"{LOOKS[properties.look].text}. Sets the view transform to {PLAIN}, which shows colors as the model has them"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set what a look holds; all else stays."""
        store(context.scene.cad_shadow, look_values(self.look))
        view = context.scene.view_settings
        if view.view_transform != PLAIN:
            view.view_transform, view.look = PLAIN, "None"
            self.report({"INFO"}, "View transform: Standard (Render Properties > Color Management)")
        return {"FINISHED"}


ROW = OperatorRow("look", 15, (CAD_SHADOW_OT_look,))
