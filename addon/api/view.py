"""What a script looks at: the view and light arguments that the functions of `api` share."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import bpy

from ..blender.properties import settings_from
from ..blender.request import Request
from ..scene.asked_view import Lens, Point, camera_maker, light_maker
from ..settings.combinations import idle
from ..settings.options import with_options


@dataclass(frozen=True, slots=True)
class View:
    """`camera` (a name), `view` ('iso', 'front', …) or `eye` with `target`, in world metres; else the scene's camera. `fov_y_deg`, `near`,
    `far` change its lens. `light` (a name) or `light_direction` (towards the light); else the scene's. `size` (width, height) in pixels."""

    camera: str | None = None
    view: str | None = None
    eye: Point | None = None
    target: Point | None = None
    up: Point = (0.0, 0.0, 1.0)
    fov_y_deg: float | None = None
    near: float | None = None
    far: float | None = None
    light: str | None = None
    light_direction: Point | None = None
    size: tuple[int, int] | None = None

    def request(self, scene: bpy.types.Scene, options: dict[str, object], passes: tuple[str, ...] = ()) -> Request:
        """What the engine is asked for; `options` of the method override the scene's settings. Raises `SettingsError`."""
        settings = with_options(settings_from(scene.cad_shadow), options)
        half_fov = None if self.fov_y_deg is None else radians(self.fov_y_deg) / 2.0
        camera = camera_maker(self.camera, self.view, self.eye, self.target, self.up, half_fov)
        light = light_maker(self.light, self.light_direction)
        name = bpy.data.filepath or "unsaved scene"
        lens, is_drawing = Lens(half_fov, self.near, self.far), self.view is not None
        return Request(name, passes, camera, light, settings, lens, self.size, idle(options, settings), is_drawing)
