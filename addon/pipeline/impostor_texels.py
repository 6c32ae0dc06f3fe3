"""The texels of a relief impostor: drawn sample by sample, four samples a texel, then gathered. Worker thread only.

A texel is one surface: the nearest that its samples show, as a plane. Where not all samples lie on it, the texel is an edge, and four bits
a sample say whether a neighbour's surface shows there, or nothing: outlines and creases keep twice the resolution of the surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from ..maths.relief import CaptureFrame, shift_unit
from ..maths.relief_outline import STEEPEST
from .clusters import frustum_planes
from .device import Device
from .draw_list import DrawList
from .gbuffer_pass import pixel_rays
from .programs import SAMPLER_UNITS, matrix_bytes, set_uniforms
from .readback import read_texture

EMPTY = np.float32(1e9)
SAMPLES = 2
"""Samples per texel and side."""
BYTES_PER_TEXEL = 40
APART_TEXELS = 0.25
"""Surfaces nearer to each other than this are one when the back layer is peeled."""
DEFINES = {"EMPTY": f"{EMPTY:.1f}", "STEEPEST": f"{STEEPEST:.1f}"}


@dataclass(eq=False)
class ImpostorTexels:
    """What the drawing shaders read: `layers` RGBA32F (±|relief|, its gradient per texel in u and v, |relief| of the back), `normal`, `ids`
    as in the G-buffer, and the same of the back layer. `common_impostor.glsl` says how edges are kept in the gradients."""

    layers: moderngl.Texture
    normal: moderngl.Texture
    ids: moderngl.Texture
    back_normal: moderngl.Texture
    back_ids: moderngl.Texture

    @classmethod
    def of_size(cls, context: moderngl.Context, size: tuple[int, int]) -> ImpostorTexels:
        """New textures."""
        return cls(*(_texture(context, size, *kind) for kind in ((4, "f4"), (2, "f2"), (2, "u4"), (2, "f2"), (2, "u4"))))

    def bind(self) -> None:
        """Bind all to their units."""
        for name, texture in vars(self).items():
            texture.use(SAMPLER_UNITS[f"u_{name}"])

    def release(self) -> None:
        """Free all."""
        for texture in vars(self).values():
            texture.release()


def draw_texels(device: Device, draw_list: DrawList, rows: np.ndarray, frame: CaptureFrame, with_back: bool) -> ImpostorTexels:
    """The texels of the instance rows of the mask `rows` (I,) as the frame's camera sees them; all empty where it sees none."""
    context, size = device.context, (frame.width, frame.height)
    samples = [_Samples(context, (SAMPLES * frame.width, SAMPLES * frame.height)) for _ in range(2)]
    texels = ImpostorTexels.of_size(context, size)
    front, back = samples
    front.draw(device, draw_list, rows, frame, None)
    back.clear()
    if with_back:
        back.draw(device, draw_list, rows, frame, front)
    context.enable_only(moderngl.NOTHING)
    front.bind("sample_")
    back.bind("back_")
    unit = shift_unit(frame)
    bare = _texture(context, size, 4, "f4")
    targets = [bare, texels.normal, texels.ids, texels.back_normal, texels.back_ids]
    _gather(device, "impostor_texels.frag", targets, unit, frame)
    texels.bind()
    bare.use(SAMPLER_UNITS["u_layers"])
    _gather(device, "impostor_edges.frag", [texels.layers], unit, frame)
    device.unbind()
    for target in (*samples, bare):
        target.release()
    return texels


def last_surface(device: Device, draw_list: DrawList, rows: np.ndarray, frame: CaptureFrame) -> np.ndarray:
    """(h, w) float32 |relief| of the farthest surface of the rows `rows` (I,) on the ray through each texel's middle; 0 without."""
    farthest = _Samples(device.context, (frame.width, frame.height))
    farthest.draw(device, draw_list, rows, frame, None, farthest=True)
    found = read_texture(farthest.layers)[..., 0]
    device.unbind()
    farthest.release()
    return found


def _gather(device: Device, shader: str, targets: list[moderngl.Texture], unit: float, frame: CaptureFrame) -> None:
    """Run one of the shaders that make texels of samples."""
    program = device.programs.get("fullscreen.vert", shader, **DEFINES)
    set_uniforms(program, u_unit=unit, u_size=(frame.width, frame.height))
    framebuffer = device.context.framebuffer(targets)
    framebuffer.use()
    array = device.context.vertex_array(program, [])
    array.render(moderngl.TRIANGLES, vertices=3)
    device.unbind()
    array.release()
    framebuffer.release()


class _Samples:
    """The targets of one layer of a capture, sample by sample."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.layers, self.normal, self.ids = (_texture(context, size, *kind) for kind in ((4, "f4"), (2, "f2"), (2, "u4")))
        self._depth = context.depth_texture(size)
        self._framebuffer = context.framebuffer([self.layers, self.normal, self.ids], self._depth)

    def clear(self, depth: float = 1.0) -> None:
        """Nothing is seen."""
        self._framebuffer.use()
        self._framebuffer.clear(depth=depth)

    def bind(self, prefix: str) -> None:
        """Bind the textures as `u_<prefix>layers` and so on."""
        for name in ("layers", "normal", "ids"):
            getattr(self, name).use(SAMPLER_UNITS[f"u_{prefix}{name}"])

    def draw(
        self, device: Device, draw_list: DrawList, rows: np.ndarray, frame: CaptureFrame, first: _Samples | None, farthest: bool = False
    ) -> None:
        """Draw the nearest surface, or the nearest behind those of `first` (depth peeling), or the farthest."""
        camera = frame.camera()
        self.clear(0.0 if farthest else 1.0)
        device.context.depth_func = ">" if farthest else "<"
        device.context.enable_only(moderngl.DEPTH_TEST)
        defines = {"LAYER": first is not None, "PERSPECTIVE": f"{frame.is_perspective}".lower()}
        pair = [device.programs.get("gbuffer.vert", "impostor_surface.frag", INSTANCED=flag, **defines) for flag in (0, 1)]
        if first is not None:
            first.layers.use(SAMPLER_UNITS["u_layers"])
        for program in pair:
            set_uniforms(
                program,
                u_clip_from_world=matrix_bytes(camera.clip_from_world),
                u_view_depth_from_world=np.asarray(-camera.view_from_world[2], np.float32).tobytes(),
                u_along_from_pixel=matrix_bytes(pixel_rays(camera, self.size)[0]),
                u_plane=-float(frame.source[2]) if frame.is_perspective else 0.0,
                u_apart=APART_TEXELS * frame.texel_m,
            )
        draw_list.draw(*pair, frustum_planes(camera.clip_from_world), attributes=True, rows=rows)
        device.context.depth_func = "<"

    def release(self) -> None:
        """Free the targets."""
        for thing in (self._framebuffer, self.layers, self.normal, self.ids, self._depth):
            thing.release()


def _texture(context: moderngl.Context, size: tuple[int, int], components: int, dtype: str) -> moderngl.Texture:
    texture = context.texture(size, components, dtype=dtype)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture
