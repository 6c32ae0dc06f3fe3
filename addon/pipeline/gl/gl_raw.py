"""The few OpenGL 3.3 calls that moderngl does not offer, loaded through the context's own loader. Worker thread only.

Depth texture *arrays* with one framebuffer per layer (one shadow map per partition), and buffer textures (triangles read by the shader
from the buffers they are drawn from, without a copy). And the calls that may wait for the GPU (or, with a software driver, are its work):
through ctypes they give Python's lock free meanwhile, through moderngl they keep it and Blender's window stands still.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import moderngl
import numpy as np

from ...errors import DriverError, GpuError
from .allocation import check_buffer_texture, check_memory

GL_DEPTH_CLAMP = 0x864F
_TRIANGLES, _UNSIGNED_INT = 0x0004, 0x1405
_TEXTURE_2D = 0x0DE1
_PACK_ALIGNMENT = 0x0D05
_UNIFORM_BUFFER = 0x8A11
_TEXTURE_2D_ARRAY = 0x8C1A
_TEXTURE_BUFFER = 0x8C2A
_FRAMEBUFFER = 0x8D40
_DEPTH_ATTACHMENT = 0x8D00
_COLOR = 0x1800
_COLOR_ATTACHMENT0 = 0x8CE0
_COMPLETE = 0x8CD5
_DEPTH_COMPONENT, _DEPTH_COMPONENT32F, _FLOAT = 0x1902, 0x8CAC, 0x1406
_NEAREST, _CLAMP_TO_EDGE = 0x2600, 0x812F
_FILTERS_AND_WRAPS = ((0x2801, _NEAREST), (0x2800, _NEAREST), (0x2802, _CLAMP_TO_EDGE), (0x2803, _CLAMP_TO_EDGE))
BUFFER_FORMATS = {
    "r32f": 0x822E,
    "rgb32f": 0x8815,
    "rgba32f": 0x8814,
    "r32ui": 0x8236,
    "rg32ui": 0x823C,
    "rgb32ui": 0x8D71,
    "rgba32ui": 0x8D70,
}
_CHANNELS = {"r": 1, "rg": 2, "rgb": 3, "rgba": 4}

_uint, _int, _void = ctypes.c_uint, ctypes.c_int, ctypes.c_void_p
_names = ctypes.POINTER(_uint)
_SIGNATURES = {
    "glGenTextures": (_int, _names),
    "glDeleteTextures": (_int, _names),
    "glBindTexture": (_uint, _uint),
    "glActiveTexture": (_uint,),
    "glTexImage3D": (_uint, _int, _int, _int, _int, _int, _int, _uint, _uint, _void),
    "glCopyTexSubImage3D": (_uint, _int, _int, _int, _int, _int, _int, _int, _int),
    "glTexParameteri": (_uint, _uint, _int),
    "glTexBuffer": (_uint, _uint, _uint),
    "glGenRenderbuffers": (_int, _names),
    "glDeleteRenderbuffers": (_int, _names),
    "glBindRenderbuffer": (_uint, _uint),
    "glRenderbufferStorage": (_uint, _uint, _int, _int),
    "glFramebufferRenderbuffer": (_uint, _uint, _uint, _uint),
    "glGenFramebuffers": (_int, _names),
    "glDeleteFramebuffers": (_int, _names),
    "glBindFramebuffer": (_uint, _uint),
    "glFramebufferTextureLayer": (_uint, _uint, _uint, _int, _int),
    "glFramebufferTexture2D": (_uint, _uint, _uint, _uint, _int),
    "glDrawBuffers": (_int, _names),
    "glReadBuffer": (_uint,),
    "glGetTexImage": (_uint, _int, _uint, _uint, _void),
    "glClear": (_uint,),
    "glUseProgram": (_uint,),
    "glUniform1i": (_int, _int),
    "glClearBufferuiv": (_uint, _int, _names),
    "glFinish": (),
    "glPixelStorei": (_uint, _int),
    "glBindVertexArray": (_uint,),
    "glDrawElementsInstanced": (_uint, _int, _uint, _void, _int),
    "glDrawArrays": (_uint, _int, _int),
    "glBindBuffer": (_uint, _uint),
    "glBufferSubData": (_uint, ctypes.c_ssize_t, ctypes.c_ssize_t, _void),
}


class RawGL:
    """The functions of `_SIGNATURES`, callable by name without the `gl` prefix: `raw.BindTexture(target, name)`.

    `ClipControl` is None where the driver has none (before OpenGL 4.5, macOS).
    """

    def __init__(self, context: moderngl.Context) -> None:
        load = context.mglo._context.load_opengl_function
        for name, arguments in _SIGNATURES.items():
            address = load(name)
            if not address:
                raise GpuError(f"The OpenGL driver lacks {name}: update the graphics driver (OpenGL 3.3 is needed).")
            setattr(self, name[2:], ctypes.CFUNCTYPE(None, *arguments)(address))
        has_clip_control = context.version_code >= 450 or "GL_ARB_clip_control" in context.extensions
        address = load("glClipControl") if has_clip_control else None
        self.ClipControl = ctypes.CFUNCTYPE(None, _uint, _uint)(address) if address else None
        self.CheckFramebufferStatus = ctypes.CFUNCTYPE(_uint, _uint)(load("glCheckFramebufferStatus"))

    def new_name(self, kind: str) -> int:
        """A fresh GL name of 'Textures', 'Renderbuffers' or 'Framebuffers'."""
        name = _uint()
        getattr(self, f"Gen{kind}")(1, ctypes.byref(name))
        return name.value

    def delete_name(self, kind: str, name: int) -> None:
        """Free a GL name of that kind."""
        getattr(self, f"Delete{kind}")(1, ctypes.byref(_uint(name)))


def raw_gl(context: moderngl.Context) -> RawGL:
    """The raw functions of that context, loaded once."""
    if not isinstance(context.extra, dict):
        context.extra = {}
    if "raw" not in context.extra:
        context.extra["raw"] = RawGL(context)
        context.extra["live"] = 0
    return context.extra["raw"]


def live_objects(context: moderngl.Context) -> int:
    """How many raw GL objects (textures, renderbuffers and framebuffers of `Owned`) are alive; for the leak test."""
    raw_gl(context)
    return context.extra["live"]


def finish(context: moderngl.Context) -> None:
    """Wait for the GPU; other Python threads run meanwhile."""
    raw_gl(context).Finish()


def draw_triangles(
    context: moderngl.Context, array: moderngl.VertexArray, count: int, first: int | None = None, instances: int = 1
) -> None:
    """`array.render(TRIANGLES, …)` with Python's lock free: `count` indices (32-bit) from `first`; without `first`, `count` vertices."""
    raw = raw_gl(context)
    raw.UseProgram(array.program.glo)
    raw.BindVertexArray(array.glo)
    if first is None:
        raw.DrawArrays(_TRIANGLES, 0, count)
    else:
        raw.DrawElementsInstanced(_TRIANGLES, count, _UNSIGNED_INT, 4 * first, instances)


