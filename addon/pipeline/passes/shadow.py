"""The light's passes: one layer of a 32-bit float depth array per shadow projection. Worker thread only."""

from __future__ import annotations

from collections.abc import Hashable
from contextlib import ExitStack
from functools import partial

import moderngl
import numpy as np

from ...errors import GpuError
from ...maths.shadow import cut
from ...maths.shadow.projection import ShadowPlan, ShadowProjection
from ...maths.spaces import translation
from ...settings.groups import ShadowTestChoice
from ...settings.shadowing import SHADOW_TESTS
from ..detail.drawn import ChosenLevels, CoarseCasters
from ..geometry.clusters import frustum_planes
from ..geometry.culling import Culling
from ..geometry.draw_list import DrawList
from ..gl.allocation import freed_with
from ..gl.gl_raw import GL_DEPTH_CLAMP, DepthArray, LayerFramebuffer, draw_vertices, id_array
from ..gl.machine import check_maps
from ..gl.programs import Programs, relative_to, set_uniforms
from .large_casters import large_in, pieces
from .log_map import draw_log_map, log_bend_vector, log_warp_vector
from .nsm import NsmCells
from .outline import OutlineIds

MAX_MAPS = 48
_FLOATS_PER_MAP = 60


class ShadowMaps:
    """A depth array and a framebuffer per layer; with a test that needs them, an array of ids beside it, the ids of outlines, and the
    cells of the n-SM.

    `holds` says what was drawn last (plan, ids), by whoever can say; None as soon as anything is drawn. `sent`: the triangles that it took;
    `caster_error`: the largest error of coarser casters among them, texels.
    """

    def __init__(self, context: moderngl.Context, size: int, layers: int, test: ShadowTestChoice) -> None:
        limit = context.info["GL_MAX_TEXTURE_SIZE"]
        if size > limit:
            raise GpuError(
                f"A shadow map of {size} texels is larger than this driver's limit of {limit}: choose a map size of {limit} or less."
            )
        if layers > MAX_MAPS:
            raise GpuError(f"{layers} shadow maps are more than the {MAX_MAPS} a picture can use: choose fewer partitions.")
        self.ids_kind = SHADOW_TESTS[test.kind].stored.numbers
        check_maps(size, layers, self.ids_kind, test.depths > 1 or test.has_outlines)
        self.size, self.layers = size, layers
        self.holds: Hashable = None
        self.sent, self.caster_error = 0, 0.0
        with ExitStack() as made:  # what is there when something fails is freed
            self.depth = freed_with(made, DepthArray(context, size, layers))
            self.ids = freed_with(made, id_array(context, size, layers, self.ids_kind)) if self.ids_kind else None
            colors = [self.ids] if self.ids_kind else []
            self.framebuffers = [freed_with(made, LayerFramebuffer(context, self.depth, layer, colors)) for layer in range(layers)]
            self.outlines = freed_with(made, OutlineIds(context, size, layers)) if test.has_outlines else None
            self.cells = freed_with(made, NsmCells(context, size, layers, test.depths, self.ids)) if test.depths > 1 else None
            self._made = made.pop_all()

    def release(self) -> None:
        """Free the arrays and their framebuffers."""
        self._made.close()

    def inputs(self) -> dict[str, object]:
        """The textures that the tests read, by sampler name."""
        named = {"u_shadow_depth": self.depth, "u_shadow_ids": self.ids, "u_outline_ids": self.outlines.ids if self.outlines else None}
        return {name: texture for name, texture in named.items() if texture is not None} | (self.cells.inputs() if self.cells else {})

    def read(self) -> np.ndarray:
        """(layers, size, size) float32 depth 0…1, row 0 at t = −1."""
        return np.frombuffer(self.depth.read(), np.float32).reshape(self.layers, self.size, self.size)


def draw_shadow_maps(
    context: moderngl.Context,
    programs: Programs,
    maps: ShadowMaps,
    draw_list: DrawList,
    plan: ShadowPlan,
    test: ShadowTestChoice,
    rows: np.ndarray | None = None,
    coarse: CoarseCasters | None = None,
    is_sun: bool = True,
) -> int:
    """Draw the casters into every map; returns the triangles sent. Casters before a map's near plane are clamped to it (depth clamp).

    `rows` (I,) bool: only these instance rows of the scene. `coarse`: coarser meshes, drawn where the test's `caster_error` allows.
    """
    defines = {"IDS": maps.ids_kind, "ID_PER_MATERIAL": int(test.id_per_material)}
    draw = partial(draw_one, programs, draw_list, plan.origin_ws, size=maps.size, defines=defines, rows=rows)
    maps.holds, maps.caster_error = None, 0.0
    context.enable_only(moderngl.DEPTH_TEST)
    context.enable_direct(GL_DEPTH_CLAMP)
    sent = 0
    for projection, framebuffer in zip(plan.projections, maps.framebuffers, strict=False):
        framebuffer.use()
        framebuffer.framebuffer.clear(depth=1.0)
        if maps.ids_kind:
            framebuffer.clear_ids()
        if not projection.is_empty:
            chosen = coarse.choose(projection, maps.size, is_sun, test.caster_error) if coarse is not None else None
            maps.caster_error = max(maps.caster_error, chosen.error_texels if chosen is not None else 0.0)
            sent += draw(projection, culled=True, coarse=(coarse, chosen) if chosen is not None else None)
    if maps.outlines is not None:
        sent += maps.outlines.draw(plan, draw)
    context.disable_direct(GL_DEPTH_CLAMP)
    if maps.cells is not None:
        maps.cells.select(programs, maps.depth, plan)
    maps.sent = sent
    return sent


