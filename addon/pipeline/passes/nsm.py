"""The n-SM (SMMVP §4.5): one pass over each layer of a shadow map gathers the n depths of every cell. Worker thread only."""

from __future__ import annotations

from contextlib import ExitStack

import moderngl

from ...maths.shadow.projection import ShadowPlan
from ..gl.allocation import freed_with
from ..gl.gl_raw import DepthArray, LayerFramebuffer
from ..gl.programs import SAMPLER_UNITS, Programs, set_uniforms
from .shadow_defines import neighbour_define

PER_TARGET = 4


class NsmCells:
    """RGBA32F arrays that hold four depths of a cell each (one fetch up to n = 4), and their ids where the map has ids."""

    def __init__(self, context: moderngl.Context, size: int, layers: int, depths: int, ids: moderngl.TextureArray | None) -> None:
        targets = -(-depths // PER_TARGET)
        self._context, self._depths, self._map_ids = context, depths, ids
        with ExitStack() as made:
            self.depths = [freed_with(made, _cells(context, size, layers, "f4")) for _ in range(targets)]
            self.ids = [freed_with(made, _cells(context, size, layers, "u4")) for _ in range(targets)] if ids is not None else []
            arrays = (*self.depths, *self.ids)
            self._framebuffers = [freed_with(made, LayerFramebuffer(context, None, layer, arrays)) for layer in range(layers)]
            self._made = made.pop_all()
        self._array: moderngl.VertexArray | None = None

    def inputs(self) -> dict[str, moderngl.TextureArray]:
        """The arrays by sampler name."""
        return {f"u_cells_{i}": texture for i, texture in enumerate(self.depths)} | {
            f"u_cell_ids_{i}": texture for i, texture in enumerate(self.ids)
        }

    def select(self, programs: Programs, depth: DepthArray, plan: ShadowPlan) -> None:
        """Fill the cells from the map's depths (and ids)."""
        program = programs.get(
            "fullscreen.vert", "nsm.frag", DEPTHS=self._depths, WITH_IDS=int(bool(self.ids)), **neighbour_define(self._depths)
        )
        if self._array is None:
            self._array = self._context.vertex_array(program, [])
        self._context.enable_only(moderngl.NOTHING)
        depth.use(SAMPLER_UNITS["u_shadow_depth"])
        if self._map_ids is not None:
            self._map_ids.use(SAMPLER_UNITS["u_shadow_ids"])
        for layer, (framebuffer, projection) in enumerate(zip(self._framebuffers, plan.projections, strict=False)):
            if projection.is_empty:
                continue
            framebuffer.use()
            set_uniforms(program, u_layer=layer)
            self._array.render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free the arrays and their framebuffers."""
        if self._array is not None:
            self._array.release()
        self._made.close()


def _cells(context: moderngl.Context, size: int, layers: int, dtype: str) -> moderngl.TextureArray:
    array = context.texture_array((size, size, layers), 4, dtype=dtype)
    array.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return array
