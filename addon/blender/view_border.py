"""The part of a 3D viewport that its render border, or the scene's in camera view, lets be seen. No OpenGL but for the scissor."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import ceil, floor

import bpy
from mathutils import Vector

Part = tuple[int, int, int, int]
"""x, y, width and height in pixels of the region, y upwards."""


def shown_part(space: bpy.types.SpaceView3D, rv3d: bpy.types.RegionView3D, scene: bpy.types.Scene, size: tuple[int, int]) -> Part | None:
    """What the border leaves of a region of `size` (width, height) pixels; None where there is no border.

    A border in camera view counts from the camera's frame, one of the viewport's own from the region.
    """
    if rv3d.view_perspective != "CAMERA":
        if not space.use_render_border:
            return None
        ends = [(getattr(space, f"render_border_{end}_x"), getattr(space, f"render_border_{end}_y")) for end in ("min", "max")]
        return _rounded([(x * size[0], y * size[1]) for x, y in ends], size)
    camera, render = space.camera, scene.render
    if not render.use_border or camera is None or camera.type != "CAMERA":
        return None
    low, high = _frame_px(camera, rv3d, scene, size)
    ends = ((render.border_min_x, render.border_min_y), (render.border_max_x, render.border_max_y))
    return _rounded([tuple(a + (b - a) * share for a, b, share in zip(low, high, end, strict=True)) for end in ends], size)


def _frame_px(
    camera: bpy.types.Object, rv3d: bpy.types.RegionView3D, scene: bpy.types.Scene, size: tuple[int, int]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """The lower left and the upper right corner of the camera's frame in the region."""
    world = camera.matrix_world.normalized()
    clips = [rv3d.perspective_matrix @ (world @ corner).to_4d() for corner in camera.data.view_frame(scene=scene)]
    places = [Vector((c.x / c.w, c.y / c.w)) for c in clips]
    xs, ys = ([(place[axis] * 0.5 + 0.5) * size[axis] for place in places] for axis in (0, 1))
    return (min(xs), min(ys)), (max(xs), max(ys))


def _rounded(ends: list[tuple[float, float]], size: tuple[int, int]) -> Part:
    """Whole pixels that lie in the region."""
    (x0, y0), (x1, y1) = ends
    left, low = max(floor(x0), 0), max(floor(y0), 0)
    return left, low, max(min(ceil(x1), size[0]) - left, 0), max(min(ceil(y1), size[1]) - low, 0)


@contextmanager
def only_in(part: Part | None) -> Iterator[None]:
    """Draw in that part of the region alone."""
    if part is None:
        yield
        return
    import gpu  # not there without a window

    before = gpu.state.scissor_get()
    gpu.state.scissor_test_set(True)
    gpu.state.scissor_set(*part)
    try:
        yield
    finally:
        gpu.state.scissor_set(*before)
        gpu.state.scissor_test_set(False)
