"""A picture as a Blender image, and in front of the user: the image "CAD Shadow Preview" in an Image Editor."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

from ..errors import OutputError
from ..images.srgb import linear_from_srgb
from . import own_images
from .rendering import file_format

NAME = "CAD Shadow Preview"


def to_image(picture: np.ndarray, name: str = NAME, is_data: bool = False) -> bpy.types.Image:
    """The float image `name` with this (h, w, 4) picture: scene linear and seen through the view transform like a render, or data as it is.

    One made before is filled anew or replaced, so that an editor that shows it goes on showing it; an image of the user's own that bears
    the name stays, and ours is called `name`.001. It is packed: Blender shows only images with a file, own or packed, through the view
    transform, and a saved .blend keeps the picture.
    """
    height, width = picture.shape[:2]
    image = own_images.find(name)
    fits = image is not None and tuple(image.size) == (width, height) and image.is_float and image.use_view_as_render != is_data
    if not fits:
        image = own_images.make(name, width, height, alpha=True, float_buffer=True, is_data=is_data)
        image.use_view_as_render = not is_data
        image.alpha_mode = "PREMUL"
    image.pixels.foreach_set(np.ascontiguousarray(picture[::-1], dtype=np.float32).ravel())
    image.update()
    image.pack()
    return image


def displayed(picture: np.ndarray) -> np.ndarray:
    """A uint8 or uint16 picture as files hold it (sRGB), grey or RGB, as the (h, w, 4) opaque linear values that an editor shows alike."""
    most = np.iinfo(picture.dtype).max
    values = np.arange(most + 1, dtype=np.float32) / np.float32(most)
    linear = linear_from_srgb(np.stack([values] * 3, axis=-1))[:, 0].astype(np.float32)  # of every value there can be
    out = np.ones((*picture.shape[:2], 4), np.float32)
    out[..., :3] = linear[picture if picture.ndim == 3 else picture[..., None]]
    return out


def save_as_render(image: bpy.types.Image, path: Path, scene: bpy.types.Scene) -> None:
    """Write an image through the scene's view transform, as a render is written (but without dithering). Raises `OutputError`."""
    with file_format(scene, path):
        try:
            image.save_render(str(path), scene=scene)
        except (RuntimeError, UnicodeEncodeError) as error:
            raise OutputError(f"{path} cannot be written ({' '.join(str(error).split())}): choose another folder.") from error


def show(context: bpy.types.Context, image: bpy.types.Image) -> bool:
    """Show `image` in an Image Editor, at once or with Blender's next turn. False when Blender runs without a window.

    The editor is one that shows a picture of ours or nothing, else the window that Blender shows renders in, which is opened and raised
    as for a render: so there is one window however many pictures are made, and F12 shows its own in it. It is opened from a timer: an
    operator in whose `modal` a window opens is called for ever.
    """
    if bpy.app.background or not context.window_manager.windows:
        return False
    area = _free_editor(context)
    if area is not None:
        _put(area, image)
    else:
        _waiting[:] = [image.name]
        if not bpy.app.timers.is_registered(_open):
            bpy.app.timers.register(_open, first_interval=0.0)
    return True


_waiting: list[str] = []


def _put(area: bpy.types.Area, image: bpy.types.Image) -> None:
    area.spaces.active.image = image
    area.tag_redraw()


def _free_editor(context: bpy.types.Context) -> bpy.types.Area | None:
    """An Image Editor in the user's own windows that may show our picture: it shows one already, or none, and is not pinned."""
    screens = [window.screen for window in context.window_manager.windows if not window.screen.is_temporary]
    spaces = [(area, area.spaces.active) for screen in screens for area in screen.areas if area.ui_type == "IMAGE_EDITOR"]
    free = [(area, space.image) for area, space in spaces if not space.use_image_pin and (space.image is None or _is_picture(space.image))]
    return next((area for area, image in sorted(free, key=lambda one: one[1] is None)), None)


def _is_picture(image: bpy.types.Image) -> bool:
    return (own_images.title_of(image) or "").startswith(NAME)


def _open() -> None:
    """Blender's timer: the picture that waits, in the render's window."""
    image = bpy.data.images.get(_waiting.pop()) if _waiting else None
    if image is not None:
        _put(_render_editor(bpy.context) or _new_editor(bpy.context), image)


def _temporary_editor(context: bpy.types.Context) -> bpy.types.Area | None:
    areas = [w.screen.areas[0] for w in context.window_manager.windows if w.screen.is_temporary and len(w.screen.areas)]
    return next((area for area in areas if area.type == "IMAGE_EDITOR"), None)


def _render_editor(context: bpy.types.Context) -> bpy.types.Area | None:
    """The editor of the window for renders, raised, or opened if there is none; None where Blender would show a render elsewhere."""
    main = next((window for window in context.window_manager.windows if not window.screen.is_temporary), None)
    with _renders_in_a_window(context.preferences), context.temp_override(window=main):
        bpy.ops.render.view_show("INVOKE_DEFAULT")
    return _temporary_editor(context)


@contextmanager
def _renders_in_a_window(preferences: bpy.types.Preferences) -> Iterator[None]:
    """While this lasts renders are shown in a window of their own; the user's preferences are as they were afterwards."""
    kept, was_dirty = preferences.view.render_display_type, preferences.is_dirty
    preferences.view.render_display_type = "WINDOW"
    try:
        yield
    finally:
        preferences.view.render_display_type, preferences.is_dirty = kept, was_dirty


def _new_editor(context: bpy.types.Context) -> bpy.types.Area:
    before = set(context.window_manager.windows)
    with context.temp_override(window=context.window_manager.windows[0]):
        bpy.ops.wm.window_new()
    window = next(w for w in context.window_manager.windows if w not in before)
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    area.type = "IMAGE_EDITOR"
    return area
