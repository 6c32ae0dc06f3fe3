"""The aliasing error measured at visible points (method §1): exact Jacobians of the map by the picture, no finite differences.

A texel's and a pixel's coordinates are functions of the world point, so the footprints follow from their gradients: over an area with
normal N, ∂(s, t) scales by |(∇s × ∇t)·N| and ∂(x, y) by |(∇x × ∇y)·N|. Here ∇s, ∇t are in texels per metre, ∇x, ∇y in pixels per metre.
"""

from __future__ import annotations

import numpy as np

from ..shadow.lookup import gradients, partition_index, towards_light
from ..shadow.projection import ShadowPlan, ShadowProjection
from ..spaces import transform
from ..view import Camera, Light

UNBOUNDED = 1e30  # stands for an infinite error (a surface along the light's ray)


def aliasing(
    camera: Camera,
    light: Light,
    plan: ShadowPlan,
    points_ws: np.ndarray,
    normals_ws: np.ndarray,
    image_size: tuple[int, int],
    map_size: int,
) -> np.ndarray:
    """(P, 3): total m = 1/|det J|, and the perspective errors m_x (along s) and m_z (along t); NaN where no map serves the point.

    J = ∂(texel s, t)/∂(pixel x, y) through the surface with geometric normal `normals_ws` (P, 3) (T4 (11)); for the perspective part
    through the plane that faces the mid direction of light and eye (T4 (12) without its cosines). An unbounded m is `UNBOUNDED`.
    """
    points, normals = np.asarray(points_ws, np.float64), np.asarray(normals_ws, np.float64)
    index = partition_index(plan, camera, points)
    out = np.full((len(points), 3), np.nan)
    for i, projection in enumerate(plan.projections):
        own = np.flatnonzero(index == i)
        if len(own):
            grad_x, grad_y = pixel_gradients(camera, points[own], image_size)
            grad_s, grad_t = texel_gradients(projection, points[own], map_size)
            out[own, 0] = total_error(grad_s, grad_t, grad_x, grad_y, normals[own])
            rays = towards_light(light, points[own]), towards_eye(camera, points[own])
            out[own, 1], out[own, 2] = perspective_errors(grad_s, grad_t, grad_x, grad_y, *rays)
    return out


def texel_gradients(projection: ShadowProjection, points_ws: np.ndarray, map_size: int) -> tuple[np.ndarray, np.ndarray]:
    """(∇s, ∇t) in texels per metre, each (P, 3): N/2 times those of NDC."""
    grad_s, grad_t = gradients(projection, points_ws)
    return 0.5 * map_size * grad_s, 0.5 * map_size * grad_t


def pixel_gradients(camera: Camera, points_ws: np.ndarray, image_size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(∇x, ∇y) in pixels per metre, each (P, 3); y upwards. ∇(X/w) = (∇X − X/w ∇w)/w. Domain: points before the eye."""
    matrix = camera.clip_from_world
    h = transform(matrix, points_ws)
    rows = [(matrix[k, :3] - (h[:, k] / h[:, 3])[:, None] * matrix[3, :3]) / h[:, 3:] for k in (0, 1)]
    return 0.5 * image_size[0] * rows[0], 0.5 * image_size[1] * rows[1]


def towards_eye(camera: Camera, points_ws: np.ndarray) -> np.ndarray:
    """(P, 3) unit vectors to the eye; against the view direction for an orthographic camera."""
    if camera.is_orthographic:
        return np.broadcast_to(-camera.direction_ws, np.shape(points_ws))
    ray = camera.eye_ws - points_ws
    return ray / np.linalg.norm(ray, axis=-1, keepdims=True)


def total_error(grad_s: np.ndarray, grad_t: np.ndarray, grad_x: np.ndarray, grad_y: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(P,) m = 1/|det J| = |(∇x × ∇y)·N| / |(∇s × ∇t)·N|: pixels of the picture that one texel covers on the surface."""
    texel = np.abs((np.cross(grad_s, grad_t) * normals).sum(axis=-1))
    pixel = np.abs((np.cross(grad_x, grad_y) * normals).sum(axis=-1))
    return np.where(texel * UNBOUNDED > pixel, pixel / np.maximum(texel, 1e-300), UNBOUNDED)


def perspective_errors(
    grad_s: np.ndarray, grad_t: np.ndarray, grad_x: np.ndarray, grad_y: np.ndarray, to_light: np.ndarray, to_eye: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(m_x, m_z), each (P,): reciprocals of the singular values of J through the plane facing the mid direction l + e.

    On that plane a step has the same length across the light's ray as across the view's: with c = l × e normalised, the step
    α c + β (l + e) × c shows as (α, β') in the basis (c, l × c) and in (c, e × c). So J = L E⁻¹ with the gradients taken in those bases,
    and no division by cos θ: l = −e is no special case. The larger singular value belongs to s where |row s| ≥ |row t| of J
    (its left singular vector is then nearer to the s axis).
    """
    cross = np.cross(to_light, to_eye)
    length = np.linalg.norm(cross, axis=-1, keepdims=True)
    other = np.cross(to_eye, np.eye(3)[np.argmin(np.abs(to_eye), axis=-1)])
    c = np.where(length > 1e-7, cross / np.maximum(length, 1e-7), other / np.linalg.norm(other, axis=-1, keepdims=True))
    u_light, u_eye = np.cross(to_light, c), np.cross(to_eye, c)

    def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a * b).sum(axis=-1)

    xc, xu, yc, yu = dot(grad_x, c), dot(grad_x, u_eye), dot(grad_y, c), dot(grad_y, u_eye)
    sc, su, tc, tu = dot(grad_s, c), dot(grad_s, u_light), dot(grad_t, c), dot(grad_t, u_light)
    det = xc * yu - xu * yc
    sx, sy = (sc * yu - su * yc) / det, (su * xc - sc * xu) / det
    tx, ty = (tc * yu - tu * yc) / det, (tu * xc - tc * xu) / det
    p, q, r = sx * sx + sy * sy, sx * tx + sy * ty, tx * tx + ty * ty
    large = 0.5 * (p + r) + np.sqrt(0.25 * (p - r) ** 2 + q * q)
    area = np.abs(sx * ty - sy * tx)
    first = np.sqrt(large)
    second = area / first
    m_x, m_z = 1.0 / np.where(p >= r, first, second), 1.0 / np.where(p >= r, second, first)
    return m_x, m_z
