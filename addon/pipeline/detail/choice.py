"""Which coarser casters a map may be drawn with: those whose error stays below a part of its texels. Numpy only."""

from __future__ import annotations

import numpy as np

from ...maths.shadow.projection import ShadowProjection


def texels_per_metre(projection: ShadowProjection, size: int, bounds_ws: np.ndarray, is_sun: bool) -> np.ndarray:
    """(B,) at most so many texels does a map of `size` texels give a metre inside each box (B, 2, 3); ∞ where that is not bounded.

    s = P₀x / P₃x, so that |∇s| = |P₀ − s P₃| / P₃x, which is largest at s = ±1 and where P₃x, the divisor w, is least. Under a sun nothing
    that the map shows has a smaller w than its own corners.
    """
    if projection.log is not None:
        return np.full(len(bounds_ws), np.inf)
    rows = projection.clip_from_world
    centre, half = bounds_ws.mean(axis=1), (bounds_ws[:, 1] - bounds_ws[:, 0]) / 2.0
    least = centre @ rows[3, :3] + rows[3, 3] - half @ np.abs(rows[3, :3])
    if is_sun:
        corners = np.stack(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0], [1.0], indexing="ij"), axis=-1).reshape(-1, 4)
        inverse = (corners @ np.linalg.inv(rows).T)[:, 3]
        least = np.maximum(least, 1.0 / inverse.max() if inverse.min() > 0.0 else 0.0)
    steepest = [max(np.linalg.norm(rows[axis, :3] - s * rows[3, :3]) for s in (-1.0, 1.0)) for axis in (0, 1)]
    per_metre = 0.5 * size * float(np.hypot(*steepest))
    return np.where(least > 0.0, per_metre / np.where(least > 0.0, least, 1.0), np.inf)


def coarsest(errors_m: np.ndarray, begins: np.ndarray, counts: np.ndarray, allowed_m: np.ndarray) -> np.ndarray:
    """(I,) int64 the last of each instance's levels, `counts` (I,) of them from `begins` (I,) on in `errors_m` (L,), whose error is allowed
    (I,); −1 where none is."""
    allowed = np.where(errors_m <= np.repeat(allowed_m, counts), np.arange(len(errors_m)), -1)
    out = np.full(len(counts), -1, np.int64)
    some = counts > 0
    if some.any():
        out[some] = np.maximum.reduceat(allowed, begins[some])
    return out
