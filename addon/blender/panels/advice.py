"""What `cad_shadow.advise` found: the proposal with its Apply button, and the table it decided from."""

from __future__ import annotations

import bpy

from ...settings.options import BY_NAME
from .. import session
from .quality import duration
from .settings import ORDER_OF_QUALITY, TAB
from .words import number, paragraph

MOST_ROWS = 8


def _label(option: str, key: str) -> str:
    """A choice as the panels call it."""
    return next(label for name, label, _ in BY_NAME[option].items if name == key)


def _name(row: dict[str, object]) -> str:
    """A combination in the panels' words."""
    partition = _label("partition", row["partition"]) + ("" if row["partitions"] == 1 else f" {row['partitions']}")
    return f"{_label('warp', row['warp'])}, {partition.lower()}, {_label('fit', row['fit']).lower()}"


def _maps(row: dict[str, object]) -> str:
    return f"{row['maps']} × {row['map_size']}² px"


def _draw_row(layout: bpy.types.UILayout, context: bpy.types.Context, row: dict[str, object], icon: str = "DOT") -> None:
    """What the combination is, and below it its maps and errors, since a sidebar is narrow."""
    measured, column = row["measured"], layout.column(align=True)
    paragraph(column, context, _name(row), icon)
    column.label(text=_maps(row), icon="BLANK1")
    errors = f"m {number(measured['m_p95'])}, {number(measured['m_p99'])};"
    column.label(text=f"{errors} {100 * measured['share_above_1']:.0f} % > 1", icon="BLANK1")


class CAD_SHADOW_PT_sidebar_advice(bpy.types.Panel):
    """The best combination found for this view or animation, and the others that were measured. m: picture pixels per texel."""

    bl_label = "Advice"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB
    bl_order = ORDER_OF_QUALITY

    def draw(self, context: bpy.types.Context) -> None:
        """The button; the last advice below it."""
        layout, advice = self.layout, session.last_advice()
        layout.operator("cad_shadow.advise", icon="LIGHT_DATA")
        if advice is None:
            paragraph(layout, context, "Tries warps, partitions, fits and map sizes on this view and proposes the best", "INFO")
            return
        proposal = advice["proposal"]
        if proposal is not None:
            paragraph(layout, context, f"{_name(proposal)}, {_maps(proposal)}", "CHECKMARK")
            then, now = proposal["rendered"], advice["current"]["rendered"]
            layout.label(text=f"m 95 %: {number(then['m_p95'])}, before {number(now['m_p95'])}", icon="BLANK1")
            layout.label(text=f"A picture takes {duration(then['total_ms'])}", icon="BLANK1")
            layout.operator("cad_shadow.apply_advice", text="Apply", icon="IMPORT")
        for note in advice["notes"]:
            paragraph(layout, context, note, "INFO")
        box = layout.box().column()
        paragraph(box, context, "Measured; m is the error of 95 % and of 99 % of the pixels")
        for row in advice["table"][:MOST_ROWS]:
            _draw_row(box, context, row)
        box.label(text="Before:")
        _draw_row(box, context, advice["current"], "RADIOBUT_ON")


def register() -> None:
    """Show the panel."""
    bpy.utils.register_class(CAD_SHADOW_PT_sidebar_advice)


def unregister() -> None:
    """Remove the panel."""
    bpy.utils.unregister_class(CAD_SHADOW_PT_sidebar_advice)
