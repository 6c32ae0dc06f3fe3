"""Light space: where the light's rays are parallel lines along y, for the sun by a rotation, for a spot after its own projection.

Wimmer's axes (CONVENTIONS.md `_ls`): y opposite to the light's travel, z in the plane of y and the view and pointing the view's way.
A finite light becomes directional after its perspective division (T4 §4.2, method §3), so one homogeneous form serves both:
rows (X, Y, Z, R) with light-space x = X/R, y = Y/R, z = Z/R; the sun has R = 1, a spot R = distance along its axis and Y = 1.

Along the view axis z turns round within a few degrees (its azimuth has index 1 there: no continuous choice of axes exists). What must
not jump is the size of a texel, so towards γ = 0 the map's rectangle blends into the circle's square, which has no azimuth (`roundness`).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, sqrt, tan

import numpy as np

from ..view import Camera, Light, gamma_rad

ROUND_BELOW = radians(18.0)  # the blend starts here, or at γ_lim where that is smaller
ROUND_LEAST = radians(4.0)  # but never later than here
NEAREST = 1e-4  # of its reach: what is nearer to a finite light is not shadowed
ROUND_CORE = 0.2  # share of that angle in which the rectangle is the circle's square


@dataclass(frozen=True, eq=False)
class LightSpace:
    """Light space of one light (or one face of a point light) for one view, for points relative to the eye (world axes).

    `from_eye` (4, 4): rows X, Y, Z, R of the module's text. `apex_x` the x of the view axis, on which the warp is centred. `gamma_rad` γ
    where the map looks, `ray` (3,) the light's travel there; `travel_ws` (3,) its axis. `upright` the angle of camera right in (x, z).
    `planes` (P, 4) inward planes of what the map is fitted to, `select` those that choose its receivers (None: no such planes).
    For a finite light: `position` (3,) relative to the eye, `planes` the pyramid it serves (four sides, near, far), `slope` the tangent of
    the pyramid's half angle, `least` the distance of its near plane. For a face of the view frustum `rise` as in `faces.py`.
    """

    from_eye: np.ndarray
    apex_x: float
    gamma_rad: float
    travel_ws: np.ndarray
    ray: np.ndarray
    upright: float
    position: np.ndarray | None = None
    planes: np.ndarray | None = None
    slope: float = 0.0
    least: float = 0.0
    select: np.ndarray | None = None
    rise: float | None = None

    def points(self, relative: np.ndarray) -> np.ndarray:
        """(…, 3) points relative to the eye → (…, 3) light space (divided)."""
        h = np.asarray(relative, np.float64) @ self.from_eye[:, :3].T + self.from_eye[:, 3]
        return h[..., :3] / h[..., 3:]


def sun_space(light: Light, camera: Camera) -> LightSpace:
    """Light space of a directional light: Wimmer's axes with the origin in the eye (so the view axis has x = 0)."""
    towards = np.asarray(light.direction_ws, np.float64)
    axes = _axes(towards, camera.direction_ws, camera.view_from_world)
    from_eye = np.eye(4)
    from_eye[:3, :3] = axes
    return LightSpace(from_eye, 0.0, gamma_rad(towards, camera.direction_ws), -towards, -towards, _upright(axes, camera))


