"""Texts and numbers in a sidebar that is narrower than they are: broken into lines, never cut off."""

from __future__ import annotations

from collections.abc import Callable

import bpy

MARGINS_PX, ICON_PX = 64.0, 22.0  # of a sidebar at UI scale 1: its tabs, the panel's and a box's borders; an icon before a label
WITHOUT_REGION_PX = 280.0


def number(value: float | None, unit: str = "") -> str:
    """A number for a narrow panel: three significant digits; '–' for an unknown one."""
    if value is None:
        return "–"
    text = f"{value:.3g}" if abs(value) < 1e4 else f"{value:.2e}"
    return text + unit


def broken(text: str, width: float, measure: Callable[[str], float]) -> list[str]:
    """Lines of whole words, each as long as fits `width` by `measure`; a word too long for a line has one of its own."""
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and measure(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def paragraph(layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str = "NONE") -> None:
    """The text as labels one below the other, the icon before the first, within the width of the region that is being drawn."""
    import blf

    preferences = context.preferences
    scale = preferences.system.ui_scale or 1.0  # 0 without a window
    blf.size(0, preferences.ui_styles[0].widget.points * scale)
    width = context.region.width if context.region else WITHOUT_REGION_PX * scale
    room = width - (MARGINS_PX + (ICON_PX if icon != "NONE" else 0.0)) * scale
    column = layout.column(align=True)
    for i, line in enumerate(broken(text, room, lambda words: blf.dimensions(0, words)[0])):
        column.label(text=line, icon=icon if i == 0 or icon == "NONE" else "BLANK1")


def sharpness(measured: dict[str, object] | None) -> str | None:
    """What the measured error says in words, with the number behind it; None where nothing was measured."""
    error = measured and measured["m_p95"]
    if not error:
        return None
    size = f"{number(error)} pixels"
    if error <= 0.5:
        return f"Shadow edges are much sharper than a pixel ({size})"
    if error <= 1.0:
        return f"Shadow edges are sharper than a pixel ({size})"
    return f"Shadow edges are coarser than a pixel ({size}): choose a higher Quality"
