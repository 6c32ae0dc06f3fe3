"""Casters too large for a shadow map's float32: cut to the map in float64 (`maths/shadow/cut.py`) and drawn as what is left. Worker thread
only.

Whole clusters are taken out of the ordinary draw; their small triangles pass through unchanged. Ids are those of the ordinary draw.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import moderngl
import numpy as np

from ...maths.shadow.cut import are_large, cut, map_planes, reach_limit, w_range
from ...maths.shadow.projection import ShadowProjection
from ...maths.spaces import transform
from ..geometry.draw_list import Chosen, DrawList
from ..gl.gl_raw import draw_triangles

MARGIN_TEXELS = 8.0  # beyond the map's border, so that filters find no rim


def large_in(draw_list: DrawList, projection: ShadowProjection, planes: np.ndarray, rows: np.ndarray | None) -> Chosen | None:
    """What of the draw list is too large for this map; None where nothing is (the usual case, told by one comparison)."""
    extent = np.linalg.norm(projection.clip_from_world[[0, 1, 3], :3], axis=1).max()
    if not draw_list.longest_edge_m * extent > reach_limit() * w_range(projection)[0]:
        return None
    chosen = draw_list.chosen(planes, partial(are_large, projection), rows)
    return chosen if chosen else None


def draw_cut(program: moderngl.Program, draw_list: DrawList, projection: ShadowProjection, chosen: Chosen, size: int) -> int:
    """Draw what the map of `size` texels shows of `chosen`; returns the triangles sent. `program` takes clip coordinates and ids."""
    planes = map_planes(projection, 2.0 * MARGIN_TEXELS / size)
    pieces = []
    for corners_ws, slot, triangle in triangles_of(draw_list, chosen):
        corners, source = cut(transform(projection.clip_from_world, corners_ws), planes)
        vertices = np.empty(3 * len(source), [("clip", "f4", 4), ("slot", "u4"), ("triangle", "u4")])
        vertices["clip"] = corners.reshape(-1, 4)
        vertices["slot"], vertices["triangle"] = slot, np.repeat(triangle[source], 3)
        pieces.append(vertices)
    vertices = np.concatenate(pieces)
    if not len(vertices):
        return 0
    _draw(draw_list, program, vertices)
    return len(vertices) // 3


def _draw(draw_list: DrawList, program: moderngl.Program, vertices: np.ndarray) -> None:
    draw_list.bind_table()
    buffer = draw_list.context.buffer(vertices.tobytes())
    formats = {"in_clip": "4f4", "in_slot": "1u4", "in_triangle": "1u4"}
    used = {name: kind if name in program else "4x" for name, kind in formats.items()}  # x: bytes passed over
    array = draw_list.context.vertex_array(program, [(buffer, " ".join(used.values()), *(name for name in used if name in program))])
    draw_triangles(draw_list.context, array, len(vertices))
    array.release()
    buffer.release()


def triangles_of(draw_list: DrawList, chosen: Chosen) -> Iterator[tuple[np.ndarray, int, np.ndarray]]:
    """World corners (T, 3, 3) float64, slot, and numbers in the index pool (T,) of every cluster and instance chosen."""
    for part in draw_list.parts_of(chosen):
        world = draw_list.scene.instances.world_from_object[part.row]
        yield transform(world, part.corners_os)[..., :3], part.slot, part.first_triangle + np.arange(len(part.corners_os))
