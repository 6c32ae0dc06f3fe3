"""What can be seen through, layer by layer from the nearest (depth peeling, Everitt 2001): a G-buffer for each. Worker thread only.

Layers are told apart by depth alone: of two see-through surfaces at the very same depth one is drawn.
"""

from __future__ import annotations

from collections.abc import Callable

import moderngl
import numpy as np

from ...maths.view import Camera
from ..geometry.draw_list import DrawList
from ..gl.gl_raw import finish
from ..gl.programs import SAMPLER_UNITS, Programs
from .gbuffer import GBuffer, eye_of
from .surface import SurfaceShader, draw_surfaces

MOST_LAYERS = 12
"""Surfaces behind one another that are told apart; what lies behind so many is left out."""


def peeled(
    context: moderngl.Context,
    programs: Programs,
    whole: GBuffer,
    target_of: Callable[[int], GBuffer],
    draw_list: DrawList,
    camera: Camera,
    rows: np.ndarray,
) -> list[GBuffer]:
    """The layers of the instance rows of the mask `rows` (I,) that lie before what `whole` holds, the nearest first; as many as there are,
    at most `MOST_LAYERS`. `target_of` gives the G-buffer of a layer by its number."""
    eye = eye_of(draw_list, camera)
    layers: list[GBuffer] = []
    while len(layers) < MOST_LAYERS:
        layer = target_of(len(layers))
        layer.clear(eye.depth)
        shader = SurfaceShader("gbuffer.frag", {"PEEL": 1}, {"u_is_first": int(not layers)})
        whole.view_depth.use(SAMPLER_UNITS["u_view_depth"])
        (layers[-1] if layers else whole).view_depth.use(SAMPLER_UNITS["u_peeled_depth"])
        query = context.query(samples=True)
        with query:
            draw_surfaces(context, programs, draw_list, eye, shader, layer.size, rows)
        finish(context)
        if not query.samples:
            break
        layers.append(layer)
    return layers
