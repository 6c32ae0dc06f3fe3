"""A picture as the sum of many: each lit by one hard light with shadow maps of its own, added up in linear floats. Worker thread only.

How to use it: `clear`; for every hard light draw its maps and have `ShadePass.draw(sums, …, part=p)` add the picture it lights, its colour
multiplied by the number of lights (the ambient light is in every picture, and so in the mean once); `added(p)`; at any time `resolve` makes
the mean so far a picture, and `shares` tells what arrived. Nothing has to be cleared to go on adding.
"""

from __future__ import annotations

from collections.abc import Hashable

import moderngl
import numpy as np

from ..gl.gl_raw import draw_triangles
from ..gl.programs import SAMPLER_UNITS, Programs, set_uniforms
from ..gl.readback import read_texture

BYTES_A_PIXEL = 32


class LightSums:
    """RGBA32F sums of one size: the colour, and shares of the light (`shaders/common_sums.glsl`). `total` of the parts added.

    `holds` says what is added up, and `rounds` how many samples of each light, by whoever can say.
    """

    data = False

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size, self._context = size, context
        self.total = 0.0
        self.holds: Hashable = None
        self.rounds = 0
        self.textures = [context.texture(size, 4, dtype="f4") for _ in range(2)]
        for texture in self.textures:
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.framebuffer = context.framebuffer(self.textures)
        self._arrays: dict[int, moderngl.VertexArray] = {}

    def clear(self) -> None:
        """Begin anew."""
        self.holds, self.total, self.rounds = None, 0.0, 0
        self.framebuffer.clear()

    def added(self, part: float) -> None:
        """Note that a picture with this part was added."""
        self.total += part

    def resolve(
        self, programs: Programs, target: moderngl.Framebuffer, background: tuple[float, float, float, float], display: int
    ) -> None:
        """Draw the mean of what was added into `target`; `display` 0 the light, 1 the share of it that shadows let through."""
        program = programs.get("fullscreen.vert", "resolve.frag", DISPLAY=display)
        if program.glo not in self._arrays:
            self._arrays[program.glo] = self._context.vertex_array(program, [])
        set_uniforms(program, u_share=1.0 / self.total, u_background=background)
        for name, texture in zip(("u_sampled", "u_shares"), self.textures, strict=True):
            texture.use(SAMPLER_UNITS[name])
        target.use()
        self._context.enable_only(moderngl.NOTHING)
        draw_triangles(self._context, self._arrays[program.glo], 3)

    def shares(self) -> np.ndarray:
        """(h, w) of the light that would arrive without shadows, the share that does: NaN where none would."""
        arriving, everything = np.moveaxis(read_texture(self.textures[1])[..., :2], -1, 0)
        lit = everything > 0.0
        return np.where(lit, arriving / np.where(lit, everything, 1.0), np.nan).astype(np.float32)

    def release(self) -> None:
        """Free the sums."""
        for array in self._arrays.values():
            array.release()
        self._arrays.clear()
        self.framebuffer.release()
        for texture in self.textures:
            texture.release()
