"""Blender cameras and viewports as `Camera`."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ..errors import SceneError
from ..maths.view import Camera


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
    if data.type == "ORTHO":
        clip_from_view[3] = (0.0, 0.0, 0.0, 1.0)
    view_from_world = rigid_inverse(matrix(ob.matrix_world), origin_ws)
    return Camera(view_from_world, clip_from_view, float(data.clip_start), float(data.clip_end), ob.name)


def camera_from_region(rv3d: bpy.types.RegionView3D, space: bpy.types.SpaceView3D, origin_ws: np.ndarray, size: tuple[int, int]) -> Camera:
    """The view of a 3D viewport. `size` = (width, height) of its region in pixels.

    In camera view Blender's own window matrix already holds the passepartout's zoom and shift. Near and far come back out of that
    matrix, which knows about orthographic viewports (whose clip start is minus the clip end).
    """
    clip_from_view = matrix(rv3d.window_matrix)
    view_from_world = matrix(rv3d.view_matrix)
    view_from_world = rigid_inverse(np.linalg.inv(view_from_world), origin_ws)
    a, b = clip_from_view[2, 2], clip_from_view[2, 3]
    if rv3d.is_perspective:
        near, far = b / (a - 1.0), b / (a + 1.0)
        if not 0.0 < near < far < np.inf:
            near, far = float(space.clip_start), float(space.clip_end)
    else:
        clip_from_view[3] = (0.0, 0.0, 0.0, 1.0)
        near, far = (b + 1.0) / a, (b - 1.0) / a
    return Camera(view_from_world, clip_from_view, float(near), float(far), "viewport")
