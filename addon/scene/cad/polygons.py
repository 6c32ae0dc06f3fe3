"""Polygons of three-dimensional corners cut into triangles: fans where that is right, ears clipped where a polygon is not convex.

Holes come as the formats know them: one ring that runs along a bridge to the hole, around it and back.
"""

from __future__ import annotations

import numpy as np

from .ears import ears_clipped


def triangulate(corners: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles (T, 3) of corner numbers, and (T,) the polygon of each; a planar one that does not cross itself is covered once.

    `corners` (C, 3) the points of all polygons one after the other, `sizes` (P,) how many belong to each. Polygons of fewer than three
    corners give nothing.
    """
    firsts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    polygon = np.repeat(np.arange(len(sizes)), counts)
    step = np.arange(len(polygon)) - np.repeat(np.cumsum(counts) - counts, counts)
    start = firsts[polygon]
    triangles = np.stack([start, start + step + 1, start + step + 2], axis=1)
    if len(triangles) and (sizes > 3).any():
        for p in _not_convex(corners, triangles, polygon, sizes):
            own = slice(firsts[p], firsts[p] + sizes[p])
            triangles[polygon == p] = firsts[p] + ears_clipped(_in_plane(corners[own]).tolist())
    return triangles, polygon


def _not_convex(corners: np.ndarray, triangles: np.ndarray, polygon: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Polygons in whose fan a triangle is turned against the others. Those with a corner that is not finite are left as they are."""
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    with np.errstate(invalid="ignore", over="ignore", under="ignore"):
        cross = np.cross(b - a, c - a)
        total = np.stack([np.bincount(polygon, cross[:, k], len(sizes)) for k in range(3)], axis=1)
        along = np.einsum("ij,ij->i", cross, total[polygon])
        limit = -1e-9 * np.einsum("ij,ij->i", total, total)[polygon]
        return np.unique(polygon[(along < limit) & (sizes[polygon] > 3)])


def _in_plane(points: np.ndarray) -> np.ndarray:
    """(n, 2) coordinates in the polygon's plane, counterclockwise: the two axes across its Newell normal."""
    following = np.roll(points, -1, axis=0)
    normal = np.cross(points - points[0], following - points[0]).sum(axis=0)
    drop = int(np.abs(normal).argmax())
    keep = [(1, 2), (2, 0), (0, 1)][drop]
    flat = points[:, keep]
    return flat if normal[drop] > 0 else flat * [-1, 1]
