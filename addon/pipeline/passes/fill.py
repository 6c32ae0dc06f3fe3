"""Passes that draw every pixel of a target once. Worker thread only."""

from __future__ import annotations

import moderngl

from ..gl.gl_raw import draw_triangles
from ..gl.programs import SAMPLER_UNITS


def bind(textures: dict[str, object]) -> None:
    """Bind textures to the units of their samplers, by name."""
    for name, texture in textures.items():
        texture.use(SAMPLER_UNITS[name])


def fill(context: moderngl.Context, target: moderngl.Framebuffer, program: moderngl.Program, blends: bool = False) -> None:
    """Run `program` once for every pixel of `target`; `blends` lays its premultiplied colour over what is there."""
    target.use()
    context.enable_only(moderngl.BLEND if blends else moderngl.NOTHING)
    if blends:
        context.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
    array = context.vertex_array(program, [])
    draw_triangles(context, array, 3)
    array.release()
    context.enable_only(moderngl.NOTHING)


def fill_over(context: moderngl.Context, picture: moderngl.Texture, program: moderngl.Program) -> None:
    """Lay the premultiplied colour that `program` gives every pixel over `picture`.

    What was bound before is bound again: moderngl binds the last framebuffer when it makes another, and this one is gone by then.
    """
    before = context.fbo
    framebuffer = context.framebuffer([picture])
    fill(context, framebuffer, program, blends=True)
    before.use()
    framebuffer.release()