def draw_vertices(context: moderngl.Context, program: moderngl.Program, vertices: np.ndarray) -> int:
    """Draw triangles that are needed once, three vertices each; returns their number.

    `vertices` (3·F,) is a packed structured array of float32 and uint32 fields named as the program's attributes; what the program does
    not use is passed over.
    """
    if not len(vertices):
        return 0
    fields = {name: vertices.dtype[name] for name in vertices.dtype.names}
    used = [name for name in fields if name in program]
    layout = " ".join(f"{kind.itemsize // 4}{kind.base.kind}4" if name in program else f"{kind.itemsize}x" for name, kind in fields.items())
    buffer = context.buffer(vertices.tobytes())
    array = context.vertex_array(program, [(buffer, layout, *used)])
    draw_triangles(context, array, len(vertices))
    array.release()
    buffer.release()
    return len(vertices) // 3


def write_buffer(context: moderngl.Context, buffer: moderngl.Buffer, data: bytes) -> None:
    """`buffer.write(data)` with Python's lock free: a driver may wait here until the GPU has done with the old content."""
    raw = raw_gl(context)
    raw.BindBuffer(_UNIFORM_BUFFER, buffer.glo)
    raw.BufferSubData(_UNIFORM_BUFFER, 0, len(data), data)


def read_into(context: moderngl.Context, texture: moderngl.Texture, form: int, kind: int, out: np.ndarray) -> None:
    """`texture.read_into(out)` with Python's lock free; `form` and `kind` are GL's names of the pixels' format and type."""
    raw = raw_gl(context)
    texture.use(context.default_texture_unit)
    raw.PixelStorei(_PACK_ALIGNMENT, 1)
    raw.GetTexImage(_TEXTURE_2D, 0, form, kind, out.ctypes.data)


class Owned:
    """A GL name with its count in `live_objects`."""

    def __init__(self, context: moderngl.Context, kind: str) -> None:
        self.context, self.raw, self.kind = context, raw_gl(context), kind
        self.glo = self.raw.new_name(kind)
        context.extra["live"] += 1

    def release(self) -> None:
        """Free the GL object; idempotent."""
        if self.glo:
            self.raw.delete_name(self.kind, self.glo)
            self.context.extra["live"] -= 1
            self.glo = 0


