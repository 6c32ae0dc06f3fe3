"""Blender cameras and viewports as `Camera`."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...errors import SceneError
from ...maths.spaces import with_depth_range
from ...maths.view import Camera

FLOAT32_STEPS = 5e-7
"""Of a number: what Blender's own arithmetic may be off by."""


def matrix(source: Sequence) -> np.ndarray:
    """(4, 4) float64 of a `mathutils.Matrix`."""
    return np.array([row[:] for row in source], dtype=np.float64)


def rigid_inverse(world_from_object: np.ndarray, origin_ws: np.ndarray) -> np.ndarray:
    """View matrix of a placed object, its scale dropped as Blender drops a camera's, in a world relative to `origin_ws`."""
    axes = world_from_object[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    if not bool((lengths > 0.0).all()):
        raise SceneError("The camera is scaled to zero: set its scale back to 1.")
    rotation = axes / lengths
    out = np.eye(4)
    out[:3, :3] = np.linalg.inv(rotation)
    out[:3, 3] = -out[:3, :3] @ (world_from_object[:3, 3] - origin_ws)
    return out


def camera_from_object(ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph, size: tuple[int, int], origin_ws: np.ndarray) -> Camera:
    """The camera object as it would render at `size` = (width, height); near and far are its clip distances.

    `ob` original or evaluated; raises `SceneError` for panoramic cameras and impossible clip distances.
    """
    data = ob.data
    if data.type not in ("PERSP", "ORTHO"):
        raise SceneError(f"Camera '{ob.name}' is panoramic, which shadow maps cannot serve: set its type to Perspective or Orthographic.")
    if not data.clip_start < data.clip_end:
        raise SceneError(f"Camera '{ob.name}' has its clip start beyond its clip end: set the start to the smaller distance.")
    render = depsgraph.scene.render
    projection = ob.calc_matrix_camera(depsgraph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
    clip_from_view = matrix(projection)
    near, far = float(data.clip_start), float(data.clip_end)
    clip_from_view = with_depth_range(clip_from_view, near, far, data.type == "ORTHO")
    return Camera(rigid_inverse(matrix(ob.matrix_world), origin_ws), clip_from_view, near, far, ob.name)


def camera_from_region(rv3d: bpy.types.RegionView3D, space: bpy.types.SpaceView3D, origin_ws: np.ndarray, size: tuple[int, int]) -> Camera:
    """The view of a 3D viewport. `size` = (width, height) of its region in pixels.

    In camera view Blender's own window matrix already holds the passepartout's zoom and shift. Near and far come back out of that
    matrix, which knows about orthographic viewports (whose clip start is minus the clip end).
    """
    clip_from_view = matrix(rv3d.window_matrix)
    view_from_world = rigid_inverse(np.linalg.inv(matrix(rv3d.view_matrix)), origin_ws)
    near, far = _depth_range(clip_from_view[2, 2:], rv3d.is_perspective, _clip_ranges(rv3d, space))
    clip_from_view = with_depth_range(clip_from_view, near, far, not rv3d.is_perspective)
    return Camera(view_from_world, clip_from_view, near, far, "viewport")


def _clip_ranges(rv3d: bpy.types.RegionView3D, space: bpy.types.SpaceView3D) -> list[tuple[float, float]]:
    """The near and far that Blender may have made the window matrix of: the camera's in camera view, the viewport's."""
    camera = space.camera if rv3d.view_perspective == "CAMERA" else None
    seen = [(float(camera.data.clip_start), float(camera.data.clip_end))] if camera is not None and camera.type == "CAMERA" else []
    return [*seen, (float(space.clip_start), float(space.clip_end)), (-0.5 * float(space.clip_end), 0.5 * float(space.clip_end))]


def _depth_range(row: np.ndarray, is_perspective: bool, ranges: list[tuple[float, float]]) -> tuple[float, float]:
    """Near and far of a float32 projection whose third row ends with `row` (2,): the range that it may be made of, or what it says itself.

    It says far to 1e-7 · far/near only.
    """
    for near, far in ranges:
        if near < far and (near > 0.0 or not is_perspective):
            made = with_depth_range(np.eye(4), near, far, not is_perspective)[2, 2:]
            if (np.abs(row - made) <= FLOAT32_STEPS * np.maximum(np.abs(made), [0.0, not is_perspective])).all():
                return near, far
    a, b = map(float, row)
    if not is_perspective:
        return (b + 1.0) / a, (b - 1.0) / a
    near, far = b / (a - 1.0), b / (a + 1.0) if a < -1.0 else np.inf
    return (near, far) if 0.0 < near < far < np.inf else ranges[0]
