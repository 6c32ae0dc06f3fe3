"""A picture as a Blender image, and in front of the user: the image "CAD Shadow Preview" in an Image Editor."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from . import own_images
from .cad_files.colors import linear_from_srgb
from .errors import OutputError
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
        except RuntimeError as error:
            raise OutputError(f"{path} cannot be written ({' '.join(str(error).split())}): choose another folder.") from error


def show(context: bpy.types.Context, image: bpy.types.Image) -> bool:
    """Show `image` in an Image Editor: one that is open, else in a new window. False when Blender runs without a window."""
    if bpy.app.background or not context.window_manager.windows:
        return False
    area = _image_editor(context) or _new_window(context)
    area.spaces.active.image = image
    area.tag_redraw()
    return True


def _image_editor(context: bpy.types.Context) -> bpy.types.Area | None:
    areas = [area for window in context.window_manager.windows for area in window.screen.areas if area.type == "IMAGE_EDITOR"]
    showing = [area for area in areas if area.spaces.active.image is None or area.spaces.active.image.name == NAME]
    return showing[0] if showing else None


def _new_window(context: bpy.types.Context) -> bpy.types.Area:
    before = set(context.window_manager.windows)
    with context.temp_override(window=context.window_manager.windows[0]):
        bpy.ops.wm.window_new()
    window = next(w for w in context.window_manager.windows if w not in before)
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    area.type = "IMAGE_EDITOR"
    return area
