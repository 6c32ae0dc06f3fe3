"""`cad_shadow.add_section`: an empty in the middle of the model that cuts it open, to be moved and turned."""

from __future__ import annotations

import bpy
from mathutils import Matrix, Vector

from ..blender.section_properties import NAMES
from ..blender.sources import DRAWN_TYPES
from .row import OperatorRow


def model_box(context: bpy.types.Context) -> tuple[Vector, float]:
    """The middle and the size of what is visible."""
    objects = [ob for ob in context.visible_objects if ob.type in DRAWN_TYPES and ob.type != "EMPTY"]
    corners = [ob.matrix_world @ Vector(corner) for ob in objects for corner in ob.bound_box]
    if not corners:
        return Vector((0.0, 0.0, 0.0)), 1.0
    low, high = (Vector([pick(c[i] for c in corners) for i in range(3)]) for pick in (min, max))
    return (low + high) / 2.0, max((high - low).length, 1e-6)


class CAD_SHADOW_OT_add_section(bpy.types.Operator):
    """Cut the model open through its middle: adds an empty whose arrow points to what is cut away. Move and turn it to move the section"""

    bl_idname = "cad_shadow.add_section"
    bl_label = "Add Section Plane"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Grey when all planes are in use."""
        if all(getattr(context.scene.cad_shadow, name).use for name in NAMES):
            cls.poll_message_set(f"All {len(NAMES)} section planes are in use: switch one off")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """The first plane that is free, across the front view: its arrow points to the viewer."""
        props = context.scene.cad_shadow
        name = next(name for name in NAMES if not getattr(props, name).use)
        middle, size = model_box(context)
        empty = bpy.data.objects.new("Section", None)
        empty.empty_display_type, empty.empty_display_size = "SINGLE_ARROW", size / 3.0
        empty.matrix_world = Matrix.Translation(middle) @ Matrix.Rotation(1.5707963267948966, 4, "X")
        context.collection.objects.link(empty)
        section = getattr(props, name)
        section.object, section.flip, section.use = empty, False, True
        for ob in context.selected_objects:
            ob.select_set(False)
        empty.select_set(True)
        context.view_layer.objects.active = empty
        return {"FINISHED"}


ROW = OperatorRow("add_section", 17, (CAD_SHADOW_OT_add_section,), group="picture")
