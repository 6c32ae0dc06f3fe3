"""What every map of a plan needs to know of the view: its receivers, relative to the eye, where float32 is finest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..choices import FitChoice, WarpChoice
from ..frusta import Body, box_corners, box_planes, frustum_corners, hexahedron
from ..spaces import linear
from ..view import Camera

THINNEST = 1e-3  # least (f−n)/n of a range that is divided


@dataclass(frozen=True, eq=False)
class FitView:
    """What every map of a plan needs to know: the view, the choices, and the receivers relative to the eye.

    `samples` (3, P) float32 or None for the body fits, `depths` (P,) their view depths; `body` the view frustum, cut by the scene for
    the 'scene' fit; `boxes` (I, 2, 3) the casters; `pixel` half a pixel's size at view depth 1 (perspective) or anywhere (orthographic).
    """

    camera: Camera
    warp: WarpChoice
    fit: FitChoice
    samples: np.ndarray | None
    depths: np.ndarray
    body: Body
    boxes: np.ndarray
    pixel: float

    @property
    def depth_range(self) -> tuple[float, float] | None:
        """Least and largest view depth of the receivers, never thinner than `THINNEST`; None where there is nothing."""
        depths = self.depths if self.samples is not None else self.body.vertices @ self.camera.direction_ws
        return None if not len(depths) else self.padded_range(float(depths.min()), float(depths.max()))

    def padded_range(self, near: float, far: float) -> tuple[float, float]:
        """The range inside the camera's, widened to a thickness that can be warped and divided."""
        if not self.camera.is_orthographic:
            near = max(near, self.camera.near * (1.0 - 1e-6))
        return near, max(far, near + THINNEST * max(abs(near), 1e-6 * (self.camera.far - self.camera.near)))

    def reach(self, position: np.ndarray, scene_bounds: np.ndarray) -> float:
        """Metres from a finite light, relative to the eye, to the farthest thing it may have to light: what is seen, not all there is."""
        if self.samples is not None and self.samples.size:
            offset = self.samples - position.astype(np.float32)[:, None]
            return 1.001 * float(np.sqrt(np.square(offset).sum(axis=0).max()))
        corners = self.body.vertices if len(self.body.vertices) else box_corners(scene_bounds) - self.camera.eye_ws
        return float(np.linalg.norm(corners - position, axis=1).max())


def view_to_fit(
    camera: Camera,
    warp: WarpChoice,
    fit: FitChoice,
    receivers: np.ndarray | None,
    scene_bounds: np.ndarray,
    casters: np.ndarray,
    image_size: tuple[int, int],
) -> FitView:
    """Everything moved to the eye, where float32 is finest."""
    eye = camera.eye_ws
    body = hexahedron(frustum_corners(camera, camera.near, camera.far))
    if fit.kind == "scene":
        body = body.clipped(box_planes(np.asarray(scene_bounds, np.float64) - eye))
    samples, depths = None, np.empty(0, np.float32)
    if fit.kind == "samples":
        points = np.asarray(receivers).reshape(-1, 3)
        samples = np.empty((3, len(points)), np.float32)
        for axis in range(3):
            np.subtract(points[:, axis], float(eye[axis]), out=samples[axis], casting="same_kind")
        depths = linear(camera.direction_ws.astype(np.float32), samples)
    pixel = 1.0 / float(camera.clip_from_view[1, 1]) / image_size[1]
    return FitView(camera, warp, fit, samples, depths, body, np.asarray(casters, np.float64).reshape(-1, 2, 3) - eye, pixel)
