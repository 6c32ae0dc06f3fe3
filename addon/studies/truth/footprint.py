"""How far one shadow-map texel reaches over the picture, in pixels: its longest extent, pixel by pixel, from the plan itself in float64.

Not the error m of the report (an area, `aliasing` pass): a texel of m = 1 may be a thousand pixels long and a thousandth wide, and within
its length an edge may be misplaced.
"""

from __future__ import annotations

import numpy as np

from ...maths.shadow.projection import ShadowPlan, ShadowProjection
from ...maths.view import Camera
from .tracer import Truth, camera_rays

STEP_PX = 0.25
SMALLEST_W = 1e-9


def texel_coordinates(projection: ShadowProjection, points_ws: np.ndarray, map_size: int) -> np.ndarray:
    """(K, 2) texel coordinates 0…N of K points with w > 0, the logarithmic step included (see `LogWarp`)."""
    clip = points_ws @ projection.clip_from_world[:, :3].T + projection.clip_from_world[:, 3]
    w = np.maximum(clip[:, 3], SMALLEST_W)
    s, t = clip[:, 0] / w, clip[:, 1] / w
    log = projection.log
    if log is not None:
        s = s if log.perspective_s else clip[:, 0]
        t = log.t_at(w)
    return (np.stack([s, t], axis=-1) + 1.0) * (map_size / 2.0)


def _on_tangent_planes(camera: Camera, surface: Truth, pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Where the rays through K `pixels` meet the planes of K surface points; grazing rays as if 0.1° steep."""
    origins, directions, _ = camera_rays(camera, size, pixels)
    height = np.einsum("ij,ij->i", surface.point_ws - origins, surface.normal_ws)
    slope = np.minimum(np.einsum("ij,ij->i", directions, surface.normal_ws), -1.7e-3)
    return origins + directions * (height / slope)[:, None]


def texel_extent_px(
    surface: Truth, pixels: np.ndarray, camera: Camera, size: tuple[int, int], plan: ShadowPlan, partition: np.ndarray, map_size: int
) -> np.ndarray:
    """(K,) the longest extent of a texel's footprint in pixels: 1/σ_min of J = ∂(texel s, texel t)/∂(pixel x, pixel y) (method §1).

    `surface` K visible points at pixel coordinates `pixels` (K, 2) of a picture of `size`; `partition` (K,) the map that serves each
    (0 extent where none does). Central differences over half a pixel on the tangent plane.
    """
    extent = np.zeros(len(pixels))
    for index, projection in enumerate(plan.projections):
        served = partition == index
        if projection.is_empty or not served.any():
            continue
        points, columns = surface.at(served), []
        for step in np.eye(2) * STEP_PX:
            ends = (_on_tangent_planes(camera, points, pixels[served] + sign * step, size) for sign in (1.0, -1.0))
            after, before = (texel_coordinates(projection, end, map_size) for end in ends)
            columns.append((after - before) / (2.0 * STEP_PX))
        extent[served] = 1.0 / np.maximum(smallest_singular_value(np.stack(columns, axis=-1)), 1e-6)
    return extent


def smallest_singular_value(matrices: np.ndarray) -> np.ndarray:
    """(K,) of (K, 2, 2) matrices, in the closed form σ_min = |√(E² + H²) − √(F² + G²)|."""
    a, b, c, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 0], matrices[:, 1, 1]
    return 0.5 * np.abs(np.hypot(a + d, c - b) - np.hypot(a - d, c + b))
