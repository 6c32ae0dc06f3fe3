"""The graph of the error over depth: theory's lines in the maps' colours, the picture's band in white, the splits, the ideal m = 1."""

from __future__ import annotations

import numpy as np

from ...studies.error_graph import ErrorGraph, error_graph
from ...studies.map_outlines import map_color
from ...studies.run import Outcome
from .. import session
from .canvas import BACK, DIM, INK, Canvas

WIDTH, HEIGHT = 380, 246
LEFT, RIGHT, BOTTOM, TOP = 40, 12, 34, 56
LOG2_LOW, LOG2_HIGH = -4, 4
BAND = (1.0, 1.0, 1.0, 0.22)
_kept: list[tuple[Outcome, ErrorGraph | None]] = []  # of the outcome drawn last


def clear() -> None:
    """Drop the graph kept."""
    _kept.clear()


def _current() -> tuple[bool, ErrorGraph | None]:
    """Whether there is an outcome, and its graph; made once per outcome."""
    outcome = session.last()
    if outcome is None:
        return False, None
    if not _kept or _kept[0][0] is not outcome:
        _kept[:] = [(outcome, error_graph(outcome))]
    return True, _kept[0][1]


class _Plot:
    """From depth and m to pixels."""

    def __init__(self, canvas: Canvas, corner: tuple[float, float], graph: ErrorGraph) -> None:
        s = canvas.scale
        self.x, self.y = corner[0] + LEFT * s, corner[1] + BOTTOM * s
        self.width, self.height = (WIDTH - LEFT - RIGHT) * s, (HEIGHT - BOTTOM - TOP) * s
        self.graph = graph

    def points(self, z: np.ndarray, m: np.ndarray) -> list[tuple[float, float]]:
        """Pixels of the curve m(z), cut at the axis's ends."""
        level = np.clip(np.log2(np.maximum(m, 1e-9)), LOG2_LOW, LOG2_HIGH)
        along = self.x + self.graph.along(z) * self.width
        up = self.y + (level - LOG2_LOW) / (LOG2_HIGH - LOG2_LOW) * self.height
        return list(zip(along.tolist(), up.tolist(), strict=True))

    def at(self, z: float, m: float) -> tuple[float, float]:
        """Pixel of one point."""
        return self.points(np.array([z]), np.array([m]))[0]


def draw(canvas: Canvas) -> None:
    """Draw it in the canvas's next box."""
    there_is, graph = _current()
    s = canvas.scale
    corner = canvas.place(WIDTH * s, (HEIGHT if graph else 30) * s)
    if corner is None:
        return
    x, y = corner
    if graph is None:
        canvas.rectangle(x, y, WIDTH * s, 30 * s, BACK)
        text = "Error graph: this view has no error to show" if there_is else "Error graph: press Analyse (sidebar, CAD Shadow)"
        canvas.word(text, x + 12 * s, y + 10 * s)
        return
    canvas.rectangle(x, y, WIDTH * s, HEIGHT * s, BACK)
    plot = _Plot(canvas, corner, graph)
    _draw_axes(canvas, plot)
    _draw_measured(canvas, plot)
    for prediction in graph.predictions:
        color = (*map_color(prediction.index), 1.0)
        canvas.line(plot.points(prediction.z, prediction.m_x), color, 2.0)
        canvas.segments(plot.points(*_dashes(prediction.z, prediction.m_z)), color, 2.0)
    _draw_key(canvas, corner, bool(graph.predictions))


def _dashes(z: np.ndarray, m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every other stretch of a curve, as pairs of points."""
    first = np.arange(0, len(z) - 1, 2)
    pairs = np.stack([first, first + 1], axis=1).ravel()
    return z[pairs], m[pairs]


def _draw_axes(canvas: Canvas, plot: _Plot) -> None:
    graph, s = plot.graph, canvas.scale
    for level in range(LOG2_LOW, LOG2_HIGH + 1, 2):
        text = f"{2**level}" if level >= 0 else f"1/{2**-level}"
        left, right = plot.at(graph.near, 2.0**level), plot.at(graph.far, 2.0**level)
        canvas.segments([left, right], INK if level == 0 else DIM, 1.0)
        canvas.word(text, left[0] - 6 * s, left[1] - 4 * s, "right")
    for split in graph.splits:
        canvas.segments([plot.at(split, 2.0**LOG2_LOW), plot.at(split, 2.0**LOG2_HIGH)], DIM, 1.0)
    free_from = 0.0
    for z in graph.ticks():
        (x, y), text = plot.at(z, 2.0**LOG2_LOW), f"{z:g} m"
        canvas.segments([(x, y), (x, y - 4 * s)], INK, 1.0)
        half = 0.5 * canvas.width_of(text)
        if x - half >= free_from:  # far depths lie close together on a logarithmic axis
            canvas.word(text, x, y - 17 * s, "middle")
            free_from = x + half + 6 * s


def _draw_measured(canvas: Canvas, plot: _Plot) -> None:
    measured = plot.graph.measured
    low, high = plot.points(measured.z, measured.median), plot.points(measured.z, measured.p95)
    band = [corner for (a, b, c, d) in zip(low, low[1:], high, high[1:], strict=False) for corner in (a, b, d, a, d, c)]
    canvas.triangles(band, BAND)
    canvas.line(low, INK, 1.0)
    canvas.line(high, INK, 1.5)


def _draw_key(canvas: Canvas, corner: tuple[float, float], has_theory: bool) -> None:
    s = canvas.scale
    x, y = corner[0] + 10 * s, corner[1] + HEIGHT * s
    lines = ["m over view depth. White: median and 95 % of the pixels"]
    if has_theory:
        lines += ["Coloured, one map each, predicted:", "—  across the view (m_x)     - -  along the view (m_z)"]
    for i, text in enumerate(lines):
        canvas.word(text, x, y - (16 + 15 * i) * s)
