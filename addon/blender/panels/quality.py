"""The last report in the sidebar: γ, γ_lim, and n', η, bounds, M_x, M_z, S of each partition, and the measured error m."""

from __future__ import annotations

import bpy

from .. import session
from .settings import ORDER_OF_QUALITY, TAB
from .words import number, paragraph


def duration(ms: float | None) -> str:
    """Milliseconds below a second, seconds above."""
    return number(ms, " ms") if ms is None or ms < 1000.0 else number(ms / 1000.0, " s")


def _row(layout: bpy.types.UILayout, label: str, value: str) -> None:
    split = layout.split(factor=0.5)
    left = split.row()
    left.alignment = "RIGHT"
    left.label(text=label)
    split.label(text=value)


def _measured(layout: bpy.types.UILayout, measured: dict[str, object]) -> None:
    box = layout.box().column(align=True)
    box.label(text="Measured m (pixels per texel)")
    for key, label in (("m_median", "Median"), ("m_p95", "95 %"), ("m_p99", "99 %"), ("m_max", "Largest")):
        perspective = measured["perspective"][key]
        _row(box, label, f"{number(measured[key])}   ({number(perspective)})")
    share = measured["share_above_1"]
    _row(box, "Above 1", "–" if share is None else f"{100 * share:.1f} % of pixels")


def _truth(layout: bpy.types.UILayout, truth: dict[str, object]) -> None:
    box = layout.box().column(align=True)
    box.label(text="Against rays (% of lit-facing pixels)")
    for key, label in (("misclassified_pct", "Wrong"), ("acne_pct", "Acne"), ("leak_pct", "Leaks")):
        _row(box, label, number(truth[key], " %"))
    _row(box, "Edges off, median", number(truth["edge_px_median"], " px"))
    _row(box, "Edges off, 95 %", number(truth["edge_px_p95"], " px"))
    for part in truth["partitions"] if len(truth["partitions"]) > 1 else ():
        _row(box, f"Map {part['index'] + 1} wrong", number(part["misclassified_pct"], " %"))


def _partition(layout: bpy.types.UILayout, part: dict[str, object]) -> None:
    box = layout.box().column(align=True)
    box.label(text=f"Map {part['index'] + 1}: {number(part['near'])} … {number(part['far'], ' m')}")
    warp = "uniform" if part["warp_parameter"] is None else number(part["warp_parameter"], " m")
    _row(box, "n'", warp)
    _row(box, "η", number(part["eta"]))
    _row(box, "M_x, M_z", f"{number(part['m_x_max'])}, {number(part['m_z_max'])}")
    _row(box, "S", number(part["storage_factor"]))


MEANINGS = (
    "m: picture pixels that one texel of the shadow map covers. 1 is ideal; above 1 edges look jagged, below 1 texels are wasted. "
    "In brackets the part that warps and partitions treat, without the slope of the surface",
    "γ: angle between light and view. Below γ_lim warps fade",
    "n': how far before its near plane a map's warp has its apex: the nearer, the stronger. η says the same: −1 is no warp, 1 that of PSM",
    "M_x, M_z: the largest m that theory predicts for the map, across and along the view. S is their product: texels needed per pixel",
    "Wrong, acne, leaks: pixels in shadow or light against ray tracing",
)


OLD = "From before a change of the scene or its settings: Analyse CAD Shadows makes the numbers anew"


class CAD_SHADOW_PT_sidebar_quality_words(bpy.types.Panel):
    """What the numbers of the panel Quality mean."""

    bl_label = "What the Numbers Mean"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB
    bl_parent_id = "CAD_SHADOW_PT_sidebar_quality"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """One paragraph each."""
        for meaning in MEANINGS:
            paragraph(self.layout, context, meaning)


class CAD_SHADOW_PT_sidebar_quality(bpy.types.Panel):
    """What the last preview or analysis found; the number in brackets is the perspective part alone, which warps and partitions treat."""

    bl_label = "Quality"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB
    bl_order = ORDER_OF_QUALITY

    def draw(self, context: bpy.types.Context) -> None:
        """List the last report."""
        layout, outcome = self.layout, session.last()
        if outcome is None:
            paragraph(layout, context, "Press CAD Shadow Preview or Analyse: the numbers of its shadows are listed here", "INFO")
            return
        if not session.is_last_current(context.scene):
            paragraph(layout, context, OLD, "INFO")
        layout.prop(context.window_manager, "cad_shadow_graph", icon="FCURVE", toggle=True)
        report = outcome.report
        column = layout.column(align=True)
        _row(column, "γ", number(report["gamma_deg"], "°"))
        _row(column, "γ_lim", number(report["gamma_lim_deg"], "°"))
        _row(column, "Time", duration(report["timing_ms"]["total"]))
        _row(column, "Triangles", f"{report['geometry']['triangles']:,}")
        if report["measured"]:
            _measured(layout, report["measured"])
        if "truth" in report:
            _truth(layout, report["truth"])
        for part in report["partitions"]:
            _partition(layout, part)
        for warning in report["warnings"]:
            paragraph(layout, context, warning, "ERROR")


def register() -> None:
    """Show the panels."""
    bpy.utils.register_class(CAD_SHADOW_PT_sidebar_quality)
    bpy.utils.register_class(CAD_SHADOW_PT_sidebar_quality_words)


def unregister() -> None:
    """Remove the panels."""
    bpy.utils.unregister_class(CAD_SHADOW_PT_sidebar_quality_words)
    bpy.utils.unregister_class(CAD_SHADOW_PT_sidebar_quality)
