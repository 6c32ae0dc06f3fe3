"""Panes: casters that let light through, as layers of depth and tint in front of each shadow map. Worker thread only.

A receiver's light is the product of the tints of the panes above its plane, whatever their order (`shaders/common_panes.glsl`); whether
anything whole stands before it the shadow maps say, which panes are not in.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Hashable
from contextlib import ExitStack
from functools import partial

import moderngl
import numpy as np

from ...maths.shadow.projection import ShadowPlan
from ..geometry.draw_list import DrawList
from ..gl.allocation import freed_with
from ..gl.depth_buffer import DepthBuffer
from ..gl.gl_raw import GL_DEPTH_CLAMP, finish, id_array, raw_gl
from ..gl.machine import check_panes
from ..gl.programs import SAMPLER_UNITS, Programs
from .shadow import draw_one

MOST_SIDE = 2048
"""Texels per side at most: a pane's shadow is soft by one of them."""
MOST_PANES = 16
"""Layers that are told apart; what lies behind so many lets all light through."""
EMPTY, BEFORE_ALL = 2.0, -3e38  # NDC depths: behind any far plane; before whatever there is
CLEAR = 0x3FFFFFFF  # the tint that lets all through
_COLOR, _TEXTURE_2D_ARRAY = 0x1800, 0x8C1A


class PaneMaps:
    """An array of `layers` RG32UI images (bits of the NDC depth, tint) for each of `maps` shadow maps, layer by layer; two images of the
    layers in the making. `holds` says what was drawn last, by whoever can say."""

    def __init__(self, context: moderngl.Context, side: int, maps: int, layers: int) -> None:
        check_panes(side, maps, layers)
        self.side, self.maps, self.layers = side, maps, layers
        self._raw, self._unit = raw_gl(context), context.default_texture_unit
        self.holds: Hashable = None
        with ExitStack() as made:
            self.array = freed_with(made, id_array(context, side, maps * layers, 2))
            self.scratch = [freed_with(made, _scratch(context, side)) for _ in range(2)]
            self.depth = freed_with(made, DepthBuffer(context, (side, side)))
            self.targets = [freed_with(made, self.depth.framebuffer([image])) for image in self.scratch]
            self._made = made.pop_all()

    def clear(self, which: int, depth: float) -> None:
        """Bind one of the two images in the making, all of it at that NDC depth and clear."""
        target = self.targets[which]
        target.clear(depth=1.0)
        target.use()
        bits = int(np.float32(depth).view(np.uint32)), CLEAR, 0, 0
        self._raw.ClearBufferuiv(_COLOR, 0, (ctypes.c_uint * 4)(*bits))

    def copy(self, which: int, image: int) -> None:
        """Put what is in the making, and bound, into its place."""
        self.array.use(self._unit)
        self._raw.CopyTexSubImage3D(_TEXTURE_2D_ARRAY, 0, 0, 0, image, 0, 0, self.side, self.side)

    def uniforms(self) -> dict[str, int]:
        """How the array is laid out."""
        return {"u_pane_layers": self.layers, "u_pane_stride": self.maps}

    def release(self) -> None:
        """Free the images."""
        self._made.close()


def _scratch(context: moderngl.Context, side: int) -> moderngl.Texture:
    image = context.texture((side, side), 2, dtype="u4")
    image.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return image


def draw_panes(
    context: moderngl.Context, programs: Programs, panes: PaneMaps, draw_list: DrawList, plan: ShadowPlan, rows: np.ndarray
) -> int:
    """Draw the instance rows of the mask `rows` (I,) into every map; returns how many layers the deepest has: at most one more than there
    is room for, which says that some are missing."""
    deepest = 0
    context.enable_only(moderngl.DEPTH_TEST)
    context.enable_direct(GL_DEPTH_CLAMP)
    for index, projection in enumerate(plan.projections):
        draw = partial(draw_one, programs, draw_list, plan.origin_ws, projection, panes.side, {"IDS": 3, "ID_PER_MATERIAL": 0}, rows)
        deepest = max(deepest, _peel(context, panes, index, draw_list, None if projection.is_empty else draw))
    context.disable_direct(GL_DEPTH_CLAMP)
    return deepest


def _peel(context: moderngl.Context, panes: PaneMaps, index: int, draw_list: DrawList, draw: Callable[[], int] | None) -> int:
    """Fill the images of map `index`, as far as there is something; returns its layers, one more than there is room for at most."""
    panes.clear(1, BEFORE_ALL)
    draw_list.looks().use(SAMPLER_UNITS["u_looks"])
    for k in range(panes.layers + 1):
        panes.clear(k % 2, EMPTY)
        panes.scratch[(k + 1) % 2].use(SAMPLER_UNITS["u_peeled"])
        query = context.query(samples=True)
        with query:
            if draw is not None:
                draw()
        if k < panes.layers:
            panes.copy(k % 2, k * panes.maps + index)
        finish(context)
        if not query.samples:
            return k
    return panes.layers + 1
