"""Numpy oracles of the GPU passes: rays against every triangle, in float64. Slow and plain on purpose; small scenes only."""

from __future__ import annotations

import numpy as np

from addon.maths.shadow.lookup import project
from addon.maths.shadow.projection import ShadowProjection
from addon.maths.view import Camera, Light
from addon.scene.records import Scene


def world_corners(scene: Scene) -> np.ndarray:
    """(T, 3, 3) float64 world corners of all triangles, instance by instance."""
    out = []
    for row in range(len(scene.instances)):
        mesh = scene.meshes[scene.instances.mesh_index[row]]
        m = scene.instances.world_from_object[row]
        out.append((mesh.positions.astype(np.float64) @ m[:3, :3].T + m[:3, 3])[mesh.triangles])
    return np.concatenate(out)


def rasterise(corners_ndc: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Nearest depth at every cell centre, and how clearly it is decided.

    `corners_ndc` (T, 3, 3) already divided (x, y, z). Returns depth (h, w) (inf where nothing) and `margin` (h, w): distance in cells
    from the centre to the nearest edge of any triangle, so that a comparison can leave out centres that rounding may flip.
    """
    width, height = size
    x = (np.arange(width) + 0.5) * 2.0 / width - 1.0
    y = (np.arange(height) + 0.5) * 2.0 / height - 1.0
    depth = np.full((height, width), np.inf)
    margin = np.full((height, width), np.inf)
    for a, b, c in corners_ndc:
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        weights = []
        for p, q in ((b, c), (c, a), (a, b)):
            edge = (q[0] - p[0]) * (y[:, None] - p[1]) - (q[1] - p[1]) * (x[None, :] - p[0])
            length = np.hypot((q[0] - p[0]) * width / 2, (q[1] - p[1]) * height / 2)
            if length > 0.0:
                margin = np.minimum(margin, np.abs(edge) * (width * height / 4) / length)
            weights.append(edge)
        if abs(area) < 1e-14:
            continue
        inside = np.all([w * np.sign(area) >= 0.0 for w in weights], axis=0)
        z = sum(w * v[2] for w, v in zip(weights, (a, b, c), strict=True)) / area
        depth = np.where(inside, np.minimum(depth, z), depth)
    return depth, margin


def shadow_depth(scene: Scene, projection: ShadowProjection, size: int) -> tuple[np.ndarray, np.ndarray]:
    """(N, N) map depth 0…1 (1 where nothing, row 0 at t = −1) and the margin of `rasterise`; depth clamped as GL_DEPTH_CLAMP does."""
    s, t, d, _ = project(projection, world_corners(scene))
    depth, margin = rasterise(np.stack([s, t, d], axis=-1), (size, size))
    return np.where(np.isfinite(depth), np.clip(depth, -1.0, 1.0) * 0.5 + 0.5, 1.0), margin


def view_depth(scene: Scene, camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) view depth at pixel centres (inf where nothing; row 0 at the top) and the margin; every vertex must lie before the eye."""
    corners = world_corners(scene)
    clip = np.concatenate([corners, np.ones((*corners.shape[:2], 1))], axis=-1) @ camera.clip_from_world.T
    ndc = clip[..., :3] / clip[..., 3:]
    inverse = 1.0 / clip[..., 3]
    depth, margin = rasterise(np.concatenate([ndc[..., :2], -inverse[..., None]], axis=-1), size)
    return (np.where(np.isfinite(depth), -1.0 / depth, np.inf))[::-1], margin[::-1]


def first_hits(corners: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(R,) distance (inf = none) and triangle of the first hit of R rays with T triangles, by testing all in float64."""
    best, which = np.full(len(origins), np.inf), np.full(len(origins), -1)
    for index, (a, b, c) in enumerate(corners):
        normal = np.cross(b - a, c - a)
        slope = directions @ normal
        steep = np.abs(slope) > 1e-14 * np.linalg.norm(normal)
        distance = np.where(steep, ((a - origins) @ normal) / np.where(steep, slope, 1.0), np.inf)
        candidates = np.flatnonzero(steep & (distance > 0.0) & (distance < best))
        if not len(candidates):
            continue
        point = origins[candidates] + directions[candidates] * distance[candidates, None]
        edges = np.stack([np.cross(q - p, point - p) @ normal for p, q in ((a, b), (b, c), (c, a))])
        inside = candidates[(edges >= 0.0).all(axis=0)]
        best[inside], which[inside] = distance[inside], index
    return best, which


def surface_points(scene: Scene, camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What rays through the pixel centres see: points (h, w, 3), normals turned to the viewer (h, w, 3), objects (h, w) (−1 = nothing)."""
    width, height = size
    x, y = np.meshgrid(2.0 * (np.arange(width) + 0.5) / width - 1.0, 1.0 - 2.0 * (np.arange(height) + 0.5) / height)
    clip = np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1).reshape(-1, 4) @ np.linalg.inv(camera.clip_from_world).T
    towards = clip[:, :3] / clip[:, 3:] - camera.eye_ws
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    corners = world_corners(scene)
    distance, triangle = first_hits(corners, np.broadcast_to(camera.eye_ws, towards.shape), towards)
    seen = triangle >= 0
    points = np.zeros_like(towards)
    points[seen] = camera.eye_ws + towards[seen] * distance[seen, None]
    normals = np.zeros_like(towards)
    a, b, c = np.moveaxis(corners[triangle[seen]], 1, 0)
    normals[seen] = np.cross(b - a, c - a)
    normals[seen] *= -np.sign((normals[seen] * towards[seen]).sum(-1, keepdims=True)) / np.linalg.norm(normals[seen], axis=1, keepdims=True)
    counts = [len(scene.meshes[i].triangles) for i in scene.instances.mesh_index]
    objects = np.full(len(towards), -1)
    objects[seen] = np.repeat(scene.instances.object_id, counts)[triangle[seen]]
    return points.reshape(height, width, 3), normals.reshape(height, width, 3), objects.reshape(height, width)


def is_blocked(scene: Scene, points: np.ndarray, normals: np.ndarray, light: Light) -> np.ndarray:
    """(P,) whether something stands between the points (a micrometre above their surface) and the light."""
    origins = points + 1e-6 * normals
    if light.kind == "sun":
        direction, reach = np.broadcast_to(light.direction_ws, origins.shape), np.inf
    else:
        offset = light.position_ws - origins
        reach = np.linalg.norm(offset, axis=1)
        direction = offset / reach[:, None]
    return first_hits(world_corners(scene), origins, direction)[0] < reach
