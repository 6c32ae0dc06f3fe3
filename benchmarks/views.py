"""The standard set: three views and five lights of every model. Fixed, so that tables of different days can be compared.

Two classes of views, by f/n of what is really visible (`depth_ratio`): *at* an object (f/n < 15, from outside, framing it) and
*along* a scene (f/n ≥ 20, from within, a floor or a structure that runs away from the eye).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin, tan

import numpy as np

from addon.maths import spaces
from addon.maths.view import Camera, Light
from addon.scene.records import Scene

SIZE = (640, 360)
FOV_Y_DEG = 50.0
AT_BELOW, ALONG_FROM = 15.0, 20.0
LIGHTS = {  # elevation, and azimuth relative to where the view looks (0 = light from ahead, 180 = from behind), degrees
    "high": (70.0, 100.0),
    "side": (40.0, 75.0),
    "behind": (35.0, -155.0),
    "ahead": (30.0, 26.0),
    "low": (12.0, -65.0),
}


@dataclass(frozen=True, eq=False)
class View:
    """A camera with its name and the class it is meant for ('at' or 'along')."""

    name: str
    kind: str
    camera: Camera


def _sun(camera: Camera, elevation_deg: float, azimuth_deg: float, name: str) -> Light:
    forward = camera.direction_ws
    e, a = radians(elevation_deg), np.arctan2(forward[1], forward[0]) + radians(azimuth_deg)
    return Light("sun", np.array([cos(e) * cos(a), cos(e) * sin(a), sin(e)]), name=name)


def lights(camera: Camera) -> dict[str, Light]:
    """The five suns of one view."""
    return {name: _sun(camera, elevation, azimuth, name) for name, (elevation, azimuth) in LIGHTS.items()}


def elevated(camera: Camera, elevations_deg: tuple[float, ...], azimuth_deg: float = 110.0) -> dict[str, Light]:
    """Suns at these heights, all from the side and a little behind."""
    return {f"{e:.1f}°": _sun(camera, e, azimuth_deg, f"{e:.1f}°") for e in elevations_deg}


def lamps(camera: Camera, scene: Scene) -> dict[str, Light]:
    """Spots and point lights of one view: beside the camera, over the middle of the model, and before its far side."""
    low, high = scene.bounds_ws()
    middle, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
    right, up, forward = camera.view_from_world[0, :3], camera.view_from_world[1, :3], camera.direction_ws
    places = {
        "at the camera": camera.eye_ws + 0.02 * size * (right + up),
        "above": np.array([*middle[:2], high[2] + 0.3 * size]) - 0.1 * size * forward,
        "beyond": middle + 0.6 * size * forward + 0.3 * size * (np.array([0.0, 0.0, 1.0]) + right),
    }
    out = {}
    for name, place in places.items():
        towards = (place - middle) / np.linalg.norm(place - middle)
        out[f"spot {name}"] = Light("spot", towards, place, cone_rad=radians(35.0), name=f"spot {name}")
        out[f"point {name}"] = Light("point", position_ws=place, name=f"point {name}")
    return out


def _camera(eye: np.ndarray, target: np.ndarray, near: float, far: float, name: str) -> Camera:
    clip = spaces.perspective(radians(FOV_Y_DEG) / 2.0, SIZE[0] / SIZE[1], near, far)
    return Camera(spaces.look_at(eye, target), clip, near, far, name)


def _corners(scene: Scene) -> np.ndarray:
    """(8, 3) corners of the bounds, local coordinates."""
    low, high = scene.bounds_ws()
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def outside(scene: Scene, name: str, azimuth_deg: float, elevation_deg: float, closeness: float) -> View:
    """A view at the model's middle from `closeness` × the distance at which its bounding box just fits the picture."""
    e, a = radians(elevation_deg), radians(azimuth_deg)
    back = np.array([cos(e) * cos(a), cos(e) * sin(a), sin(e)])
    corners = _corners(scene)
    target = corners.mean(axis=0)
    axes = spaces.look_at(target + back, target)[:3, :3]
    x, y, towards = np.abs((corners - target) @ axes[0]), np.abs((corners - target) @ axes[1]), (corners - target) @ back
    half = tan(radians(FOV_Y_DEG) / 2.0)
    distance = closeness * float((np.maximum(x / (half * SIZE[0] / SIZE[1]), y / half) + towards).max())
    near = max(distance - float(towards.max()), 0.02 * distance)
    return View(name, "at", _camera(target + distance * back, target, near, 1.001 * (distance - float(towards.min())), name))


def within(scene: Scene, name: str, eye: tuple, target: tuple, near: float) -> View:
    """A view along the scene, eye and target in metres of the model's own coordinates (before the local origin is taken off)."""
    eye, target = np.array(eye) - scene.origin_ws, np.array(target) - scene.origin_ws
    forward = (target - eye) / np.linalg.norm(target - eye)
    return View(name, "along", _camera(eye, target, near, 1.001 * float(((_corners(scene) - eye) @ forward).max()), name))


def depth_ratio(depth: np.ndarray) -> float:
    """f/n of what is visible: farthest over nearest view depth of an image (inf where nothing)."""
    seen = depth[np.isfinite(depth)]
    return float(seen.max() / seen.min())


def views(model: str, scene: Scene) -> tuple[View, ...]:
    """The three views of a model."""
    if model == "deck":
        return deck_views(scene)
    return (outside(scene, "whole", -57.0, 18.0, 0.9), outside(scene, "above", 33.0, 48.0, 0.65), outside(scene, "close", 118.0, 8.0, 0.4))


def deck_views(scene: Scene) -> tuple[View, ...]:
    """Along the 240 m deck of `models.DECK`: beside the pipe rack under gratings, beside it the other way, and from above the rack."""
    return (
        within(scene, "walk", (239.0, 10.4, 1.7), (100.0, 9.0, 1.0), 1.0),
        within(scene, "alley", (60.0, 11.4, 1.7), (200.0, 11.4, 1.0), 1.0),
        within(scene, "bridge", (30.0, 6.0, 9.0), (160.0, 8.0, 2.0), 1.0),
    )
