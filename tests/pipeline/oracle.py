"""Numpy oracles of the GPU passes: rays against every triangle, in float64. Slow and plain on purpose; small scenes only."""

from __future__ import annotations

import numpy as np

from addon.maths.lookup import project
from addon.maths.projection import ShadowProjection
from addon.maths.view import Camera
from addon.pipeline.scene import Scene


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
