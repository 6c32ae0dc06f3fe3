"""The local origin of a picture: near the eye where the scene is so large that float32 would show it elsewhere. Numpy only.

Positions are float32 metres from the scene's local origin. A part 5 km from it stands on a grid of half a millimetre, which an eye half
a metre away sees. Then the origin moves to the eye: what is near is exact again, what is far is off by far less than a pixel.
"""

from __future__ import annotations

from math import ceil, log2

import numpy as np

from ..maths.frusta import box_distances
from ..maths.view import Camera, Light
from .records import Scene

FARTHEST = 512.0  # times the distance of the nearest object: there a step of float32 is 1/30 of a pixel of 1/1000
GRID = 128.0  # times that distance: the origins that an eye on its way takes up


def based_near(scene: Scene, camera: Camera, light: Light | None) -> tuple[Scene, Camera, Light | None]:
    """The same picture with its local origin where float32 suffices; what is there already is given back as it is.

    The scene moved last is kept with `scene`, so that one view after another gets the same one.
    """
    offset = offset_for(scene, camera)
    if not offset.any():
        return scene, camera, light
    return scene.moved_by(offset), camera.moved_by(offset), light and light.moved_by(offset)


def offset_for(scene: Scene, camera: Camera) -> np.ndarray:
    """(3,) metres from the local origin to the better one; zeros where the eye is near enough."""
    eye = camera.eye_ws
    away = float(np.abs(eye).max())
    if len(scene.instances) and away <= FARTHEST * camera.near:  # whatever is seen is farther than near
        return np.zeros(3)
    near = nearest_m(scene, camera)
    if not away > FARTHEST * near:
        return np.zeros(3)
    step = 2.0 ** ceil(log2(GRID * near))
    return np.round(eye / step) * step + 0.0


def nearest_m(scene: Scene, camera: Camera) -> float:
    """Distance from the eye to the nearest object's bounds that it is not within, or a hundredth of the scene's size where it is within
    all; at least the near plane's, and of a parallel view the height of the picture."""
    gap = box_distances(scene.instance_bounds_ws(), camera.eye_ws)
    outside = gap[gap > 0.0]
    nearest = float(outside.min()) if len(outside) else 0.01 * float(np.ptp(scene.bounds_ws(), axis=0).max())
    height = 2.0 / float(camera.clip_from_view[1, 1]) if camera.is_orthographic else 0.0
    return max(nearest, camera.near, height)
