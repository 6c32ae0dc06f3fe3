"""Triangles cut by a plane: what lies behind it stays. numpy only.

A corner exactly in the plane counts as behind it. That is the cut by a plane an infinitesimal step further along its normal, and so the
same for all triangles that meet there: no gap opens, no part is cut twice.
"""

from __future__ import annotations

import numpy as np

SNAP = 1e-6  # of the mesh's size: corners so near to the plane lie in it


def heights(positions: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """(V,) float64 height of `positions` (V, 3) over the plane (4,), in lengths of its normal; 0 for those in it."""
    height = positions.astype(np.float64) @ plane[:3] + plane[3]
    if len(height):
        size = float((positions.max(axis=0) - positions.min(axis=0)).max()) * float(np.linalg.norm(plane[:3]))
        height[np.abs(height) <= SNAP * size] = 0.0
    return height


def crossings(points: np.ndarray, height: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(E, 3) float64 where edges from `start` to `end` (E,) cross height 0; the same place whichever way an edge is given."""
    a, b = np.minimum(start, end), np.maximum(start, end)
    share = height[a] / (height[a] - height[b])
    return points[a] + share[:, None] * (points[b].astype(np.float64) - points[a])


def clipped(
    positions: np.ndarray, normals: np.ndarray, triangles: np.ndarray, height: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The triangles with `height` ≤ 0, those across it cut: positions, unit normals, triangles. Corners no triangle has any more are gone.

    `height` (V,) over the plane. The corners in the cut are shared by the triangles that shared the edge.
    """
    above = height > 0.0
    count = above[triangles].sum(axis=1)
    mixed = triangles[(count == 1) | (count == 2)]
    single = _turned(mixed, above)  # the corner that is alone on its side comes first
    is_kept = ~above[single[:, 0]]  # the lone corner stays: a triangle stays; else a quadrilateral
    keys = np.stack([single[:, [0, 1]], single[:, [0, 2]]], axis=1).reshape(-1, 2)
    edges, index = np.unique(np.sort(keys, axis=1), axis=0, return_inverse=True)
    index = index.reshape(-1, 2) + len(positions)
    a, b = edges[:, 0], edges[:, 1]
    new_positions = crossings(positions, height, a, b)
    share = (height[a] / (height[a] - height[b]))[:, None]
    new_normals = normals[a] * (1.0 - share) + normals[b] * share
    new_normals /= np.maximum(np.linalg.norm(new_normals, axis=1, keepdims=True), 1e-12)
    p, q, lone, one, two = index[:, 0], index[:, 1], single[:, 0], single[:, 1], single[:, 2]
    faces = np.concatenate(
        [
            triangles[count == 0],
            np.stack([lone, p, q], axis=1)[is_kept],
            np.stack([p, one, two], axis=1)[~is_kept],
            np.stack([p, two, q], axis=1)[~is_kept],
        ]
    )
    return _used(np.concatenate([positions, new_positions]), np.concatenate([normals, new_normals]), faces)


def _turned(triangles: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Triangles with corners on both sides, turned so that the one alone on its side comes first."""
    sides = above[triangles]
    lone = np.where((sides.sum(axis=1) == 1)[:, None], sides, ~sides).argmax(axis=1)
    return np.take_along_axis(triangles, (lone[:, None] + np.arange(3)) % 3, axis=1)


def _used(positions: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Only the corners that are used, and no triangle without an area: cutting at a corner leaves such."""
    corners = positions[triangles].astype(np.float64)
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.stack([one[:, i - 2] * two[:, i - 1] - one[:, i - 1] * two[:, i - 2] for i in range(3)], axis=1)
    longest = np.maximum((one * one).sum(axis=1), (two * two).sum(axis=1))
    triangles = triangles[np.sqrt((normal * normal).sum(axis=1)) > 1e-9 * longest]
    used, index = np.unique(triangles, return_inverse=True)
    return positions[used].astype(np.float32), normals[used].astype(np.float32), index.reshape(-1, 3).astype(np.int32)
