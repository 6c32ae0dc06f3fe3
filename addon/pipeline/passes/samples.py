"""The camera's samples of a pixel: where they lie, which pictures draw them, and their mean. Worker thread only.

The samples of a regular grid are the pixel centres of one picture of so many times the side: one G-buffer and one shading draw them all.
Any other pattern takes a picture a sample.
"""

from __future__ import annotations

from dataclasses import replace

import moderngl
import numpy as np

from ...maths.view import Camera
from ..gl.gl_raw import draw_triangles
from ..gl.programs import SAMPLER_UNITS, Programs, set_uniforms
from .shade import ShadeTarget

BYTES_A_SAMPLE = 36  # of G-buffer and picture


def regular_grid(samples: int) -> np.ndarray:
    """(samples, 2) offsets from the pixel's centre, in pixels: the centres of a square grid of cells, row by row."""
    side = round(samples**0.5)
    steps = (np.arange(side) + 0.5) / side - 0.5
    return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)


def grid_side(offsets: np.ndarray) -> int | None:
    """n where `offsets` (n², 2) are those of `regular_grid`, in any order; None for another pattern."""
    side = round(len(offsets) ** 0.5)
    if side * side != len(offsets):
        return None
    order = np.lexsort(offsets.T)
    return side if np.allclose(offsets[order], regular_grid(side * side), atol=1e-9) else None


def pictures(camera: Camera, size: tuple[int, int], offsets: np.ndarray, longest: int, most_bytes: int) -> list[tuple[Camera, int]]:
    """Cameras and the side n of the picture each draws, n·`size` pixels, whose pixels are together the samples at `offsets`.

    A side is at most `longest` pixels and a picture at most `most_bytes`, unless it is of `size` itself.
    """
    whole = grid_side(offsets) or 1
    bounds = longest // max(size), (most_bytes / (BYTES_A_SAMPLE * size[0] * size[1])) ** 0.5
    side = max(n for n in range(1, whole + 1) if whole % n == 0 and (n == 1 or n <= min(bounds)))
    if side > 1:
        offsets = regular_grid((whole // side) ** 2) / side
    return [(moved(camera, size, offset), side) for offset in offsets]


def moved(camera: Camera, size: tuple[int, int], offset: np.ndarray) -> Camera:
    """The camera that sees at the pixels' centres what `camera` sees `offset` pixels from them (in clip space: perspective, shift keep)."""
    if not offset.any():
        return camera
    shift = np.eye(4)
    shift[:2, 3] = -2.0 * offset / size
    return replace(camera, clip_from_view=shift @ camera.clip_from_view)


class Mean:
    """The mean of pictures of samples, added up in a target of the picture's own size."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self._context = context
        self.target = ShadeTarget(context, size, False)
        self._arrays: dict[int, moderngl.VertexArray] = {}

    def clear(self) -> None:
        """Begin anew."""
        self.target.holds = None
        self.target.framebuffer.clear()

    def add(self, programs: Programs, picture: moderngl.Texture, side: int, samples: int) -> None:
        """Add `picture` of side² of the `samples` of every pixel."""
        program = programs.get("fullscreen.vert", "mean.frag", SIDE=side)
        if program.glo not in self._arrays:
            self._arrays[program.glo] = self._context.vertex_array(program, [])
        set_uniforms(program, u_share=1.0 / samples)
        picture.use(SAMPLER_UNITS["u_sampled"])
        self.target.framebuffer.use()
        self._context.enable_only(moderngl.BLEND)
        self._context.blend_func = moderngl.ONE, moderngl.ONE
        draw_triangles(self._context, self._arrays[program.glo], 3)
        self._context.enable_only(moderngl.NOTHING)

    def release(self) -> None:
        """Free the target."""
        for array in self._arrays.values():
            array.release()
        self._arrays.clear()
        self.target.release()
