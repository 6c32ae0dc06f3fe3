"""What turns up from behind the outline of a relief texture as the eye moves: edges for the edge sum of `relief_edges.py`. No GPU.

A depth edge counts what comes into view behind a step between two texels. A side that stands edge-on, or the far side of a hollow thing,
has no texel at all; what tells of it is the last surface that the rays near the outline meet. Our own (docs/findings.md, *Impostors*).
"""

from __future__ import annotations

import numpy as np

from .relief import CaptureFrame, relief_from_depth, shift_unit

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
    u, v, covered = _lines_inwards(frame, depth, mask, outline)
    front, behind, deep = (np.abs(relief_from_depth(frame.source, d[v, u])) / shift_unit(frame) for d in (depth, back, last))
    near, far = _at_the_outline(front[:, :2], deep[:, :2], covered[:, 1])
    along = np.array([-0.5, *range(WIDEST + 1)])
    deep = np.column_stack([far, np.where(covered, deep, -np.inf)])
    line, begin, end = hull_pieces(deep, along).T
    middle, rest = (along[begin] + along[end]) / 2.0, along[end] - along[begin]
    width, solid = covered.sum(axis=1), np.where(covered, behind, 0.0).max(axis=1)
    deepest = far.copy()
    np.maximum.at(deepest, line, deep[line, end])
    ended = np.flatnonzero((width <= WIDEST) & (solid < deepest))
    parts = (
        (outline, -0.5, near, far, 0.0, 1.0),
        (outline[line], middle, deep[line, begin], deep[line, end], rest, 1.0),
        (outline[ended], width[ended] / 2.0 - 0.5, solid[ended], deepest[ended], width[ended], -1.0),
    )
    return np.concatenate([_edges_along(frame, *part) for part in parts])


def _lines_inwards(
    frame: CaptureFrame, depth: np.ndarray, mask: np.ndarray, outline: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(u, v, covered), each (P, WIDEST + 1): the texels inwards from the outline's pairs, and whether they still are of the same part."""
    start = np.floor(outline[:, :2] + outline[:, 2:4] / 2.0).astype(int)
    place = start[:, None] + outline[:, None, 2:4].astype(int) * np.arange(WIDEST + 1)[:, None]
    limit = np.array([frame.width, frame.height])
    inside = ((place >= 0) & (place < limit)).all(axis=2)
    u, v = np.clip(place, 0, limit - 1).transpose(2, 0, 1)
    covered = inside & mask[v, u]
    covered[:, 1:] &= np.diff(depth[v, u], axis=1) <= STEEPEST * frame.texel_m
    return u, v, np.logical_and.accumulate(covered, axis=1)


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


def hull_pieces(deep: np.ndarray, along: np.ndarray) -> np.ndarray:
    """(H, 3) line, begin, end of the pieces at 45° or steeper of the upper hulls of the profiles `deep` (P, n) at the places `along` (n,).

    Rising places; a profile begins at its hull's first corner; −inf is no surface.
    """
    pieces = [np.empty((0, 3), int)]
    line, at = np.arange(len(deep)), np.zeros(len(deep), int)
    while len(line):
        ahead = along - along[at][:, None]
        rise = deep[line] - deep[line, at][:, None]
        slope = np.where(ahead > 0.0, rise / np.where(ahead > 0.0, ahead, 1.0), -np.inf)
        end = slope.argmax(axis=1)
        going = slope[np.arange(len(line)), end] >= 1.0
        line, at, end = line[going], at[going], end[going]
        pieces.append(np.column_stack([line, at, end]))
        at = end
    return np.concatenate(pieces)
