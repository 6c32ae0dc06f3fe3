"""Captures from a set of directions round an object, so that a full orbit needs no new ones. No GPU.

The directions are those of an octahedral map of n × n cells (method §7): at n = 16 the nearest is 4.9° away on
average and 9.8° at most. A view is captured from its direction at the distance of the eye that first asks for it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...errors import SceneError
from ..choices import require
from ..spaces import look_at
from ..view import Camera


def view_directions(count: int) -> np.ndarray:
    """(count², 3) unit vectors from the object towards the eye: the centres of an octahedral map's cells, row by row."""
    require(1 <= count <= 64, "An octahedral set has 1 to 64 views per side.")
    centre = (np.arange(count) + 0.5) / count * 2.0 - 1.0
    x, y = (a.ravel() for a in np.meshgrid(centre, centre))
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0.0)
    out = np.stack([x - np.where(x >= 0.0, fold, -fold), y - np.where(y >= 0.0, fold, -fold), z], axis=-1)
    return out / np.linalg.norm(out, axis=1, keepdims=True)


def nearest_views(directions: np.ndarray, camera: Camera, centre_ws: np.ndarray, count: int) -> np.ndarray:
    """(min(count, V),) indices of the `directions` (V, 3) nearest to the camera's own as seen from the object's middle, nearest first."""
    return np.argsort(-(directions @ towards_eye(camera, centre_ws)[0]), kind="stable")[:count]


def view_camera(camera: Camera, centre_ws: np.ndarray, direction: np.ndarray) -> Camera:
    """The camera moved round the object: as far from its middle, in `direction` (3,), looking at the middle; its lens stays."""
    distance = towards_eye(camera, centre_ws)[1]
    return replace(camera, view_from_world=look_at(centre_ws + distance * direction, centre_ws))


def towards_eye(camera: Camera, centre_ws: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit vector from the object's middle towards the eye, and how far the eye is (an orthographic camera's: along its view)."""
    offset = camera.eye_ws - centre_ws
    if camera.is_orthographic:
        away = -np.asarray(camera.direction_ws, float)
        return away, float(offset @ away)
    distance = float(np.linalg.norm(offset))
    if not distance > 0.0:
        raise SceneError("The camera stands in the middle of the impostor's object: move it out.")
    return offset / distance, distance
