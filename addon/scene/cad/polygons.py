"""Polygons of three-dimensional corners cut into triangles: fans where that is right, ears clipped where a polygon is not convex."""

from __future__ import annotations

import numpy as np


def triangulate(corners: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Claim: `triangles` (T, 3) of corner numbers and `polygon` (T,) the polygon of each; a simple planar polygon is covered exactly once.

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
            triangles[polygon == p] = firsts[p] + _ears_clipped(corners[own])
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


def _ears_clipped(points: np.ndarray) -> np.ndarray:
    """(n − 2, 3) corner numbers of one simple polygon (n, 3), by clipping ears in the plane it lies in."""
    flat = _in_plane(points)
    left = list(range(len(flat)))
    out = []
    while len(left) > 3:
        ear = next((i for i in range(len(left)) if _is_ear(flat, left, i)), 0)
        out.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return np.array([*out, tuple(left)])


def _in_plane(points: np.ndarray) -> np.ndarray:
    """(n, 2) coordinates in the polygon's plane, counterclockwise: the two axes across its Newell normal."""
    following = np.roll(points, -1, axis=0)
    normal = np.cross(points - points[0], following - points[0]).sum(axis=0)
    drop = int(np.abs(normal).argmax())
    keep = [(1, 2), (2, 0), (0, 1)][drop]
    flat = points[:, keep]
    return flat if normal[drop] > 0 else flat * [-1, 1]


def _is_ear(flat: np.ndarray, left: list[int], i: int) -> bool:
    """Whether the corner is convex and no other corner lies in its triangle."""
    a, b, c = flat[left[i - 1]], flat[left[i]], flat[left[(i + 1) % len(left)]]
    if _side(a, b, c) <= 0.0:
        return False
    others = flat[[k for k in left if k not in (left[i - 1], left[i], left[(i + 1) % len(left)])]]
    inside = (_side(a, b, others.T) >= 0) & (_side(b, c, others.T) >= 0) & (_side(c, a, others.T) >= 0)
    return not bool(inside.any())


def _side(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Twice the signed area of a, b, p: positive when p lies left of a → b."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
