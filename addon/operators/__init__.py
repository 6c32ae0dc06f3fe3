"""The operators, `bpy.ops.cad_shadow.*`, and their places in Blender's menus and the panels. A module here for each, with its `ROW`
(`row.py`).
"""

from __future__ import annotations

from itertools import groupby

import bpy

from ..blender.panels.settings import SECTIONS, panels_of
from ..blender.registering import Appended, BlenderClass, Registrable, attach, detach
from ..maths.tables import rows_of
from ..scene.reading import process
from . import background, ticking
from .row import OperatorRow

OPERATORS: dict[str, OperatorRow] = rows_of(__name__, __path__)


class CAD_SHADOW_MT_render(bpy.types.Menu):
    """What the extension can do; Blender's search (F3) finds what stands in a menu"""

    bl_idname = "CAD_SHADOW_MT_render"
    bl_label = "CAD Shadow"

    def draw(self, _context: bpy.types.Context) -> None:
        """All operators, in groups."""
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        listed = [row for row in OPERATORS.values() if row.group]
        for i, (_, rows) in enumerate(groupby(listed, key=lambda row: row.group)):
            if i:
                layout.separator()
            for operator in (operator for row in rows for operator in row.operators):
                layout.operator(operator.bl_idname)


def _draw_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(CAD_SHADOW_MT_render.bl_idname)


def _entries(row: OperatorRow) -> list[Appended]:
    """What the row draws in menus and panels that are not its own."""
    entries = [Appended(getattr(bpy.types, menu), draw) for menu, draw in row.entries]
    if row.section:
        section = next(section for section in SECTIONS if section.key == row.section)
        entries += [Appended(panel, lambda self, _context: row.draw_buttons(self.layout)) for panel in panels_of(section)]
    return entries


def _parts() -> tuple[Registrable, ...]:
    return (
        *(BlenderClass(cls) for row in OPERATORS.values() for cls in row.classes),
        BlenderClass(CAD_SHADOW_MT_render),
        Appended(bpy.types.TOPBAR_MT_render, _draw_menu),
        *(entry for row in OPERATORS.values() for entry in _entries(row)),
    )


_attached: list[Registrable] = []


def register() -> None:
    """Offer the operators."""
    parts = _parts()
    attach(parts)
    _attached[:] = parts


def unregister() -> None:
    """End those at work and remove the operators."""
    ticking.end_all(bpy.context)
    background.end_threads()
    process.shutdown()
    parts = list(_attached)
    _attached.clear()
    detach(parts)
