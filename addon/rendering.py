"""Asking Blender to render with our engine, and getting the outcome itself, not only the file.

A picture for the command line or a script goes through `bpy.ops.render.render`, as F12 does: same dependency graph (render visibility,
render subdivision), same engine, same compositor, same writing. So the results agree bit by bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from .errors import Cancelled, SceneError, UserError
from .job import ENGINE_PASSES, Outcome
from .maths.view import Camera, Light
from .pipeline.scene import Scene
from .pipeline.settings import Settings

ENGINE = "CAD_SHADOW_PREVIEW"


@dataclass(eq=False)
class Request:
    """What a caller of `render` wants of the engine; the engine fills in `outcome` or `error`.

    None leaves to the scene what it says: its camera, light and settings. `camera(scene, size)` and `light(scene, camera)` make theirs.
    """

    name: str
    passes: tuple[str, ...] = ENGINE_PASSES
    camera: Callable[[Scene, tuple[int, int]], Camera] | None = None
    light: Callable[[Scene, Camera], Light] | None = None
    settings: Settings | None = None
    warnings: tuple[str, ...] = ()
    outcome: Outcome | None = field(default=None, init=False)
    error: UserError | None = field(default=None, init=False)


_requests: list[Request] = []


def active_request() -> Request | None:
    """The request being rendered, None for a plain F12."""
    return _requests[-1] if _requests else None


def render(scene: bpy.types.Scene, request: Request, write_to: Path | None = None) -> Outcome:
    """Render `scene` once as `request` says, blocking; with `write_to` Blender also writes the picture there, as it writes an F12.

    The scene's engine and output settings are put back afterwards. Raises `UserError` (of whatever kind the engine met).
    """
    with _borrowed(scene, write_to):
        _requests.append(request)
        try:
            bpy.ops.render.render(write_still=write_to is not None, scene=scene.name)
        except RuntimeError as error:
            raise request.error or SceneError(_one_line(str(error))) from error
        finally:
            _requests.pop()
    if request.outcome is None:
        raise request.error or Cancelled("Blender did not call the engine: is the view layer switched off for rendering?")
    return request.outcome


def _one_line(message: str) -> str:
    return " ".join(message.removeprefix("Error: ").split())


@contextmanager
def _borrowed(scene: bpy.types.Scene, write_to: Path | None) -> Iterator[None]:
    """The scene with our engine, a camera for Blender to accept, and its file settings turned to `write_to`; all put back at the end."""
    render = scene.render
    kept = {name: getattr(render, name) for name in ("engine", "filepath", "use_sequencer", "use_file_extension", "use_overwrite",
                                                     "use_placeholder")}
    image = render.image_settings
    kept_image = {name: getattr(image, name) for name in ("media_type", "file_format", "color_mode", "color_depth") if hasattr(image, name)}
    stand_in = None
    try:
        render.engine, render.use_sequencer = ENGINE, False
        if scene.camera is None:
            stand_in = bpy.data.objects.new("CAD Shadow stand-in", bpy.data.cameras.new("CAD Shadow stand-in"))
            scene.camera = stand_in
        if write_to is not None:
            render.filepath, render.use_file_extension, render.use_overwrite, render.use_placeholder = str(write_to), False, True, False
            _choose_format(image, write_to.suffix)
        yield
    finally:
        if stand_in is not None:
            scene.camera = None
            bpy.data.cameras.remove(stand_in.data)
        for holder, values in ((image, kept_image), (render, kept)):
            for name, value in values.items():
                setattr(holder, name, value)


def _choose_format(image: bpy.types.ImageFormatSettings, suffix: str) -> None:
    """PNG or EXR for a file name; colour mode and depth stay the scene's where that format has them."""
    wanted = {".png": "PNG", ".exr": "OPEN_EXR"}[suffix]
    if image.file_format == wanted:
        return
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format = wanted
    image.color_mode = "RGBA"
    image.color_depth = "32" if wanted == "OPEN_EXR" else "8"
