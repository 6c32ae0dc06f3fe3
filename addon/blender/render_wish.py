"""What a caller wants of the engine, and the wish that is being rendered."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

import bpy

from ..errors import UserError
from ..maths.view import Camera
from ..pipeline.job import Job
from ..pipeline.render_passes import ENGINE_PASSES
from ..scene.asked_view import CameraMaker, Lens, LightMaker
from ..scene.default_view import camera_for_view
from ..scene.records import Scene
from ..settings.groups import Settings
from ..studies.run import Outcome

ENGINE = "CAD_SHADOW_PREVIEW"
NO_CAMERA = "There is no camera: an isometric view that frames everything is used."


@dataclass(eq=False)
class RenderWish:
    """What a caller of `render` wants of the engine; the engine fills in `outcome` or `error`.

    None leaves to the scene what it says: its camera, light, settings, size. `camera(scene, size)` and `light(scene, camera)` make theirs;
    `lens` changes whatever camera it is. `is_drawing`: the camera is a standard view, to be lit as drawings are. With `reads_only` the
    engine notes the `job` and draws nothing. `marked`: what counts as marked as impostors instead of what the file marks.
    `frame`: that of the animation; `view_layer`: the only one that is rendered. `more_lights` beside `light`, by their names.
    """

    name: str
    passes: tuple[str, ...] = ENGINE_PASSES
    camera: CameraMaker | None = None
    light: LightMaker | None = None
    settings: Settings | None = None
    lens: Lens = Lens()
    size: tuple[int, int] | None = None
    warnings: tuple[str, ...] = ()
    is_drawing: bool = False
    reads_only: bool = False
    marked: Sequence[bpy.types.ID] | None = None
    frame: int | None = None
    view_layer: str | None = None
    more_lights: tuple[str, ...] = ()
    job: Job | None = field(default=None, init=False)
    outcome: Outcome | None = field(default=None, init=False)
    error: UserError | None = field(default=None, init=False)


def isometric(scene: Scene, size: tuple[int, int]) -> Camera:
    """The view of a scene that has no camera."""
    return camera_for_view(scene, size, "iso")


_active: ContextVar[RenderWish | None] = ContextVar("cad-shadow-wish", default=None)


def active_wish() -> RenderWish | None:
    """The wish being rendered, None for a plain F12."""
    return _active.get()


@contextmanager
def active(wish: RenderWish) -> Iterator[None]:
    """`wish` is what the engine finds as the `active_wish` while this lasts: Blender calls it on this thread and hands nothing through."""
    token = _active.set(wish)
    try:
        yield
    finally:
        _active.reset(token)
