"""The area that a plane cuts out of a closed body, as triangles. numpy only.

A sweep: the ends of all cut lines divide the plane into strips; within one no line begins or ends, so the lines across it have one order,
and what lies between them is inside or outside by their winding number (or, without an orientation, by counting). Pieces between the same
two lines are joined over the strips. Nothing is chained into loops: holes, islands and parts that touch need no thought.
"""

from __future__ import annotations

import numpy as np

from .clip import crossings
from .closed import Solid

OVERLAP = 1e-7  # of the area's size, by which pieces reach over one another: else pixels between them would stay empty
MOST_CROSSINGS = 20_000_000  # of lines and strips


def cut_lines(body: Solid, height: np.ndarray) -> np.ndarray:
    """(S, 2, 3) float64 lines where the surface crosses height 0, each with the inside on the same hand where the body is oriented."""
    above = height > 0.0
    triangles = body.triangles[above[body.triangles].any(axis=1) & ~above[body.triangles].all(axis=1)]
    following = np.roll(triangles, -1, axis=1)
    up, down = ~above[triangles] & above[following], above[triangles] & ~above[following]
    ends = [
        crossings(body.points, height, np.take_along_axis(triangles, k, 1)[:, 0], np.take_along_axis(following, k, 1)[:, 0])
        for k in (up.argmax(axis=1)[:, None], down.argmax(axis=1)[:, None])
    ]
    return np.stack(ends, axis=1)


def area_triangles(lines: np.ndarray, is_oriented: bool) -> np.ndarray | None:
    """(K, 3, 2) triangles of what lines (S, 2, 2) in a plane enclose; None when there are more lines than can be swept.

    `is_oriented`: inside is where the winding number is not 0; else where an odd number of lines lies between it and the outside.
    """
    if not len(lines):
        return np.zeros((0, 3, 2))
    corner, size = lines.min(axis=(0, 1)), float(np.ptp(lines.reshape(-1, 2), axis=0).max())
    if not size > 0.0:
        return np.zeros((0, 3, 2))
    scaled = (lines - corner) / size
    scaled[..., 1] = np.rint(scaled[..., 1] * 2.0**40) / 2.0**40  # ends that differ by rounding only begin no strip
    pieces = _pieces(scaled, is_oriented)
    return None if pieces is None else _triangles(pieces) * size + corner


def _pieces(lines: np.ndarray, is_oriented: bool) -> np.ndarray | None:
    """(K, 4, 2) pieces between two lines and two heights: lower left, lower right, upper right, upper left."""
    rising = lines[:, 1, 1] > lines[:, 0, 1]
    low = np.where(rising[:, None], lines[:, 0], lines[:, 1])
    high = np.where(rising[:, None], lines[:, 1], lines[:, 0])
    steep = high[:, 1] > low[:, 1]
    low, high, turn = low[steep], high[steep], np.where(rising[steep], 1, -1)
    levels = np.unique(np.concatenate([low[:, 1], high[:, 1]]))
    first, last = np.searchsorted(levels, low[:, 1]), np.searchsorted(levels, high[:, 1])
    count = last - first
    if int(count.sum()) > MOST_CROSSINGS:
        return None
    slope = (high[:, 0] - low[:, 0]) / (high[:, 1] - low[:, 1])
    line = np.repeat(np.arange(len(low)), count)
    strip = np.arange(len(line)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
    middle = 0.5 * (levels[strip] + levels[strip + 1])
    order = np.lexsort((low[line, 0] + (middle - low[line, 1]) * slope[line], strip))
    line, strip = line[order], strip[order]
    left, right, strip = _between(line, strip, turn, is_oriented)
    return _joined(left, right, strip, levels, low, slope)


def _between(line: np.ndarray, strip: np.ndarray, turn: np.ndarray, is_oriented: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The line to the left and to the right of every inside piece, and its strip. A strip that does not come out even has none."""
    if not len(line):
        return line, line, strip
    begins = np.append(True, strip[1:] != strip[:-1])
    start = np.maximum.accumulate(np.where(begins, np.arange(len(line)), 0))
    if is_oriented:
        total = np.cumsum(turn[line])
        inside = total - np.where(start > 0, total[start - 1], 0) != 0
    else:
        inside = (np.arange(len(line)) - start) % 2 == 0
    before = np.append(False, inside[:-1]) & ~begins
    ends = np.append(begins[1:], True)
    is_open = np.isin(strip, strip[ends & inside])
    opening, closing = np.flatnonzero(inside & ~before & ~is_open), np.flatnonzero(~inside & before & ~is_open)
    return line[opening], line[closing], strip[opening]


def _joined(left: np.ndarray, right: np.ndarray, strip: np.ndarray, levels: np.ndarray, low: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Pieces between the same two lines in strips that follow one another as one."""
    order = np.lexsort((strip, right, left))
    left, right, strip = left[order], right[order], strip[order]
    new = np.ones(len(left), bool)
    new[1:] = (left[1:] != left[:-1]) | (right[1:] != right[:-1]) | (strip[1:] != strip[:-1] + 1)
    first = np.flatnonzero(new)
    last = np.append(first[1:], len(left))[: len(first)] - 1
    left, right = left[first], right[first]
    bottom, top = levels[strip[first]], levels[strip[last] + 1]

    def at(line: np.ndarray, y: np.ndarray, overlap: float) -> np.ndarray:
        return np.stack([low[line, 0] + (y - low[line, 1]) * slope[line], y + overlap], axis=-1)

    corners = [at(left, bottom, -OVERLAP), at(right, bottom, -OVERLAP), at(right, top, OVERLAP), at(left, top, OVERLAP)]
    return np.stack(corners, axis=1)


def _triangles(pieces: np.ndarray) -> np.ndarray:
    """(K, 3, 2) two triangles a piece, those without an area left out."""
    halves = np.concatenate([pieces[:, [0, 1, 2]], pieces[:, [0, 2, 3]]])
    one, two = halves[:, 1] - halves[:, 0], halves[:, 2] - halves[:, 0]
    return halves[np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) > 1e-14]
