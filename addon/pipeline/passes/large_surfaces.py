"""Triangles too large for a camera's float32: cut to what it sees in float64 and drawn as what is left. Worker thread only.

What float32 rounds at a corner 7 km away shows at the eye's feet as half a millimetre: two grounds as near to each other would show in
turns. The corners of what is left lie where the camera looks, and are as exact as what it sees. Whole clusters are taken.
"""

from __future__ import annotations

import numpy as np

from ...maths.anchored_camera import AnchoredCamera
from ...maths.shadow.cut import cut
from ...maths.spaces import transform
from ..geometry.draw_list import Chosen, DrawList
from ..geometry.store import turned

MARGIN_PX = 4.0  # beyond the picture's border
VERTEX = np.dtype([("in_seen", "f4", 3), ("in_normal_ws", "f4", 3), ("in_slot", "u4"), ("in_triangle", "u4")])


def large_in(draw_list: DrawList, eye: AnchoredCamera, frustum: np.ndarray, rows: np.ndarray | None) -> Chosen | None:
    """The clusters and instances in view that hold a triangle large for this eye; None where nothing does (the usual case)."""
    if not draw_list.longest_edge_m > eye.least_large_m:
        return None
    chosen = draw_list.chosen(frustum, eye.is_large, rows)
    if not chosen:
        return None
    holds = iter([bool(eye.is_large(*draw_list.boxes_of(part)).any()) for part in draw_list.parts_of(chosen)])
    for mask in (chosen.ranges, *chosen.groups):  # of a fine mesh round the eye, its own box and longest edge say nothing
        mask[mask] = [next(holds) for _ in range(mask.sum())]
    return chosen if chosen else None


def pieces(draw_list: DrawList, chosen: Chosen, eye: AnchoredCamera, size: tuple[int, int]) -> np.ndarray:
    """(3·F,) `VERTEX`: what is left of the triangles, three vertices each, for gbuffer_cut.vert."""
    parts = list(draw_list.parts_of(chosen))
    seen_from_world = np.concatenate([eye.rows_ws, [[0.0, 0.0, 0.0, 1.0]]])
    worlds = [draw_list.scene.instances.world_from_object[part.row] for part in parts]
    whole = np.concatenate([transform(seen_from_world @ world, part.corners_os) for part, world in zip(parts, worlds, strict=True)])
    corners, source = cut(whole, view_planes(eye, size))
    counts = np.cumsum([0, *(len(part.corners_os) for part in parts)])
    vertices = np.empty((len(source), 3), VERTEX)
    vertices["in_seen"] = corners[..., :3]
    weights = _weights(corners[..., :3], whole[source, :, :3])
    for part, world, start, stop in zip(parts, worlds, counts[:-1], counts[1:], strict=True):
        mine = slice(*np.searchsorted(source, [start, stop]))
        local = source[mine] - start
        vertices["in_slot"][mine], vertices["in_triangle"][mine] = part.slot, (part.first_triangle + local)[:, None]
        normals = turned(draw_list.normals_os(part)[local].reshape(-1, 3), world).reshape(-1, 3, 3)
        vertices["in_normal_ws"][mine] = np.einsum("fvk,fkc->fvc", weights[mine], normals)
    return vertices.ravel()


def view_planes(eye: AnchoredCamera, size: tuple[int, int]) -> np.ndarray:
    """(6, 5) planes p · (clip x, clip y, metres behind the near plane, 1, 1) ≥ 0 of the picture, `MARGIN_PX` wider, near and far."""
    _, _, c, e = eye.depth.rule
    sides = []
    for axis in (0, 1):
        wide = 1.0 + 2.0 * MARGIN_PX / size[axis]
        for sign in (-1.0, 1.0):
            side = np.array([0.0, 0.0, wide * e, wide * c, 0.0])
            side[axis] = sign
            sides.append(side)
    return np.array([[0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, eye.depth.far - eye.depth.near, 0.0], *sides])


def _weights(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(F, 3, 3): how much of each corner of its triangle (F, 3, 3) a point (F, 3, 3) of it is."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    normal = np.cross(b - a, c - a)
    area = np.maximum(np.einsum("fc,fc->f", normal, normal), 1e-300)[:, None]
    out = points - a[:, None]
    second = np.einsum("fvc,fc->fv", np.cross(out, (c - a)[:, None]), normal) / area
    third = np.einsum("fvc,fc->fv", np.cross((b - a)[:, None], out), normal) / area
    return np.stack([1.0 - second - third, second, third], axis=-1)