def cone_space(
    position: np.ndarray, travel: np.ndarray, half_angle_rad: float, reach: float, camera: Camera, pyramid: np.ndarray | None = None
) -> LightSpace:
    """Light space of a finite light at `position` (relative to the eye), looking along `travel` (unit).

    It serves the pyramid of `half_angle_rad` round `travel`, from `NEAREST`·`reach` to `reach` metres; its sides are upright on the rows of
    `pyramid` (2, 3), given for the faces of a cube. The view's direction is taken on the part of the view axis inside that pyramid.
    """
    view = camera.direction_ws
    u, v = _across(travel) if pyramid is None else pyramid
    slope = tan(half_angle_rad)
    sides = np.array([slope * travel + s * e for e in (u, v) for s in (1.0, -1.0)])
    sides /= np.linalg.norm(sides, axis=1, keepdims=True)
    planes = np.column_stack([sides, -sides @ position])
    least = reach * NEAREST
    caps = np.array([[*travel, -travel @ position - least], [*-travel, travel @ position + reach]])
    anchor = _on_view_axis(np.concatenate([planes, caps]), camera, position, travel, least)
    q = anchor - position
    ray = q / np.linalg.norm(q)
    depth = float(q @ travel)
    # the view direction as seen in the light's image at the anchor, as a world direction across `travel`
    image_view = (view - travel * (view @ travel)) - (q / depth - travel) * (view @ travel)
    axes = _axes(-travel, image_view, camera.view_from_world)
    from_eye = np.zeros((4, 4))
    from_eye[0, :3], from_eye[2, :3], from_eye[3, :3] = axes[0], axes[2], travel
    from_eye[[0, 2, 3], 3] = -from_eye[[0, 2, 3], :3] @ position
    from_eye[1, 3] = 1.0
    apex_x = float(axes[0] @ q) / depth
    select = None if pyramid is None else planes
    planes = np.concatenate([planes, caps])
    return LightSpace(from_eye, apex_x, gamma_rad(ray, view), travel, ray, _upright(axes, camera), position, planes, slope, least, select)


def round_core(gamma_lim: float) -> float:
    """The angle round the view axis in which the map is the circle's square and uniform."""
    return ROUND_CORE * min(max(gamma_lim, ROUND_LEAST), ROUND_BELOW)


def roundness(gamma: float, gamma_lim: float) -> float:
    """How far the map's rectangle has become the circle's square: 0 from γ_lim (at most 18°) on, 1 in the core round the view axis."""
    core = round_core(gamma_lim)
    start = core / ROUND_CORE
    return float(np.clip((start - gamma) / (start - core), 0.0, 1.0))


def _axes(towards: np.ndarray, view: np.ndarray, view_from_world: np.ndarray) -> np.ndarray:
    """(3, 3) rows x, y, z. Where `view` is along the light, the camera's up (or right) takes its place; `roundness` hides the switch."""
    for candidate, limit in ((view, 1e-9), (view_from_world[1, :3], 0.5), (view_from_world[0, :3], 0.0)):
        across = candidate - towards * (candidate @ towards)
        length = np.linalg.norm(across)
        if length > limit:
            break
    z = across / length
    z -= towards * (z @ towards)
    z /= np.linalg.norm(z)
    return np.stack([np.cross(towards, z), towards, z])


def _across(direction: np.ndarray) -> np.ndarray:
    """(2, 3) orthonormal pair across a unit direction."""
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])


def _upright(axes: np.ndarray, camera: Camera) -> float:
    """Angle in (x, z) of the camera's right (or, where that is along the light, up)."""
    right = axes @ camera.view_from_world[0, :3]
    if np.hypot(right[0], right[2]) < 0.5:
        right = axes @ camera.view_from_world[1, :3]
    return float(np.arctan2(right[2], right[0]))


def _on_view_axis(planes: np.ndarray, camera: Camera, position: np.ndarray, travel: np.ndarray, least: float) -> np.ndarray:
    """The point of the view axis at the geometric middle of its part inside the planes; else the nearest, moved before the light."""
    view = camera.direction_ws
    rate, height = planes[:, :3] @ view, planes[:, 3]
    enter, leave = camera.near, camera.far
    for r, h in zip(rate, height, strict=True):
        if r > 0.0:
            enter = max(enter, -h / r)
        elif r < 0.0:
            leave = min(leave, -h / r)
        elif h < 0.0:
            leave = -np.inf
    if enter < leave:
        return (sqrt(enter * leave) if enter > 0.0 else 0.5 * (enter + leave)) * view
    nearest = np.clip(position @ view, camera.near, camera.far) * view
    return nearest + travel * max(0.0, least - float((nearest - position) @ travel))
