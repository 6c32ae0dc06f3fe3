"""The operators, `bpy.ops.cad_shadow.*`, and their places in Blender's menus. One verb per file."""

import bpy

from . import (
    advise,
    analyse,
    animate_sun,
    background,
    cameras,
    compare,
    export_report,
    import_cad,
    impostor_export,
    impostor_report,
    impostors,
    light_view,
    place_sun,
    preview,
    sun_study,
    ticking,
)

_parts = (preview, analyse, compare, light_view, sun_study, advise, export_report)
_in_panels_only = (
    *advise.ALSO,
    *cameras.OPERATORS,
    place_sun.OPERATOR,
    animate_sun.OPERATOR,
    *impostors.OPERATORS,
    *impostor_report.OPERATORS,
    *impostor_export.OPERATORS,
)


_groups = (
    tuple(part.OPERATOR for part in _parts) + advise.ALSO,
    cameras.OPERATORS,
    (place_sun.OPERATOR, animate_sun.OPERATOR),
    (*impostors.OPERATORS, *impostor_report.OPERATORS, *impostor_export.OPERATORS),
)


class CAD_SHADOW_MT_render(bpy.types.Menu):
    """What the extension can do; Blender's search (F3) finds what stands in a menu"""

    bl_idname = "CAD_SHADOW_MT_render"
    bl_label = "CAD Shadow"

    def draw(self, _context: bpy.types.Context) -> None:
        """All operators, in groups."""
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        for i, group in enumerate(_groups):
            if i:
                layout.separator()
            for operator in group:
                layout.operator(operator.bl_idname)


def _draw_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(CAD_SHADOW_MT_render.bl_idname)


def register() -> None:
    """Offer the operators."""
    for part in _parts:
        bpy.utils.register_class(part.OPERATOR)
    for operator in _in_panels_only:
        bpy.utils.register_class(operator)
    bpy.utils.register_class(CAD_SHADOW_MT_render)
    bpy.types.TOPBAR_MT_render.append(_draw_menu)
    import_cad.register()


def unregister() -> None:
    """End those at work and remove the operators."""
    ticking.end_all(bpy.context)
    background.end_threads()
    import_cad.unregister()
    bpy.types.TOPBAR_MT_render.remove(_draw_menu)
    bpy.utils.unregister_class(CAD_SHADOW_MT_render)
    for operator in _in_panels_only:
        bpy.utils.unregister_class(operator)
    for part in reversed(_parts):
        bpy.utils.unregister_class(part.OPERATOR)
