"""Spatial order: Morton codes, clusters of large meshes, bounds, and which of them a view can see. Numpy only."""

from __future__ import annotations

import numpy as np

from ...maths.spaces import linear

CLUSTER_TRIANGLES = 8192
AT_ONCE = 1 << 14


def morton(points: np.ndarray) -> np.ndarray:
    """(P,) uint64 Morton codes of (P, 3) points, 21 bits per axis over their bounds."""
    low = points.min(axis=0).astype(np.float64)
    extent = np.maximum(points.max(axis=0) - low, 1e-30)
    code = np.zeros(len(points), np.uint64)
    for at in range(0, len(points), AT_ONCE):
        cells = ((points[at : at + AT_ONCE] - low) / extent * (2**21 - 1)).astype(np.uint64)
        for axis in range(3):
            code[at : at + AT_ONCE] |= _spread(cells[:, axis]) << np.uint64(axis)
    return code


def _spread(x: np.ndarray) -> np.ndarray:
    """Move bit i of 21-bit numbers to bit 3i."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x


def clustered(positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of a large mesh in spatial order, and the first triangle of each cluster (C,); small meshes come back as one cluster."""
    if len(triangles) <= CLUSTER_TRIANGLES:
        return triangles, np.zeros(1, np.int64)
    order = np.argsort(morton(positions[triangles[:, 0]]), kind="stable")
    return triangles[order], np.arange(0, len(triangles), CLUSTER_TRIANGLES)


def longest_edge(corners: np.ndarray) -> np.ndarray:
    """(T,) length of the longest edge of triangles (T, 3, 3)."""
    return np.sqrt(_squared_edges(corners))


def _squared_edges(corners: np.ndarray) -> np.ndarray:
    return np.square(corners - np.roll(corners, 1, axis=1)).sum(axis=2).max(axis=1)


def frustum_planes(clip_from_world: np.ndarray, cull_near: bool = True) -> np.ndarray:
    """(P, 4) planes with plane·(x, 1) ≥ 0 inside the clip volume of a matrix.

    `cull_near` False leaves out the near plane: casters between a light and its map's near plane are drawn by depth clamp.
    """
    rows = np.asarray(clip_from_world, dtype=np.float64)
    planes = [rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1], rows[3] - rows[2]]
    return np.stack([*planes, rows[3] + rows[2]] if cull_near else planes)


def visible(bounds_ws: np.ndarray, planes: np.ndarray) -> np.ndarray:
    """(B,) bool: False only for boxes wholly outside one of the planes (conservative; float64)."""
    return visible_boxes(0.5 * (bounds_ws[:, 0] + bounds_ws[:, 1]), 0.5 * (bounds_ws[:, 1] - bounds_ws[:, 0]), planes)


def visible_boxes(centre: np.ndarray, half: np.ndarray, planes: np.ndarray) -> np.ndarray:
    """`visible` of boxes by their centres and halves (B, 3)."""
    reach = linear(planes[:, :3], centre.T) + planes[:, 3:] + linear(np.abs(planes[:, :3]), half.T)
    return (reach >= 0.0).all(axis=0)


def runs(mask: np.ndarray, first: np.ndarray, count: np.ndarray, barriers: np.ndarray | None, max_gap: int) -> list[tuple[int, int]]:
    """Draw calls (first, count) that cover every range with a True mask; ranges are sorted by `first`.

    Masked-out ranges, and what lies between ranges, of at most `max_gap` indices in all are drawn along when they lie between two visible
    ones with the same number in `barriers`, because a call costs more than they do.
    """
    chosen = np.flatnonzero(mask)
    if not len(chosen):
        return []
    starts, ends = first[chosen], first[chosen] + count[chosen]
    breaks = starts[1:] - ends[:-1] > max_gap
    if barriers is not None:
        breaks |= barriers[chosen][1:] != barriers[chosen][:-1]
    breaks = np.flatnonzero(breaks)
    begin = starts[np.concatenate([[0], breaks + 1])]
    stop = ends[np.concatenate([breaks, [len(ends) - 1]])]
    return list(zip(begin.tolist(), (stop - begin).tolist(), strict=True))
