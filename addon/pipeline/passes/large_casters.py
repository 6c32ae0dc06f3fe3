"""Casters too large for a shadow map's float32: cut to the map in float64 (`maths/shadow/cut.py`) and drawn as what is left. Worker thread
only.

Whole clusters are taken out of the ordinary draw; their small triangles pass through unchanged. Ids are those of the ordinary draw.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from ...maths.shadow import cut
from ...maths.shadow.projection import ShadowProjection
from ...maths.spaces import transform
from ..geometry.draw_list import Chosen, DrawList

MARGIN_TEXELS = 8.0  # beyond the map's border, so that filters find no rim
VERTEX = np.dtype([("in_clip", "f4", 4), ("in_slot", "u4"), ("in_triangle", "u4")])


def large_in(draw_list: DrawList, projection: ShadowProjection, planes: np.ndarray, rows: np.ndarray | None) -> Chosen | None:
    """What of the draw list is too large for this map; None where nothing is (the usual case, told by one comparison)."""
    if not cut.reach(projection, draw_list.longest_edge_m) > cut.LARGE:
        return None
    chosen = draw_list.chosen(planes, partial(cut.are_large, projection), rows)
    return chosen if chosen else None


def pieces(draw_list: DrawList, projection: ShadowProjection, chosen: Chosen, size: int) -> np.ndarray:
    """(3·F,) `VERTEX`: what the map of `size` texels shows of `chosen`, three vertices a triangle."""
    planes = cut.map_planes(projection, 2.0 * MARGIN_TEXELS / size)
    found = []
    for corners_ws, slot, triangle in triangles_of(draw_list, chosen):
        corners, source = cut.cut(transform(projection.clip_from_world, corners_ws), planes)
        vertices = np.empty(3 * len(source), VERTEX)
        vertices["in_clip"] = corners.reshape(-1, 4)
        vertices["in_slot"], vertices["in_triangle"] = slot, np.repeat(triangle[source], 3)
        found.append(vertices)
    return np.concatenate(found)


def triangles_of(draw_list: DrawList, chosen: Chosen) -> Iterator[tuple[np.ndarray, int, np.ndarray]]:
    """World corners (T, 3, 3) float64, slot, and numbers in the index pool (T,) of every cluster and instance chosen."""
    for part in draw_list.parts_of(chosen):
        world = draw_list.scene.instances.world_from_object[part.row]
        yield transform(world, part.corners_os)[..., :3], part.slot, part.first_triangle + np.arange(len(part.corners_os))
