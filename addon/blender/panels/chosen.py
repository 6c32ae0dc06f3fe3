"""Which look and which preset are on, and whether the live view is: what the first panel shows of them."""

from __future__ import annotations

import bpy

from ...errors import UserError
from ...settings.looks import LOOKS, look_of
from ..presets import preset_of
from ..properties import settings_from
from ..render_wish import ENGINE

BY_HAND = "Custom"


def is_live(context: bpy.types.Context) -> bool:
    """Whether the viewport that the panel belongs to shows this engine's pictures."""
    space = context.space_data
    return space is not None and space.type == "VIEW_3D" and space.shading.type == "RENDERED" and context.scene.render.engine == ENGINE


def look_label(props: bpy.types.PropertyGroup) -> str:
    """The look that the scene has."""
    try:
        name = look_of(settings_from(props))
    except UserError:
        name = None
    return LOOKS[name].label if name else BY_HAND


def preset_label(props: bpy.types.PropertyGroup) -> str:
    """The preset that the scene has."""
    return preset_of(props) or BY_HAND


class CAD_SHADOW_MT_looks(bpy.types.Menu):
    """How the picture looks as a whole: colors, edges, ground. How sharp its shadows are is not changed"""

    bl_idname = "CAD_SHADOW_MT_looks"
    bl_label = "Look"

    def draw(self, context: bpy.types.Context) -> None:
        """All looks, the present one marked."""
        present = look_label(context.scene.cad_shadow)
        for name, look in LOOKS.items():
            icon = "CHECKMARK" if look.label == present else "BLANK1"
            self.layout.operator("cad_shadow.look", text=look.label, icon=icon).look = name


def register() -> None:
    """Offer the menu."""
    bpy.utils.register_class(CAD_SHADOW_MT_looks)


def unregister() -> None:
    """Take it back."""
    bpy.utils.unregister_class(CAD_SHADOW_MT_looks)
