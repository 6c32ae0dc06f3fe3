"""The legend of a live view that shows data: made once per picture's kind, drawn over everything."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from ...maths.shadow.projection import ShadowPlan
from ...studies.legends import Legend, legend_of
from ..textures import texture_of
from ..viewport import LiveView
from .canvas import DIM, Canvas


class LiveLegend:
    """The legend of one live view, kept while what it explains stays the same."""

    def __init__(self) -> None:
        self._of: tuple[str, ShadowPlan | None, float] | None = None
        self._legend: Legend | None = None
        self._texture: object | None = None
        self.placed: tuple[Legend, tuple[float, float]] | None = None  # what was drawn last, and where in the region

    def draw(self, canvas: Canvas, display: str, plan: ShadowPlan | None) -> None:
        """Draw the legend of a picture that shows `display`, made with `plan`, in the canvas's next box, where there is room for it."""
        self.placed = None
        if self._of is None or self._of[0] != display or self._of[1] is not plan or self._of[2] != canvas.scale:
            self._of, self._legend, self._texture = (display, plan, canvas.scale), legend_of(display, plan, canvas.scale), None
        legend = self._legend
        corner = canvas.place(*legend.size) if legend is not None else None
        if corner is None:
            return
        x, y = corner
        canvas.rectangle(x, y, *legend.size)
        self._texture = self._texture or texture_of(legend.colors)
        a, b, width, height = legend.colors_at
        canvas.image(self._texture, (x + a, y + b, width, height))
        canvas.segments([(x + px, y + py) for px, py in legend.marks], DIM)
        for word in legend.words:
            canvas.word(word.text, x + word.x, y + word.y, word.anchor)
        self.placed = legend, corner


_legends: WeakKeyDictionary[LiveView, LiveLegend] = WeakKeyDictionary()


def draw(canvas: Canvas, live: LiveView) -> None:
    """Draw the legend of what this live view shows."""
    _legends.setdefault(live, LiveLegend()).draw(canvas, *live.shows)


def clear() -> None:
    """Free the legends and their textures."""
    _legends.clear()
