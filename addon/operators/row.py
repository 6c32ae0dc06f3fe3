"""What an operator's module registers: its classes, and where its buttons are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy

Draw = Callable[[bpy.types.Menu, bpy.types.Context], None]


@dataclass(frozen=True, eq=False)
class OperatorRow:
    """A row: classes that are registered in this order, their operators listed at `place` in *Render → CAD Shadow*.

    Between two of the menu's groups there is a line; without a `group` they are not in it. `section`: the key of the panel that ends with
    their buttons (`SECTIONS` of `blender/panels/settings.py`), with `icon`. `entries`: what is drawn in menus of Blender, by their names.
    """

    name: str
    place: int
    classes: tuple[type, ...]
    group: str = ""
    section: str = ""
    icon: str = "NONE"
    entries: tuple[tuple[str, Draw], ...] = ()

    @property
    def operators(self) -> tuple[type[bpy.types.Operator], ...]:
        """Those of the classes that are operators."""
        return tuple(cls for cls in self.classes if issubclass(cls, bpy.types.Operator))

    def draw_buttons(self, layout: bpy.types.UILayout) -> None:
        """A button each."""
        for operator in self.operators:
            layout.operator(operator.bl_idname, icon=self.icon)
