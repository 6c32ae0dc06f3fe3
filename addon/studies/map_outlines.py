"""Where the shadow maps lie in the world, as line segments: the view frustum, its splits, and the volume of every map. numpy only.

Points are relative to the scene's local origin, like the plan they come from.
"""

from __future__ import annotations

import numpy as np

from ..images.passes import id_colors
from ..maths.frusta import frustum_corners, hexahedron
from ..maths.shadow.lookup import unproject
from ..maths.shadow.projection import ShadowPlan, ShadowProjection
from ..maths.view import Camera

_RING = ((0, 1), (1, 3), (3, 2), (2, 0))  # the corners 2 y + x of a quad, round it


def map_color(index: int) -> tuple[float, float, float]:
    """The display colour 0…1 of map `index`, that of the partition pass's picture."""
    return tuple((id_colors(np.array([index]))[0] / 255.0).tolist())


def section(camera: Camera, depth: float) -> np.ndarray:
    """(4, 2, 3) segments round the view frustum's cross-section at a view depth."""
    corners = frustum_corners(camera, depth, depth + max(1e-6, 1e-6 * abs(depth)))[:4] + camera.eye_ws
    return corners[np.array(_RING)]


def frustum_sides(camera: Camera, near: float, far: float) -> np.ndarray:
    """(4, 2, 3) segments along the view frustum's edges from `near` to `far`."""
    corners = frustum_corners(camera, near, far) + camera.eye_ws
    return np.stack([corners[:4], corners[4:]], axis=1)


def split_sections(camera: Camera, plan: ShadowPlan) -> list[tuple[int, np.ndarray]]:
    """(map index, (S, 2, 3) segments) per map: the edges of the part of the view frustum whose receivers it serves."""
    found = []
    for i, p in enumerate(plan.projections):
        near, far = max(p.near, camera.near), min(p.far, camera.far)
        if near < far and not p.is_empty:
            found.append((i, part_edges(camera, p, near, far)))
    return found


def part_edges(camera: Camera, projection: ShadowProjection, near: float, far: float) -> np.ndarray:
    """(S, 2, 3) segments: the edges of what a map's planes leave of the view frustum between two view depths."""
    planes = projection.region_planes_ws.copy()
    planes[:, 3] += planes[:, :3] @ camera.eye_ws
    body = hexahedron(frustum_corners(camera, near, far)).clipped(planes)
    edges = {tuple(sorted(pair)) for face in body.faces for pair in zip(face, (*face[1:], face[0]), strict=True)}
    return np.array(sorted(edges)).reshape(-1, 2, 3) + camera.eye_ws


def map_volume(projection: ShadowProjection) -> np.ndarray:
    """(12, 2, 3) segments: the edges of what one map covers, s, t, depth ∈ [−1, 1] in the world."""
    t, depth, s = np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0], indexing="ij")
    corners = unproject(projection, s.ravel(), t.ravel(), depth.ravel())
    pairs = [(i, i | bit) for bit in (1, 2, 4) for i in range(8) if not i & bit]
    return corners[np.array(pairs)]


def map_volumes(plan: ShadowPlan) -> list[tuple[int, np.ndarray]]:
    """(map index, (12, 2, 3) segments) of every map that serves a receiver."""
    return [(i, map_volume(p)) for i, p in enumerate(plan.projections) if not p.is_empty]
