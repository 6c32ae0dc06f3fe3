"""Casters of a logarithmic map on stock OpenGL 3.3 (LogPSM §5.1.3, §5.1.4, which held it to be impossible). Worker thread only.

Straight edges become curves. The geometry stage cuts every triangle at fixed rows of the map, so near to each other that from row to row
an edge is straight to `BEND_TEXELS`; the pieces are rasterised as any others are. Nothing is tested, discarded or drawn twice per texel.
"""

from __future__ import annotations

import math

import numpy as np

from ...maths.shadow.projection import ShadowProjection
from ..geometry.clusters import frustum_planes
from ..geometry.draw_list import DrawList
from ..gl.gl_raw import draw_vertices
from ..gl.programs import Programs, relative_to, set_uniforms
from .large_casters import large_in, pieces

BEND_TEXELS = 0.015  # largest distance, along t, between an edge's piece and its curve
BALANCE = 0.75  # of a chord's largest miss is taken off its ends: the least mean distance from the curve, on either side of it
MOST_SLABS = 48  # slabs of one triangle that a draw emits (OpenGL grants 1024 numbers); longer ones are drawn again for the next


def log_warp_vector(projection: ShadowProjection) -> np.ndarray:
    """(4,) float32 (scale, offset, s divided, logarithmic): of `LogWarp`, as the shaders take it."""
    log = projection.log
    if log is None:
        return np.zeros(4, np.float32)
    return np.array([log.scale, log.offset, float(log.perspective_s), 1.0], np.float32)


def log_bend_vector(projection: ShadowProjection) -> np.ndarray:
    """(2,) float32 (base, slope) of the divisor in t, as the shaders take it."""
    log = projection.log
    return np.array([1.0, 0.0] if log is None else [log.base, log.slope], np.float32)


def draw_log_map(
    programs: Programs,
    draw_list: DrawList,
    origin_ws: np.ndarray,
    projection: ShadowProjection,
    size: int,
    defines: dict[str, int],
    rows: np.ndarray | None = None,
) -> int:
    """Draw the casters, of the instance rows `rows` (I,) bool, into the bound layer of `size` texels, ids as `defines` say; returns the
    triangles sent."""
    planes, slabs = log_planes(projection), cut_rows(projection, size)
    limits = {"MOST_SLABS": MOST_SLABS, "MOST_VERTICES": 2 * MOST_SLABS + 5, **defines}
    stages = "shadow_log.frag", "shadow_log.geom"
    pair = [programs.get("shadow.vert", *stages, INSTANCED=flag, **limits) for flag in (0, 1)]
    large = large_in(draw_list, projection, planes, rows)
    large_pair = []
    if large is not None:
        large_pair = [(programs.get("shadow_cut.vert", *stages, IS_CUT=1, **limits), pieces(draw_list, projection, large, size))]
    sent = 0
    for first in range(0, slabs + 1, MOST_SLABS):
        for program in (*pair, *(program for program, _ in large_pair)):
            set_uniforms(
                program,
                **relative_to(origin_ws, projection.clip_from_world),
                u_log_warp=log_warp_vector(projection).tobytes(),
                u_log_bend=log_bend_vector(projection).tobytes(),
                u_rows=slabs,
                u_shift=BALANCE * (math.log(2.0) * 2.0 / slabs / projection.log.scale) ** 2 / 8.0,
                u_first_slab=first,
            )
        select = (lambda bounds, edge, first=first: most_cuts(projection, slabs, bounds, edge) >= first) if first else None
        sent += draw_list.draw(*pair, planes, attributes=False, select=select, rows=rows, without=large)
        sent += sum(draw_vertices(draw_list.context, *drawn) for drawn in large_pair)
    return sent


def log_planes(projection: ShadowProjection) -> np.ndarray:
    """(5, 4) world planes of a log map: its strip in t is that of the projective Y/w; depth (and s of plain 'log') are not divided."""
    rows = projection.clip_from_world
    one = np.array([0.0, 0.0, 0.0, 1.0])
    s_limit = rows[3] if projection.log.perspective_s else one
    planes = frustum_planes(projection.clip_from_world, cull_near=False)
    return np.stack([s_limit + rows[0], s_limit - rows[0], planes[2], planes[3], one - rows[2]])


def cut_rows(projection: ShadowProjection, size: int) -> int:
    """Slabs into which a map of `size` texels is cut, so that no edge leaves its curve between two rows by more than `BEND_TEXELS`.

    With t = k·ln(w/(base + slope·w)) an edge is straight in (X, w) and s = X/w affine in 1/w (s = X: in w, and slope 0); either way
    d²t/ds² = ± (dt/ds)²/k, so that a chord over g texels of t misses by g²/(8 k) texels along t, k in texels (Taylor at its middle);
    moved by `BALANCE` of that, it misses by at most `BALANCE` of it on either side.
    """
    k_texels = abs(projection.log.scale) / math.log(2.0) * size / 2.0
    return math.ceil(size / math.sqrt(8.0 * BEND_TEXELS / BALANCE * k_texels))


def most_cuts(projection: ShadowProjection, rows: int, bounds_ws: np.ndarray, longest_edge_m: np.ndarray) -> np.ndarray:
    """(B,) at least as many rows as a triangle inside each box (B, 2, 3), its edges no longer than `longest_edge_m`, can cross."""
    log, row = projection.log, projection.clip_from_world[3]
    ends = log.w_at(np.array([-1.0, 1.0]))
    centre, half = bounds_ws.mean(axis=1) @ row[:3] + row[3], (bounds_ws[:, 1] - bounds_ws[:, 0]) / 2 @ np.abs(row[:3])
    low, high = np.clip(centre - half, *ends), np.clip(centre + half, *ends)
    reach = np.minimum(longest_edge_m * np.linalg.norm(row[:3]), high - low)
    # dt/dw is convex in w, so the steepest stretch lies at an end
    climbed = [log.t_at(start + reach) - log.t_at(start) for start in (low, high - reach)]
    return np.ceil(0.5 * rows * np.maximum(*climbed)) + 1.0