def draw_one(
    programs: Programs,
    draw_list: DrawList,
    origin_ws: np.ndarray,
    projection: ShadowProjection,
    size: int,
    defines: dict[str, int],
    rows: np.ndarray | None,
    culled: bool = False,
    coarse: tuple[CoarseCasters, ChosenLevels] | None = None,
) -> int:
    """Draw one map; `culled`: without the back faces of closed meshes, whose edges outlines need."""
    if projection.log is not None:
        return draw_log_map(programs, draw_list, origin_ws, projection, size, defines, rows)
    planes = frustum_planes(projection.clip_from_world, cull_near=False)
    culling = Culling.by(projection.clip_from_world, near=False) if culled else None
    sent = 0
    if coarse is not None and not cut.reach(projection, coarse[0].draw_list.longest_edge_m) > cut.LARGE:
        sent = _draw_coarse(programs, origin_ws, projection, planes, defines, rows, culling, *coarse)
        rows = ~coarse[1].replaced if rows is None else rows & ~coarse[1].replaced
    large = large_in(draw_list, projection, planes, rows)
    pair = [programs.get("shadow.vert", "shadow.frag", INSTANCED=flag, **defines) for flag in (0, 1)]
    for program in pair:
        set_uniforms(program, **relative_to(origin_ws, projection.clip_from_world))
    sent += draw_list.draw(*pair, planes, attributes=False, rows=rows, without=large, culling=culling)
    if large is not None:
        program = programs.get("shadow_cut.vert", "shadow.frag", IS_CUT=1, **defines)
        sent += draw_vertices(draw_list.context, program, pieces(draw_list, projection, large, size))
    return sent


def _draw_coarse(
    programs: Programs,
    origin_ws: np.ndarray,
    projection: ShadowProjection,
    planes: np.ndarray,
    defines: dict[str, int],
    rows: np.ndarray | None,
    culling: Culling | None,
    coarse: CoarseCasters,
    chosen: ChosenLevels,
) -> int:
    """Draw coarser casters; the map's ids name triangles of the originals."""
    pair = [programs.get("shadow.vert", "shadow.frag", INSTANCED=flag, COARSE=1, **defines) for flag in (0, 1)]
    for program in pair:
        set_uniforms(program, **relative_to(origin_ws, projection.clip_from_world))
    coarse.bind()
    return coarse.draw_list.draw(*pair, planes, attributes=False, rows=coarse.casting(chosen, rows), culling=culling)


def plan_block(plan: ShadowPlan | None) -> bytes:
    """The uniform block `ShadowPlan` of common_plan.glsl (std140), for places relative to the plan's origin."""
    block = np.zeros((MAX_MAPS, _FLOATS_PER_MAP), np.float32)
    for row, projection in zip(block, plan.projections if plan else (), strict=False):
        matrix = projection.clip_from_world @ translation(plan.origin_ws)
        planes = np.zeros((4, 4))
        planes[: len(projection.region_planes_ws)] = projection.region_planes_ws @ translation(plan.origin_ws)
        row[0:16] = matrix.T.ravel()
        row[16:32] = np.linalg.inv(matrix).T.ravel()
        row[32:36] = projection.near, projection.far, len(projection.region_planes_ws), float(projection.is_empty)
        row[36:52] = planes.ravel()
        row[52:56] = log_warp_vector(projection)
        row[56:58] = _linear_t(matrix)
        row[58:60] = log_bend_vector(projection)
    return block.tobytes()


def _linear_t(matrix: np.ndarray) -> np.ndarray:
    """(x, y) with clip t = x·w + y: along a log map's axis the projective t is x + y / w."""
    w, t = matrix[3], matrix[1]
    direction = w[:3] @ w[:3]
    slope = (t[:3] @ w[:3]) / direction if direction > 0.0 else 0.0
    return np.array([slope, t[3] - slope * w[3]])
