"""How far one shadow-map texel reaches over the picture, in pixels: its longest extent, pixel by pixel, from the plan itself in float64.

Not the error m of the report (an area, `aliasing` pass): a texel of m = 1 may be a thousand pixels long and a thousandth wide, and within
its length an edge may be misplaced.
"""

from __future__ import annotations

import numpy as np

from ..maths.projection import ShadowPlan, ShadowProjection
from ..maths.view import Camera
from .tracer import Truth, pixel_centres, pixel_rays

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
        t = log.scale * np.log2(w) + log.offset
    return (np.stack([s, t], axis=-1) + 1.0) * (map_size / 2.0)


def _on_tangent_plane(camera: Camera, truth: Truth, pixels: np.ndarray, seen: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Where the rays through `pixels` meet the planes of the surfaces seen at the pixels themselves; grazing rays as if 0.1° steep."""
    origins, directions, _ = pixel_rays(camera, size, pixels)
    point, normal = truth.point_ws.reshape(-1, 3)[seen], truth.normal_ws.reshape(-1, 3)[seen]
    height = np.einsum("ij,ij->i", point - origins, normal)
    slope = np.minimum(np.einsum("ij,ij->i", directions, normal), -1.7e-3)
    return origins + directions * (height / slope)[:, None]


def texel_extent_px(truth: Truth, camera: Camera, plan: ShadowPlan, partition: np.ndarray, map_size: int) -> np.ndarray:
    """(h, w) the longest extent of a texel's footprint in pixels: 1/σ_min of J = ∂(texel s, texel t)/∂(pixel x, pixel y) (method §1).

    Central differences over half a pixel on the tangent plane. 0 where no surface is seen or no partition serves the pixel.
    """
    height, width = truth.depth.shape
    extent = np.zeros(height * width)
    served = np.where(truth.object >= 0, partition, -1).ravel()
    centres = pixel_centres((width, height))
    for index, projection in enumerate(plan.projections):
        seen = served == index
        if projection.is_empty or not seen.any():
            continue
        columns = []
        for axis in (0, 1):
            step = np.zeros(2)
            step[axis] = STEP_PX
            ends = [_on_tangent_plane(camera, truth, centres[seen] + sign * step, seen, (width, height)) for sign in (1.0, -1.0)]
            after, before = (texel_coordinates(projection, points, map_size) for points in ends)
            columns.append((after - before) / (2.0 * STEP_PX))
        extent[seen] = 1.0 / np.maximum(smallest_singular_value(np.stack(columns, axis=-1)), 1e-6)
    return extent.reshape(height, width)


def smallest_singular_value(matrices: np.ndarray) -> np.ndarray:
    """(K,) of (K, 2, 2) matrices, in the closed form σ_min = |√(E² + H²) − √(F² + G²)|."""
    a, b, c, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 0], matrices[:, 1, 1]
    return 0.5 * np.abs(np.hypot(a + d, c - b) - np.hypot(a - d, c + b))
