"""Casters of a logarithmic map on stock OpenGL 3.3 (LogPSM §5.1.3, §5.1.4, which held it to be impossible). Worker thread only.

Straight edges become curves. Two ways, chosen per cluster from the bend its longest edge can show, so that the picture is exact and most
of the work is not: *vertex* — short edges: vertices are moved, edges stay straight; *exact* — the geometry stage emits the triangle's
box, the fragment stage inverts t at the texel centre and decides coverage and depth where everything is straight.
"""

from __future__ import annotations

import math

import numpy as np

from ..maths.projection import ShadowProjection
from .clusters import frustum_planes
from .draw_list import DrawList, Select
from .programs import Programs, matrix_bytes, set_uniforms

BEND_TEXELS = 0.02  # largest deviation of a straight edge from its curve that passes as exact


def log_warp_vector(projection: ShadowProjection) -> np.ndarray:
    """(4,) float32 (scale, offset, s divided, logarithmic): t = scale·log2(w) + offset, as the shaders take it."""
    log = projection.log
    if log is None:
        return np.zeros(4, np.float32)
    return np.array([log.scale, log.offset, float(log.perspective_s), 1.0], np.float32)


def draw_log_map(programs: Programs, draw_list: DrawList, projection: ShadowProjection, size: int, defines: dict[str, int]) -> int:
    """Draw the casters into the bound layer of `size` texels, ids as `defines` say; returns the triangles sent."""
    planes = log_planes(projection)
    bends = bending(projection, size)
    sent = 0
    for is_exact in (False, True):
        names = ("shadow_log.vert", "shadow_log.frag", "shadow_log.geom") if is_exact else ("shadow.vert", "shadow.frag")
        pair = [programs.get(*names, INSTANCED=flag, LOGARITHMIC=1, **defines) for flag in (0, 1)]
        for program in pair:
            set_uniforms(
                program,
                u_clip_from_world=matrix_bytes(projection.clip_from_world),
                u_map_size=float(size),
                u_log_warp=log_warp_vector(projection).tobytes(),
            )
        select: Select = bends if is_exact else (lambda bounds, edge: ~bends(bounds, edge))
        sent += draw_list.draw(*pair, planes, attributes=False, select=select)
    return sent


def log_planes(projection: ShadowProjection) -> np.ndarray:
    """(5, 4) world planes of a log map: its strip in t is that of the projective Y/w; depth (and s of plain 'log') are not divided."""
    rows = projection.clip_from_world
    one = np.array([0.0, 0.0, 0.0, 1.0])
    s_limit = rows[3] if projection.log.perspective_s else one
    planes = frustum_planes(projection.clip_from_world, cull_near=False)
    return np.stack([s_limit + rows[0], s_limit - rows[0], planes[2], planes[3], one - rows[2]])


def bending(projection: ShadowProjection, size: int) -> Select:
    """A `Select` that is True where an edge may leave its curve by more than `BEND_TEXELS`.

    Along an edge of length e, w changes by at most q = e·|∇w|/w (relative). With t = scale·log2 w the curve leaves its chord by at most
    scale/ln 2 · q²/8 in NDC; s = X/w, rational on the edge as t is, adds at most as much times the map's half width: bounded by the same q.
    """
    gradient = float(np.linalg.norm(projection.clip_from_world[3, :3]))
    texels_per_ndc = size / 2.0
    limit = math.sqrt(8.0 * BEND_TEXELS / (texels_per_ndc * (abs(projection.log.scale) / math.log(2.0) + 1.0)))
    row = projection.clip_from_world[3]

    def bends(bounds_ws: np.ndarray, longest_edge_m: np.ndarray) -> np.ndarray:
        centre, half = bounds_ws.mean(axis=1), (bounds_ws[:, 1] - bounds_ws[:, 0]) / 2
        w_least = centre @ row[:3] + row[3] - half @ np.abs(row[:3])
        return longest_edge_m * gradient > limit * np.maximum(w_least, 1e-6)

    return bends
