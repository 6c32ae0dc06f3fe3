"""How far a point is from triangles. No GPU."""

from __future__ import annotations

import numpy as np


def distance_to_triangles(point: np.ndarray, corners: np.ndarray) -> float:
    """Metres from a point (3,) to the nearest of T triangles (T, 3, 3), float64; ∞ to none.

    Only triangles whose boxes come nearer than the nearest corner are looked at closely.
    """
    if not len(corners):
        return np.inf
    out = np.asarray(corners, np.float64) - point
    best = float(np.sqrt(np.square(out).sum(axis=-1).min()))
    gap = np.maximum(np.maximum(out.min(axis=1), -out.max(axis=1)), 0.0)
    near = out[np.square(gap).sum(axis=-1) < best * best]
    edges = [_to_segments(near[:, i], near[:, i - 1]) for i in range(3)]
    return min(best, *(float(d.min(initial=np.inf)) for d in (*edges, _to_insides(near))))


def _to_segments(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(T,) from the origin to the segments between (T, 3) and (T, 3)."""
    along = b - a
    length = np.maximum(np.square(along).sum(axis=-1), 1e-300)
    share = np.clip(-(a * along).sum(axis=-1) / length, 0.0, 1.0)
    return np.sqrt(np.square(a + share[:, None] * along).sum(axis=-1))


def _to_insides(corners: np.ndarray) -> np.ndarray:
    """(T,) from the origin to the planes of triangles (T, 3, 3) in which its foot lies inside; ∞ to the others."""
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    size = np.sqrt(np.square(normal).sum(axis=-1))
    sides = np.stack([(np.cross(p, q) * normal).sum(axis=-1) for p, q in ((a, b), (b, c), (c, a))])
    inside = (sides >= 0.0).all(axis=0) & (size > 0.0)
    return np.where(inside, np.abs((a * normal).sum(axis=-1)) / np.where(inside, size, 1.0), np.inf)
