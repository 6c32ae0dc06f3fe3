"""What a script looks at: the view and light arguments that the functions of `api` share."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians

import bpy

from ..blender.properties import settings_from
from ..blender.render_wish import RenderWish
from ..scene.asked_view import Lens, Point, camera_maker, light_maker, names_of
from ..settings.combinations import idle
from ..settings.options import with_options


def wish_for(
    scene: bpy.types.Scene,
    passes: tuple[str, ...] = (),
    /,
    *,
    camera: str | None = None,
    view: str | None = None,
    eye: Point | None = None,
    target: Point | None = None,
    up: Point = (0.0, 0.0, 1.0),
    fov_y_deg: float | None = None,
    near: float | None = None,
    far: float | None = None,
    light: str | Sequence[str] | None = None,
    light_direction: Point | None = None,
    size: tuple[int, int] | None = None,
    ortho: bool = False,
    frame: int | None = None,
    view_layer: str | None = None,
    **options: object,
) -> RenderWish:
    """What the engine is asked for; `options` of the method override the scene's settings. Raises `SettingsError`.

    `camera` (a name), `view` ('iso', 'front', …) or `eye` with `target`, in world metres; else the scene's camera. `fov_y_deg`, `near`,
    `far` change its lens. `light` (names) or `light_direction` (towards the light); else the scene's. `size` (w, h) in pixels.
    `ortho`: `view` or `eye` as a parallel projection. `frame` of the animation; `view_layer` (a name): the only one that is rendered.
    """
    settings = with_options(settings_from(scene.cad_shadow), options)
    half_fov = None if fov_y_deg is None else radians(fov_y_deg) / 2.0
    return RenderWish(
        bpy.data.filepath or "unsaved scene",
        passes,
        camera_maker(camera, view, eye, target, up, half_fov, ortho),
        light_maker(light, light_direction),
        settings,
        Lens(None if ortho else half_fov, near, far),
        size,
        idle(options, settings),
        is_drawing=view is not None,
        frame=frame,
        view_layer=view_layer,
        more_lights=names_of(light)[1:],
    )
