"""How a picture's depth buffer tells near from far: which places it holds, and the number it keeps of each. No GPU.

A float32 has its digits where it is small. A perspective depth, which falls as 1/z, is kept reversed, 1 at the near plane and towards 0
far away: its step is 6e-8 of the distance everywhere, whatever near and far are. An orthographic depth is kept as it grows, from 0 at the
near plane: its step is 6e-8 of the distance to that plane, so the plane is put as far forward as what the view shows allows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .frusta import box_corners, hexahedron
from .spaces import linear
from .view import Camera

REFINED = 8  # boxes at either end of an orthographic view that are cut to what it shows
SLACK = 1e-6  # of the distance, by which near and far stand off what is seen
RANGE_MARGIN = 0.02  # of the range besides: what is drawn instead of an object may reach a little beyond its box


@dataclass(frozen=True, slots=True)
class DepthProjection:
    """Near and far as a depth buffer has them, view depths in metres, near exactly a float32."""

    near: float
    far: float
    is_orthographic: bool

    @property
    def rule(self) -> tuple[float, float, float, float]:
        """(a, b, c, e): a place t metres behind the near plane has depth (a + b·t)/(c + e·t), within 0…1, and clip w = c + e·t."""
        length = self.far - self.near
        return (0.0, 1.0 / length, 1.0, 0.0) if self.is_orthographic else (self.near, -self.near / length, self.near, 1.0)

    @property
    def clip_rule(self) -> tuple[float, float]:
        """(a, b): clip z = a + b·t in OpenGL's own −w…w, for clipping only: t = 0 is the near plane; a perspective far plane is none."""
        return (-1.0, 2.0 / (self.far - self.near)) if self.is_orthographic else (-self.near, 1.0)

    @property
    def nearer(self) -> str:
        """How the depth of a nearer place compares with that of a farther one."""
        return "<" if self.is_orthographic else ">"

    @property
    def farthest(self) -> float:
        """The depth of the far plane: what a buffer is cleared to."""
        return 1.0 if self.is_orthographic else 0.0

    @property
    def nearest(self) -> float:
        """The depth of the near plane."""
        return 1.0 - self.farthest

    def depth(self, view_depth: np.ndarray) -> np.ndarray:
        """Depth 0…1 of view depths in metres."""
        a, b, c, e = self.rule
        behind = np.asarray(view_depth, np.float64) - self.near
        return (a + b * behind) / (c + e * behind)


def whole(camera: Camera) -> DepthProjection:
    """The projection of the camera's own near and far."""
    return _between(camera, camera.near, camera.far)


def fitted(camera: Camera, bounds_ws: np.ndarray) -> DepthProjection:
    """The projection of what the camera shows of boxes (B, 2, 3): near and far just before and behind it, never beyond the camera's own.

    All that lies in a box, in the picture and between the camera's near and far lies between these; where nothing does, they are `whole`.
    """
    low, high = view_depths(camera, bounds_ws)
    shown = (high > camera.near) & (low < camera.far)
    if not shown.any():
        return whole(camera)
    near, far = float(low[shown].min()), float(high[shown].max())
    if camera.is_orthographic:
        planes = _side_planes(camera)
        near, far = _refined(camera, planes, bounds_ws[shown], low[shown]), -_refined(camera, planes, bounds_ws[shown], -high[shown], -1.0)
        if not (near <= far and near < camera.far and far > camera.near):
            return whole(camera)
    slack = SLACK * max(abs(near), abs(far), far - near) + RANGE_MARGIN * (far - near)
    before = near - slack if camera.is_orthographic else max(near - slack, 0.5 * near)
    return _between(camera, max(before, camera.near), min(far + slack, camera.far))


def view_depths(camera: Camera, bounds_ws: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(B,) smallest and (B,) largest view depth of boxes (B, 2, 3)."""
    row = -camera.view_from_world[2]
    middle = linear(row[:3], 0.5 * (bounds_ws[:, 0] + bounds_ws[:, 1]).T) + row[3]
    half = linear(np.abs(row[:3]), 0.5 * (bounds_ws[:, 1] - bounds_ws[:, 0]).T)
    return middle - half, middle + half


def _between(camera: Camera, near: float, far: float) -> DepthProjection:
    """Near down to a float32, and far behind it."""
    nearest = np.float32(near)
    single = float(nearest if nearest <= near else np.nextafter(nearest, np.float32(-np.inf)))
    return DepthProjection(single, max(far, single + max(SLACK * abs(single), 1e-30)), camera.is_orthographic)


def _side_planes(camera: Camera) -> np.ndarray:
    """(4, 4) inward planes of unit normal of a parallel view's picture, for points relative to the eye."""
    rows = camera.clip_from_world[:2]
    offset = rows[:, :3] @ camera.eye_ws + rows[:, 3]
    inward = np.concatenate([rows[:, :3], -rows[:, :3]])
    planes = np.column_stack([inward, 1.0 + np.concatenate([offset, -offset])])
    return planes / np.linalg.norm(inward, axis=1, keepdims=True)


def _refined(camera: Camera, planes: np.ndarray, bounds_ws: np.ndarray, first: np.ndarray, sign: float = 1.0) -> float:
    """The smallest sign · view depth of what boxes have inside `planes`; `first` (B,) is what they have anywhere.

    The `REFINED` boxes that begin first are cut; what is not has its smallest anywhere.
    """
    order = np.argsort(first)
    best = float(first[order[REFINED]]) if len(order) > REFINED else np.inf
    for i in order[:REFINED]:
        if first[i] >= best:
            break
        inside = hexahedron(box_corners(bounds_ws[i]) - camera.eye_ws).clipped(planes).vertices
        if len(inside):
            best = min(best, max(float((sign * (inside @ camera.direction_ws)).min()), float(first[i])))
    return best
