"""What `cad_shadow.advise` found: the proposal with its Apply button, and the table it decided from."""

from __future__ import annotations

import bpy

from .. import session
from .quality import number
from .settings import ORDER_OF_QUALITY, TAB

MOST_ROWS = 8


def _cells(row: dict[str, object]) -> tuple[str, ...]:
    partition = row["partition"] if row["partitions"] == 1 else f"{row['partition']} {row['partitions']}"
    measured = row["measured"]
    share = f"{100 * measured['share_above_1']:.0f} %"
    return (
        f"{row['warp']}, {partition}, {row['fit']}",
        f"{row['maps']} × {row['map_size']}",
        number(measured["m_p95"]),
        number(measured["m_p99"]),
        share,
    )


def _table(layout: bpy.types.UILayout, rows: list[dict[str, object]]) -> None:
    """Two lines per combination, since a sidebar is narrow: what it is, and below it its maps and errors."""
    box = layout.box().column(align=True)
    box.label(text="Maps · m 95 % · m 99 % · above 1")
    for row in rows:
        name, *numbers = _cells(row)
        box.separator()
        box.label(text=name, icon="DOT")
        box.label(text="     " + "  ·  ".join(numbers))


class CAD_SHADOW_PT_sidebar_advice(bpy.types.Panel):
    """The best combination found for this view or animation, and the others that were measured. m: picture pixels per texel."""

    bl_label = "Advice"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB
    bl_order = ORDER_OF_QUALITY

    def draw(self, _context: bpy.types.Context) -> None:
        """The button; the last advice below it."""
        layout, advice = self.layout, session.last_advice()
        layout.operator("cad_shadow.advise", icon="LIGHT_DATA")
        if advice is None:
            return
        proposal = advice["proposal"]
        if proposal is not None:
            layout.label(text=", ".join(_cells(proposal)[:2]), icon="CHECKMARK")
            then, now = proposal["rendered"], advice["current"]["rendered"]
            layout.label(text=f"m p95 {number(then['m_p95'])} (now {number(now['m_p95'])}), {number(then['total_ms'])} ms")
            layout.operator("cad_shadow.apply_advice", icon="IMPORT")
        for note in advice["notes"]:
            layout.label(text=note, icon="INFO")
        _table(layout, [*advice["table"][:MOST_ROWS], advice["current"]])


def register() -> None:
    """Show the panel."""
    bpy.utils.register_class(CAD_SHADOW_PT_sidebar_advice)


def unregister() -> None:
    """Remove the panel."""
    bpy.utils.unregister_class(CAD_SHADOW_PT_sidebar_advice)
