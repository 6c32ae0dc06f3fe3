"""The planes of visible triangles that are huge beside what the camera sees of them, in float64. Worker thread only.

A shader that makes a plane from float32 corners 20 km away is off by millimetres at the eye's feet. Such triangles are few: their planes
are worked out here and looked up by slot and triangle (`shaders/common_large.glsl`).
"""

from __future__ import annotations

import moderngl
import numpy as np

from ...maths.view import Camera
from ..geometry.clusters import frustum_planes, longest_edge
from ..geometry.draw_list import DrawList
from ..gl.gl_raw import BufferTexture
from .large_casters import triangles_of

STEPS = 256.0  # edges longer than so many nearest view depths: there float32's noise is 1/8000 of what is seen


class LargePlanes:
    """A table of planes, sorted by (slot, triangle); `count` rows, `texture` RGBA32UI, two texels a row (key; plane's bits)."""

    def __init__(self, context: moderngl.Context, keys: np.ndarray, planes: np.ndarray) -> None:
        rows = np.zeros((max(len(keys), 1), 2, 4), np.uint32)
        rows[: len(keys), 0, :2] = keys
        rows[: len(keys), 1] = planes.astype(np.float32).view(np.uint32)
        self.count = len(keys)
        self._buffer = context.buffer(rows.tobytes())
        self.texture = BufferTexture(context, self._buffer, "rgba32ui")

    def release(self) -> None:
        """Free the table."""
        self.texture.release()
        self._buffer.release()


def large_planes(draw_list: DrawList, camera: Camera, origin_ws: np.ndarray, nearest: float) -> tuple[np.ndarray, np.ndarray]:
    """Keys (L, 2) uint32 and planes (L, 4) float64 relative to `origin_ws`, unit normals by the winding, of what the camera may see.

    `nearest` is the least view depth that counts, metres (of a parallel view, the height of the picture).
    """
    least, planes = STEPS * nearest, frustum_planes(camera.clip_from_world)
    keys, found = [np.empty((0, 2), np.uint32)], [np.empty((0, 4))]
    for corners, slot, triangle in triangles_of(draw_list, draw_list.chosen(planes, lambda _, edge: edge > least)):
        corners, triangle = _seen(corners, triangle, planes, least)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        found.append(np.column_stack([normal, -np.einsum("ij,ij->i", normal, corners[:, 0] - origin_ws)]))
        keys.append(np.column_stack([np.full(len(triangle), slot), triangle]).astype(np.uint32))
    keys, found = np.concatenate(keys), np.concatenate(found)
    order = np.lexsort((keys[:, 1], keys[:, 0]))
    return keys[order], found[order]


def _seen(corners: np.ndarray, triangle: np.ndarray, planes: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Those with an edge longer than `least` that no plane of the view shuts out."""
    inside = (corners @ planes[:, :3].T + planes[:, 3] >= 0.0).any(axis=1).all(axis=1)
    chosen = inside & (longest_edge(corners) > least)
    return corners[chosen], triangle[chosen]
