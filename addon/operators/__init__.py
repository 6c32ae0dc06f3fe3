"""The operators, `bpy.ops.cad_shadow.*`, and their places in Blender's menus. One verb per file."""

import bpy

from . import advise, analyse, export_report, import_cad, light_view, preview

_parts = (preview, analyse, light_view, advise, export_report)


def _draw_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    for part in _parts:
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator(part.OPERATOR.bl_idname)


def register() -> None:
    """Offer the operators."""
    for part in _parts:
        bpy.utils.register_class(part.OPERATOR)
    for operator in advise.ALSO:
        bpy.utils.register_class(operator)
    bpy.types.TOPBAR_MT_render.append(_draw_menu)
    import_cad.register()


def unregister() -> None:
    """Remove the operators."""
    import_cad.unregister()
    bpy.types.TOPBAR_MT_render.remove(_draw_menu)
    for operator in advise.ALSO:
        bpy.utils.unregister_class(operator)
    for part in reversed(_parts):
        bpy.utils.unregister_class(part.OPERATOR)
