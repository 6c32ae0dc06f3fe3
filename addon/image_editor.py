"""A picture as a Blender image, and in front of the user: the image "CAD Shadow Preview" in an Image Editor."""

from __future__ import annotations

import bpy
import numpy as np

NAME = "CAD Shadow Preview"


def to_image(picture: np.ndarray, name: str = NAME) -> bpy.types.Image:
    """The float image `name` with this (h, w, 4) scene-linear picture, seen through the scene's view transform like a render.

    An image of that name and size is filled anew, so that an editor that shows it goes on showing it.
    """
    height, width = picture.shape[:2]
    image = bpy.data.images.get(name)
    if image is not None and (tuple(image.size) != (width, height) or not image.is_float):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
        image.use_view_as_render = True
        image.alpha_mode = "PREMUL"
    image.pixels.foreach_set(np.ascontiguousarray(picture[::-1], dtype=np.float32).ravel())
    image.update()
    return image


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
