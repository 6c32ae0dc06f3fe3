"""The legend of a live view that shows data. Its colours are drawn with the picture, its words later, over everything.

Blender's view transform changes what an engine draws; colours drawn in the same place are changed alike and stay comparable.
"""

from __future__ import annotations

from weakref import WeakSet

import bpy

from ..legends import Legend, legend_of
from ..maths.projection import ShadowPlan
from .canvas import Canvas, free_box, texture_of

_legends: WeakSet[LiveLegend] = WeakSet()


class LiveLegend:
    """The legend of one live view."""

    def __init__(self) -> None:
        self._of: tuple[str, ShadowPlan | None, float] | None = None
        self._legend: Legend | None = None
        self._texture: object | None = None
        self.placed: tuple[int, Legend, tuple[float, float]] | None = None  # the region, and where in it
        _legends.add(self)

    def draw_colors(self, context: bpy.types.Context, display: str, plan: ShadowPlan | None) -> None:
        """Draw the colours of the legend of a picture that shows `display`, made with `plan`, where there is room and it is wanted."""
        self.placed = None
        scale = context.preferences.system.ui_scale
        if self._of is None or self._of[0] != display or self._of[1] is not plan or self._of[2] != scale:
            self._of, self._legend, self._texture = (display, plan, scale), legend_of(display, plan, scale), None
        if self._legend is None or not (context.window_manager.cad_shadow_legend and context.space_data.overlay.show_overlays):
            return
        corner = Canvas(free_box(context.area, context.region), scale).place(*self._legend.size)
        if corner is None:
            return
        from gpu_extras.presets import draw_texture_2d  # not there without a window

        self._texture = self._texture or texture_of(self._legend.colors)
        x, y, width, height = self._legend.colors_at
        draw_texture_2d(self._texture, (corner[0] + x, corner[1] + y), width, height)
        self.placed = context.region.as_pointer(), self._legend, corner

    def close(self) -> None:
        """Free the texture; the words are drawn no more."""
        self._of = self._legend = self._texture = self.placed = None


def draw_words(canvas: Canvas, region: bpy.types.Region) -> None:
    """Draw the words in the canvas's next box, if the region's live view has drawn the colours there."""
    pointer = region.as_pointer()
    for shown in list(_legends):
        if shown.placed is None or shown.placed[0] != pointer:
            continue
        _, legend, (x, y) = shown.placed
        canvas.place(*legend.size)
        a, b, width, height = legend.colors_at
        canvas.frame((x, y, *legend.size), (x + a, y + b, width, height))
        for word in legend.words:
            canvas.word(word.text, x + word.x, y + word.y, word.anchor)
        return