class DepthArray(Owned):
    """A DEPTH_COMPONENT32F texture array (size, size, layers), sampled with NEAREST through `sampler2DArray`."""

    def __init__(self, context: moderngl.Context, size: int, layers: int) -> None:
        super().__init__(context, "Textures")
        self.size, self.layers = size, layers
        self.raw.BindTexture(_TEXTURE_2D_ARRAY, self.glo)
        self.raw.TexImage3D(_TEXTURE_2D_ARRAY, 0, _DEPTH_COMPONENT32F, size, size, layers, 0, _DEPTH_COMPONENT, _FLOAT, None)
        for name, value in _FILTERS_AND_WRAPS:
            self.raw.TexParameteri(_TEXTURE_2D_ARRAY, name, value)

    def use(self, unit: int) -> None:
        """Bind to a texture unit."""
        self.raw.ActiveTexture(0x84C0 + unit)
        self.raw.BindTexture(_TEXTURE_2D_ARRAY, self.glo)

    def read(self) -> bytes:
        """All layers, float32, row 0 at the bottom."""
        out = ctypes.create_string_buffer(self.size * self.size * self.layers * 4)
        self.raw.BindTexture(_TEXTURE_2D_ARRAY, self.glo)
        self.raw.GetTexImage(_TEXTURE_2D_ARRAY, 0, _DEPTH_COMPONENT, _FLOAT, out)
        return out.raw


class LayerFramebuffer(Owned):
    """A framebuffer on one layer of a depth array (or none), with colour layers of moderngl texture arrays beside it."""

    def __init__(
        self, context: moderngl.Context, depth: DepthArray | None, layer: int, colors: Sequence[moderngl.TextureArray] = ()
    ) -> None:
        super().__init__(context, "Framebuffers")
        raw = self.raw
        raw.BindFramebuffer(_FRAMEBUFFER, self.glo)
        if depth is not None:
            raw.FramebufferTextureLayer(_FRAMEBUFFER, _DEPTH_ATTACHMENT, depth.glo, 0, layer)
        for i, texture in enumerate(colors):
            raw.FramebufferTextureLayer(_FRAMEBUFFER, _COLOR_ATTACHMENT0 + i, texture.glo, 0, layer)
        targets = [_COLOR_ATTACHMENT0 + i for i in range(len(colors))] or [0]
        raw.DrawBuffers(len(targets), (_uint * len(targets))(*targets))
        raw.ReadBuffer(targets[0])
        if raw.CheckFramebufferStatus(_FRAMEBUFFER) != _COMPLETE:
            self.release()
            raise DriverError("The driver refused a 32-bit float depth layer as a shadow map: update the graphics driver.")
        try:
            check_memory(context)
            self.framebuffer = context.detect_framebuffer(self.glo)
        except (moderngl.Error, GpuError):
            self.release()
            raise
        _ = context.error  # moderngl asks a layer for its size as if it were a plain texture, which GL refuses, harmlessly
        self.size = depth.size if depth is not None else colors[0].size[0]

    def use(self) -> None:
        """Bind, with the viewport on the whole layer."""
        self.framebuffer.use()
        self.context.viewport = (0, 0, self.size, self.size)

    def clear_ids(self, target: int = 0) -> None:
        """Set an unsigned integer colour target to 0 (glClear is not defined for integers). Bound framebuffers only."""
        self.raw.ClearBufferuiv(_COLOR, target, (_uint * 4)(0, 0, 0, 0))


def id_array(context: moderngl.Context, size: int, layers: int, components: int) -> moderngl.TextureArray:
    """An R32UI (object ids) or RG32UI (slot + 1, triangle) array for the layers of shadow maps."""
    array = context.texture_array((size, size, layers), components, dtype="u4")
    array.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return array


class BufferTexture(Owned):
    """A buffer seen as a one-dimensional texture (`samplerBuffer`, `usamplerBuffer`); formats in `BUFFER_FORMATS`."""

    def __init__(self, context: moderngl.Context, buffer: moderngl.Buffer, texel_format: str) -> None:
        check_buffer_texture(context, buffer.size // (4 * _CHANNELS[texel_format.partition("32")[0]]))
        super().__init__(context, "Textures")
        self.raw.BindTexture(_TEXTURE_BUFFER, self.glo)
        self.raw.TexBuffer(_TEXTURE_BUFFER, BUFFER_FORMATS[texel_format], buffer.glo)

    def use(self, unit: int) -> None:
        """Bind to a texture unit."""
        self.raw.ActiveTexture(0x84C0 + unit)
        self.raw.BindTexture(_TEXTURE_BUFFER, self.glo)
