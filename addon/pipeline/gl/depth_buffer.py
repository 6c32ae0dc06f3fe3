"""Depth buffers of 32-bit floats, and the OpenGL state in which a `DepthProjection` is drawn into them. Worker thread only.

OpenGL's own clip depth, −w…w, reaches the buffer as 0.5 + 0.5·z/w: the digits that a float has near 0 are gone. With clip control
(OpenGL 4.5, or the extension) it reaches it as z/w. Without (macOS) the fragments write their depth themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import moderngl

from ...errors import DriverError
from ...maths.depth_projection import DepthProjection
from .gl_raw import Owned, raw_gl

_FRAMEBUFFER, _DEPTH_ATTACHMENT, _RENDERBUFFER, _DEPTH_COMPONENT32F = 0x8D40, 0x8D00, 0x8D41, 0x8CAC
_COMPLETE = 0x8CD5
_LOWER_LEFT, _NEGATIVE_ONE_TO_ONE, _ZERO_TO_ONE = 0x8CA1, 0x935E, 0x935F


class DepthBuffer(Owned):
    """DEPTH_COMPONENT32F of one size."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        super().__init__(context, "Renderbuffers")
        self.size = size
        self.raw.BindRenderbuffer(_RENDERBUFFER, self.glo)
        self.raw.RenderbufferStorage(_RENDERBUFFER, _DEPTH_COMPONENT32F, *size)

    def framebuffer(self, colors: list[moderngl.Texture]) -> moderngl.Framebuffer:
        """A framebuffer of these colour targets with this depth, bound."""
        framebuffer = self.context.framebuffer(colors)
        framebuffer.use()
        self.raw.FramebufferRenderbuffer(_FRAMEBUFFER, _DEPTH_ATTACHMENT, _RENDERBUFFER, self.glo)
        framebuffer.depth_mask = True
        if self.raw.CheckFramebufferStatus(_FRAMEBUFFER) != _COMPLETE:
            raise DriverError("The driver refused a 32-bit float depth buffer: update the graphics driver.")
        return framebuffer

    @contextmanager
    def attached(self, framebuffer: moderngl.Framebuffer) -> Iterator[None]:
        """`framebuffer`, bound, tests against this depth while this lasts, and does not write it."""
        framebuffer.depth_mask = False
        framebuffer.use()
        self.raw.FramebufferRenderbuffer(_FRAMEBUFFER, _DEPTH_ATTACHMENT, _RENDERBUFFER, self.glo)
        try:
            yield
        finally:
            framebuffer.use()
            self.raw.FramebufferRenderbuffer(_FRAMEBUFFER, _DEPTH_ATTACHMENT, _RENDERBUFFER, 0)


def has_clip_control(context: moderngl.Context) -> bool:
    """Whether the rasteriser can write all digits of a float depth."""
    return raw_gl(context).ClipControl is not None


@contextmanager
def nearest_wins(context: moderngl.Context, projection: DepthProjection, *, farthest: bool = False) -> Iterator[None]:
    """Depth test and clip control for drawing by `projection` while this lasts; `farthest`: the farthest place wins."""
    raw = raw_gl(context)
    context.enable_only(moderngl.DEPTH_TEST)
    context.depth_func = {"<": ">", ">": "<"}[projection.nearer] if farthest else projection.nearer
    if has_clip_control(context):
        raw.ClipControl(_LOWER_LEFT, _ZERO_TO_ONE)
    try:
        yield
    finally:
        if has_clip_control(context):
            raw.ClipControl(_LOWER_LEFT, _NEGATIVE_ONE_TO_ONE)
        context.depth_func = "<"
