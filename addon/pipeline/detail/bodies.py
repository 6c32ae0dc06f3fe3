"""The connected bodies of a mesh: whether a coarser mesh still has all of them, as thick and as closed. Numpy only."""

from __future__ import annotations

import numpy as np

MOST_LOST = 0.1  # of a body's area and volume
FLAT = 1e-3  # of its area to the power 3/2: a volume that is as good as none


class Bodies:
    """Bodies by the points that triangles join: `of_point` (V,), the area and volume of each, and whether no edge is open."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray) -> None:
        self.of_point = connected(len(points), triangles)
        self._count = int(self.of_point.max(initial=-1)) + 1
        self._origins = np.zeros((self._count, 3))
        self._origins[self.of_point] = points
        self._area, self._volume = self._measures(points, triangles, self.of_point)
        self._is_closed = is_closed(triangles)

    def are_kept(self, points: np.ndarray, triangles: np.ndarray, corner_of: np.ndarray) -> bool:
        """Whether every body is still there in a mesh whose corners those of this one have come to, `corner_of` (V,)."""
        of_corner = np.zeros(len(points), np.int64)
        of_corner[corner_of] = self.of_point
        area, volume = self._measures(points, triangles, of_corner)
        thin = np.abs(area - self._area) > MOST_LOST * self._area
        thin |= np.abs(volume - self._volume) > MOST_LOST * np.abs(self._volume) + FLAT * self._area**1.5
        return not thin.any() and (not self._is_closed or is_closed(triangles))

    @np.errstate(under="ignore")
    def _measures(self, points: np.ndarray, triangles: np.ndarray, of_point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(B,) area, and volume between each body's surface and a point of it."""
        body = of_point[triangles[:, 0]]
        a, b, c = (points[triangles[:, k]] - self._origins[body] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
        volume = np.einsum("tc,tc->t", a, np.cross(b, c)) / 6.0
        return np.bincount(body, area, self._count), np.bincount(body, volume, self._count)


def connected(count: int, triangles: np.ndarray) -> np.ndarray:
    """(V,) int64 the body of each of `count` points, numbered from 0: points of one triangle are of one body."""
    label = np.arange(count)
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]]).astype(np.int64)
    while True:
        a, b = label[ends[:, 0]], label[ends[:, 1]]
        apart = a != b
        if not apart.any():
            return np.unique(label, return_inverse=True)[1]
        np.minimum.at(label, np.maximum(a, b)[apart], np.minimum(a, b)[apart])
        while (label[label] != label).any():
            label = label[label]


def is_closed(triangles: np.ndarray) -> bool:
    """Whether every edge between points is run through as often one way as the other."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    backwards = edges[:, 0] > edges[:, 1]
    key = edges.min(axis=1) << 32 | edges.max(axis=1)
    order = np.argsort(key)
    begins = np.flatnonzero(np.diff(key[order], prepend=-1))
    return not np.add.reduceat(np.where(backwards, -1, 1)[order], begins).any()
