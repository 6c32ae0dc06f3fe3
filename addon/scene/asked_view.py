"""Cameras and lights asked for in words or numbers: `--view`, `--eye`, `--fov-y`, `--near`, `--far`, `--light`. No bpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import tan
from typing import Any

import numpy as np

from ..errors import SceneError
from ..maths.choices import require
from ..maths.spaces import with_depth_range
from ..maths.view import Camera, Light
from .default_view import camera_for_view, camera_from_eye
from .records import Scene

Point = tuple[float, float, float]
CameraMaker = Callable[[Scene, tuple[int, int]], Camera]
LightMaker = Callable[[Scene, Camera], Light]


@dataclass(frozen=True, slots=True)
class Lens:
    """Changes to a camera, None = as it is: vertical half field of view in radians, near and far view depth in metres."""

    half_fov_rad: float | None = None
    near: float | None = None
    far: float | None = None

    def on(self, camera: Camera) -> Camera:
        """The camera with these changes; raises `SettingsError` for near ≥ far and for a field of view that it cannot have."""
        near = camera.near if self.near is None else self.near
        far = camera.far if self.far is None else self.far
        require(near < far, f"Near ({near:g} m) must be smaller than far ({far:g} m).")
        require(camera.is_orthographic or near > 0.0, f"Near ({near:g} m) must be positive.")
        clip_from_view = camera.clip_from_view.copy()
        if self.half_fov_rad is not None:
            require(not camera.is_orthographic, f"Camera '{camera.name}' is orthographic and has no field of view.")
            clip_from_view[:2] *= 1.0 / (tan(self.half_fov_rad) * clip_from_view[1, 1])
        clip_from_view = with_depth_range(clip_from_view, near, far, camera.is_orthographic)
        return replace(camera, clip_from_view=clip_from_view, near=near, far=far)


def sun_from(towards: Point) -> Light:
    """A sun in the direction `towards` it, world axes, of any length; raises `SceneError` for a zero or infinite one."""
    vector = np.array(towards, dtype=np.float64)
    length = float(np.linalg.norm(vector))
    if not 0.0 < length < np.inf:
        raise SceneError("The light's direction is zero or infinite: give X, Y, Z towards the light, for example -1,-1,2.")
    return Light("sun", vector / length, name="direction")


def camera_maker(
    name: str | None,
    view: str | None,
    eye: Point | None,
    target: Point | None,
    up: Point,
    half_fov_rad: float | None,
    is_orthographic: bool = False,
) -> CameraMaker | None:
    """How to make the camera asked for by name, as a standard view, or from an eye; None when nothing was asked for.

    Points are true world coordinates in metres; without a target the eye looks at the middle of everything.
    What is made raises `SceneError` or `SettingsError`.
    """
    require(not is_orthographic or view is not None or eye is not None, "Orthographic is a standard view or one from an eye: name one.")
    fov: dict[str, Any] = {"is_orthographic": is_orthographic} | ({} if half_fov_rad is None else {"fov_y_rad": 2.0 * half_fov_rad})
    if name is not None:
        return lambda scene, size: named_camera(scene, name)
    if view is not None:
        return lambda scene, size: camera_for_view(scene, size, view, **fov)
    if eye is not None:
        return lambda scene, size: camera_from_eye(scene, size, eye, _middle(scene) if target is None else target, up, **fov)
    return None


def light_maker(name: str | Sequence[str] | None, direction: Point | None) -> LightMaker | None:
    """How to make the light asked for by name (the first of several) or as a sun's direction; None: nothing was asked for."""
    names = names_of(name)
    if names:
        return lambda scene, camera: named_light(scene, names[0])
    if direction is not None:
        return lambda scene, camera: sun_from(direction)
    return None


def names_of(name: str | Sequence[str] | None) -> tuple[str, ...]:
    """The lights asked for by name, each once."""
    return () if name is None else (name,) if isinstance(name, str) else tuple(dict.fromkeys(name))


def _middle(scene: Scene) -> Point:
    return tuple((scene.bounds_ws().mean(axis=0) + scene.origin_ws).tolist())


def named_camera(scene: Scene, name: str) -> Camera:
    """The scene's camera of that name; raises `SceneError` naming those there are."""
    found = next((camera for camera in scene.cameras if camera.name == name), None)
    if found is None:
        raise SceneError(f"There is no camera '{name}': choose one of {_names(scene.cameras)}.")
    return found


def named_light(scene: Scene, name: str) -> Light:
    """The scene's light of that name; raises `SceneError` naming those there are."""
    found = next((light for light in scene.lights if light.name == name), None)
    if found is None:
        raise SceneError(f"There is no sun, spot or point light '{name}' that the render sees: choose one of {_names(scene.lights)}.")
    return found


def _names(things: tuple[Camera, ...] | tuple[Light, ...]) -> str:
    return ", ".join(f"'{thing.name}'" for thing in things) or "(none there)"
