"""What turns up from behind the outline of a relief texture as the eye moves: edges for the edge sum of `edges.py`. No GPU.

A depth edge counts what comes into view behind a step between two texels. A side that stands edge-on, or the far side of a hollow thing,
has no texel at all; what tells of it is the last surface that the rays near the outline meet. Our own (docs/laboratory.md, *Impostors*).
"""

from __future__ import annotations

import numpy as np

from .warp import CaptureFrame, relief_from_depth, shift_unit

STEEPEST = 8.0
"""Texels of depth per texel up to which a run of steps is taken for a surface seen at a grazing angle (83°)."""
WIDEST = 64
"""Texels up to which a part counts as thin: it uncovers no more than its own width. So far inwards from the outline is looked."""


def behind_the_outline(
    frame: CaptureFrame, depth: np.ndarray, back: np.ndarray, last: np.ndarray, mask: np.ndarray, outline: np.ndarray
) -> np.ndarray:
    """(W, 8) edges of what turns up from behind the outline, from its pairs (P, 6): along the line inwards from each, the upper hull of the
    last surfaces, L(x) texels deep at x texels.

    By the view's turn y (a tangent) what lies at x has moved out by y·L(x) − x beyond the outline's place; the farthest out of all, the
    largest of these, is Σ max(0, y·ΔL − Δx) over the hull's pieces. A piece is kept while it falls away at 45° or more; flatter ones stay
    hidden within any useful tilt. The line ends with the part: outside the mask, or where its front steps back. Behind a thin part nothing
    is wider than the part is: then the negative end of the hidden follows, as behind a step (`_ends_of_the_hidden`).
    """
    place, stride, width = _lines_inwards(frame, depth, mask, outline)
    line, number, first = _numbered(width + 1)
    is_texel, x = number > 0, np.maximum(number - 1.0, -0.5)
    inwards = (place[line] + stride[line] * (number - 1))[is_texel]
    unit = shift_unit(frame)
    behind, inner = (np.abs(relief_from_depth(frame.source, d.ravel()[inwards])) / unit for d in (back, last))
    two = place[:, None] + stride[:, None] * np.stack([np.zeros_like(width), np.minimum(width - 1, 1)], axis=1)
    front, ends = (np.abs(relief_from_depth(frame.source, d.ravel()[two])) / unit for d in (depth, last))
    near, far = _at_the_outline(front, ends, width > 1)
    deep = np.empty(len(line))
    deep[is_texel], deep[first] = inner, far
    begin, end = hull_pieces(line, x, deep)
    deepest, solid = far.copy(), np.maximum.reduceat(behind, first - np.arange(len(first))) if len(first) else far
    np.maximum.at(deepest, line[end], deep[end])
    ended = np.flatnonzero((width <= WIDEST) & (solid < deepest))
    parts = (
        (outline, -0.5, near, far, 0.0, 1.0),
        (outline[line[begin]], (x[begin] + x[end]) / 2.0, deep[begin], deep[end], x[end] - x[begin], 1.0),
        (outline[ended], width[ended] / 2.0 - 0.5, solid[ended], deepest[ended], width[ended], -1.0),
    )
    return np.concatenate([_edges_along(frame, *part) for part in parts])


def _lines_inwards(
    frame: CaptureFrame, depth: np.ndarray, mask: np.ndarray, outline: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(place, stride, width), each (P,): the lines inwards from the outline's pairs as flat places in the images, their first texel and the
    way to the next, and how many texels, at most `WIDEST` + 1, still are of the same part."""
    inwards = outline[:, 2:4].astype(int)
    start = np.floor(outline[:, :2] + outline[:, 2:4] / 2.0).astype(int)
    place, stride = start @ [1, frame.width], inwards @ [1, frame.width]
    room = np.where(inwards < 0, start, np.where(inwards > 0, [frame.width - 1, frame.height - 1] - start, WIDEST)).min(axis=1)
    width, going = np.ones(len(outline), int), np.arange(len(outline))
    depth, mask, before = depth.ravel(), mask.ravel(), depth.ravel()[place]
    for reached in range(1, WIDEST + 1):
        going = going[room[going] >= reached]
        here = place[going] + stride[going] * reached
        goes_on = mask[here] & (depth[here] - before[going] <= STEEPEST * frame.texel_m)
        going, here = going[goes_on], here[goes_on]
        if not len(going):
            break
        width[going], before[going] = reached + 1, depth[here]
    return place, stride, width


def _numbered(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(owner, number, first): 0…count − 1 of each of `counts` one after the other, whose they are, and where each owner's begin."""
    first = np.cumsum(counts) - counts
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - first[owner], first


def _at_the_outline(front: np.ndarray, last: np.ndarray, goes_on: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(P,) front and last surface at the outline, less than a texel outside the first texel's middle, from those (P, 2) of two texels.

    Their distance squared is continued as a line: it stays where the side is flat and ends where a round thing's front and back meet. Each
    of the two goes the part of the way that it went from the second texel to the first.
    """
    apart = last - front
    squared = np.where(goes_on, 2.0 * apart[:, 0] ** 2 - apart[:, 1] ** 2, apart[:, 0] ** 2)
    closes = np.maximum(0.0, apart[:, 0] - np.sqrt(np.maximum(squared, 0.0)))
    recedes, comes = np.maximum(0.0, front[:, 0] - front[:, 1]), np.maximum(0.0, last[:, 1] - last[:, 0])
    share = recedes / np.maximum(recedes + comes, 1e-12)
    return front[:, 0] + share * closes, last[:, 0] - (1.0 - share) * closes


def _edges_along(
    frame: CaptureFrame, pairs: np.ndarray, x: np.ndarray | float, near: np.ndarray, far: np.ndarray, rest: np.ndarray | float, sign: float
) -> np.ndarray:
    """(P, 8) edges `x` texels inwards of the first texels' middles of outline pairs (P, 6); `near`, `far` |relief| in texels."""
    unit = shift_unit(frame) * (-1.0 if frame.is_perspective else 1.0)
    middle = pairs[:, :2] + pairs[:, 2:4] * (np.broadcast_to(x, len(pairs)) + 0.5)[:, None]
    return np.column_stack([middle, pairs[:, 2:4], near * unit, far * unit, np.broadcast_to(rest, len(pairs)), np.full(len(pairs), sign)])


def hull_pieces(line: np.ndarray, along: np.ndarray, deep: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(begin, end), each (H,): the points between which the pieces at 45° or steeper of the upper hulls of profiles run.

    A profile is the points (`along`, `deep`), each (n,), with the same `line`; they lie together, in the order of their rising places. A
    point below the line between its neighbours is no corner of the hull, whatever else is none: where none such is left, the rest is it.
    """
    kept = np.arange(len(line))
    while True:
        owner, x, y = line[kept], along[kept], deep[kept]
        between = (owner[2:] == owner[:-2]) & ((y[1:-1] - y[:-2]) * (x[2:] - x[:-2]) < (y[2:] - y[:-2]) * (x[1:-1] - x[:-2]))
        if not between.any():
            break
        kept = kept[np.concatenate([[True], ~between, [True]])]
    begin, end = kept[:-1], kept[1:]
    steep = (line[begin] == line[end]) & (deep[end] - deep[begin] >= along[end] - along[begin])
    return begin[steep], end[steep]
