"""The view layer's passes that this engine makes, in Blender's Properties."""

from __future__ import annotations

import bpy

from ...pipeline.render_passes import LAYER_PASSES, RENDER_PASSES
from ..render_wish import ENGINE

SWITCHES = tuple(flag for flag in (RENDER_PASSES[name].blender.flag for name in LAYER_PASSES) if flag)


class CAD_SHADOW_PT_layer_passes(bpy.types.Panel):
    """Which passes come beside the picture"""

    bl_label = "Passes"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "view_layer"
    COMPAT_ENGINES = frozenset({ENGINE})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """With this engine only."""
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context: bpy.types.Context) -> None:
        """A switch for each."""
        self.layout.use_property_split, self.layout.use_property_decorate = True, False
        column = self.layout.column(heading="Include")
        for flag in SWITCHES:
            column.prop(context.view_layer, flag)


def register() -> None:
    """Offer the panel."""
    bpy.utils.register_class(CAD_SHADOW_PT_layer_passes)


def unregister() -> None:
    """Take it back."""
    bpy.utils.unregister_class(CAD_SHADOW_PT_layer_passes)
