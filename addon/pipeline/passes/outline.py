"""Beside the map of the triangle test: which triangle's edge crosses each texel, the nearest to the light. Worker thread only.

The map knows what covers its texels' centres. A wire thinner than a texel covers few, but its edges cross every texel that it passes:
drawn as lines, they leave their ids there, for the exact test to start from. Only ids are kept; the depth is for choosing the nearest.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import moderngl

from ...maths.shadow.projection import ShadowPlan, ShadowProjection
from ..gl.allocation import freed_with
from ..gl.gl_raw import DepthArray, LayerFramebuffer, id_array


class OutlineIds:
    """An RG32UI array (slot + 1, triangle), a layer per shadow projection."""

    def __init__(self, context: moderngl.Context, size: int, layers: int) -> None:
        self._context = context
        with ExitStack() as made:
            self._depth = freed_with(made, DepthArray(context, size, layers))
            self.ids = freed_with(made, id_array(context, size, layers, 2))
            self._framebuffers = [freed_with(made, LayerFramebuffer(context, self._depth, layer, [self.ids])) for layer in range(layers)]
            self._made = made.pop_all()

    def draw(self, plan: ShadowPlan, draw_one: Callable[[ShadowProjection], int]) -> int:
        """Fill every layer by `draw_one`, which draws the casters as into the map itself; returns the triangles sent."""
        self._context.wireframe = True
        sent = 0
        for projection, framebuffer in zip(plan.projections, self._framebuffers, strict=False):
            framebuffer.use()
            framebuffer.framebuffer.clear(depth=1.0)
            framebuffer.clear_ids()
            sent += 0 if projection.is_empty else draw_one(projection)
        self._context.wireframe = False
        return sent

    def release(self) -> None:
        """Free the arrays and their framebuffers."""
        self._made.close()
