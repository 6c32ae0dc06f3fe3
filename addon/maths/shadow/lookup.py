"""What the shader does with a `ShadowProjection`, in numpy: which map a point asks, where it falls in it, and how large a texel is there.

The oracle of `shaders/`: the same formulas in the same order. Gradients stand beside the values they derive.
"""

from __future__ import annotations

import numpy as np

from ..spaces import transform
from ..view import Camera, Light
from .projection import ShadowPlan, ShadowProjection


def project(projection: ShadowProjection, points_ws: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points (…, 3) → (s, t, depth, w), NDC and the divisor. Domain: w > 0, which holds on all receivers.

    With (X, Y, Z, w) = clip_from_world · p: s, t, depth = X/w, Y/w, Z/w; a log map has t as `LogWarp.t_at` says, depth = Z and,
    without `perspective_s`, s = X.
    """
    x, y, z, w = np.moveaxis(transform(projection.clip_from_world, points_ws), -1, 0)
    step = projection.log
    if step is None:
        return x / w, y / w, z / w, w
    return (x / w if step.perspective_s else x), step.t_at(w), z, w


def unproject(projection: ShadowProjection, s: np.ndarray, t: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """The inverse of `project`: NDC (s, t, depth) → (…, 3) world points. A log map gives w (`LogWarp.w_at`); Y is not needed."""
    s, t, depth = np.broadcast_arrays(s, t, depth)
    matrix, step = projection.clip_from_world, projection.log
    if step is None:
        h = np.stack([s, t, depth, np.ones_like(s)], axis=-1) @ np.linalg.inv(matrix).T
        return h[..., :3] / h[..., 3:]
    w = step.w_at(t)
    known = np.stack([s * w if step.perspective_s else s, depth, w], axis=-1)
    rows = matrix[[0, 2, 3]]
    return (known - rows[:, 3]) @ np.linalg.inv(rows[:, :3]).T


def gradients(projection: ShadowProjection, points_ws: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(∇s, ∇t), each (…, 3): NDC per world metre. ∇(X/w) = (∇X − X/w ∇w)/w; ∇t of a log map = dt/dw ∇w."""
    s, t, _, w = project(projection, points_ws)
    matrix, step = projection.clip_from_world[:, :3], projection.log

    def divided(value: np.ndarray, row: int) -> np.ndarray:
        return (matrix[row] - value[..., None] * matrix[3]) / w[..., None]

    if step is None:
        return divided(s, 0), divided(t, 1)
    grad_t = step.t_rate(w)[..., None] * matrix[3]
    return (divided(s, 0) if step.perspective_s else np.broadcast_to(matrix[0], grad_t.shape)), grad_t


def towards_light(light: Light, points_ws: np.ndarray) -> np.ndarray:
    """(…, 3) unit vectors from the points to the light. Domain: no point lies in a finite light."""
    if light.kind == "sun":
        return np.broadcast_to(np.asarray(light.direction_ws, np.float64), np.shape(points_ws))
    ray = np.asarray(light.position_ws, np.float64) - points_ws
    return ray / np.linalg.norm(ray, axis=-1, keepdims=True)


def partition_index(plan: ShadowPlan, camera: Camera, points_ws: np.ndarray) -> np.ndarray:
    """(…,) int32: the first projection whose depth bounds and planes hold; −1 where none does."""
    depth = -transform(camera.view_from_world, points_ws)[..., 2]
    index = np.full(depth.shape, -1, np.int32)
    for i, p in reversed(list(enumerate(plan.projections))):
        inside = (depth >= p.near) & (depth < p.far)
        for plane in p.region_planes_ws:
            inside &= points_ws @ plane[:3] + plane[3] >= 0.0
        index[inside] = i
    return index


def texel_footprint(projection: ShadowProjection, points_ws: np.ndarray, light: Light, size: int) -> np.ndarray:
    """(…, 2, 3) world vectors, across the light's ray, that one texel step in s and in t spans at the points.

    Dual to the gradients, which are across the ray l too: e_s = 2/N (∇t × l)/(∇s · (∇t × l)), e_t = 2/N (l × ∇s)/(∇t · (l × ∇s)).
    """
    grad_s, grad_t = gradients(projection, points_ws)
    ray = towards_light(light, points_ws)
    along_s, along_t = np.cross(grad_t, ray), np.cross(ray, grad_s)
    e_s = along_s / (grad_s * along_s).sum(axis=-1, keepdims=True)
    e_t = along_t / (grad_t * along_t).sum(axis=-1, keepdims=True)
    return (2.0 / size) * np.stack([e_s, e_t], axis=-2)
