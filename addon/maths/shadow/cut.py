"""Triangles far larger than a shadow map's footprint, cut to it in float64: what is left of them, float32 can draw.

A rasteriser clips in float32. A triangle that reaches k times the footprint's size beyond it has clip coordinates of about k, so that what
is left of it is off by k · 2⁻²³ of the footprint, and by more where it passes the plane w = 0 of a warped map. In homogeneous clip
coordinates, before the division, the map's borders are planes, whatever the warp: cutting there is exact.
"""

from __future__ import annotations

import numpy as np

from .projection import ShadowProjection

LARGE = 64.0
"""Edges longer than so many units of clip coordinates at w = 1 (half a footprint) make a triangle large: its error is 2⁻¹⁷ of a map."""
LEAST_W = 0.5  # of the least w on the map: what lies nearer to the apex is off the map


def w_range(projection: ShadowProjection) -> tuple[float, float]:
    """Least and largest w of the points that the map shows, both > 0; ∞ where they go on for ever.

    1/w is affine in NDC, so its extremes lie at corners of the cube [−1, 1]³.
    """
    row = np.linalg.inv(projection.clip_from_world)[3]
    reach = float(np.abs(row[:3]).sum())
    if projection.log is not None:
        ends = projection.log.w_at(np.array([-1.0, 1.0]))
        return float(ends.min()), float(ends.max())
    least, most = row[3] - reach, row[3] + reach
    return 1.0 / most, 1.0 / least if least > 0.0 else np.inf


def reach(projection: ShadowProjection, longest_edge_m: float) -> float:
    """Units of clip coordinates that an edge spans at most, over the least w on the map: what `LARGE` is compared with."""
    return longest_edge_m * units_per_metre(projection) / w_range(projection)[0]


def units_per_metre(projection: ShadowProjection) -> float:
    """Units of clip x, y or w that a metre of the world is at most."""
    return float(np.linalg.norm(projection.clip_from_world[[0, 1, 3], :3], axis=1).max())


def are_large(projection: ShadowProjection, bounds_ws: np.ndarray, longest_edge_m: np.ndarray) -> np.ndarray:
    """(B,) bool: triangles in the boxes (B, 2, 3), with edges up to `longest_edge_m` (B,), may be too large for float32 in this map.

    Measured where they come nearest to the apex, but no nearer than the map does.
    """
    extent = units_per_metre(projection) * longest_edge_m
    low, high = w_range(projection)
    w, centre, half = projection.clip_from_world[3], bounds_ws.mean(axis=1), 0.5 * (bounds_ws[:, 1] - bounds_ws[:, 0])
    nearest = centre @ w[:3] + w[3] - half @ np.abs(w[:3])
    return extent > LARGE * np.clip(nearest, low, high)


def map_planes(projection: ShadowProjection, margin: float) -> np.ndarray:
    """(6, 5) planes p · (X, Y, Z, w, 1) ≥ 0 of what the map shows, `margin` NDC wider in s and t; open towards the light.

    The logarithmic step of t covers the strip of the projective Y/w; depth (and s of plain 'log') are not divided by w there.
    """
    by_w, by_one = np.array([0.0, 0.0, 0.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 1.0])
    log = projection.log
    s_limit = by_one if log is not None and not log.perspective_s else by_w
    x, y, z = np.eye(3, 5)
    wide, low = 1.0 + margin, w_range(projection)[0]
    return np.stack(
        [
            by_w - LEAST_W * low * by_one,
            wide * s_limit + x,
            wide * s_limit - x,
            wide * by_w + y,
            wide * by_w - y,
            (by_w if log is None else by_one) - z,
        ]
    )


def cut(corners: np.ndarray, planes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the planes leave of L triangles: triangles (F, 3, 4) in clip coordinates, and the row (F,) that each comes from.

    `corners` (L, 3, 4) float64, `planes` (P, 5). Sutherland–Hodgman for all at once. A point on an edge is made from its inner end, so that
    triangles that share the edge share the point to the last bit.
    """
    source = np.arange(len(corners))
    heights = _heights(corners, planes)
    reaches = (heights >= 0.0).any(axis=1).all(axis=-1)
    polygons, source = corners[reaches], source[reaches]
    counts = np.full(len(polygons), 3)
    for plane in planes:
        polygons, counts = _cut_once(polygons, counts, plane)
        kept = counts >= 3
        polygons, counts, source = polygons[kept], counts[kept], source[kept]
    return _fans(polygons, counts, source)


def _heights(points: np.ndarray, planes: np.ndarray) -> np.ndarray:
    return points @ planes[:, :4].T + planes[:, 4]


def _cut_once(polygons: np.ndarray, counts: np.ndarray, plane: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Polygons (L, M, 4) of `counts` (L,) points each, by one plane: (L, M + 1, 4) and their counts."""
    rows, most = polygons.shape[:2]
    place = np.arange(most)
    is_point = place < counts[:, None]
    following = np.where(place + 1 < counts[:, None], place + 1, 0)
    height = _heights(polygons, plane[None])[..., 0]
    next_height = np.take_along_axis(height, following, axis=1)
    is_inside, ends_inside = height >= 0.0, next_height >= 0.0
    crosses = is_point & (is_inside != ends_inside)
    next_point = np.take_along_axis(polygons, following[..., None], axis=1)
    inner, outer = (np.where(is_inside[..., None], *pair) for pair in ((polygons, next_point), (next_point, polygons)))
    inner_height, outer_height = np.where(is_inside, height, next_height), np.where(is_inside, next_height, height)
    share = np.where(crosses, inner_height / np.where(crosses, inner_height - outer_height, 1.0), 0.0)
    keeps = is_point & is_inside
    emitted = keeps.astype(int) + crosses
    start = np.cumsum(emitted, axis=1) - emitted
    out = np.zeros((rows, most + 1, 4))
    row = np.broadcast_to(np.arange(rows)[:, None], (rows, most))
    out[row[keeps], start[keeps]] = polygons[keeps]
    out[row[crosses], (start + keeps)[crosses]] = (inner + share[..., None] * (outer - inner))[crosses]
    return out, emitted.sum(axis=1)


def _fans(polygons: np.ndarray, counts: np.ndarray, source: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Convex polygons as triangles from their first point."""
    k = np.arange(1, max(polygons.shape[1] - 1, 1))
    row, k = np.nonzero(k + 1 < counts[:, None]) if len(polygons) else (np.empty(0, int), np.empty(0, int))
    k = k + 1
    return np.stack([polygons[row, 0], polygons[row, k], polygons[row, k + 1]], axis=1).reshape(-1, 3, 4), source[row]
