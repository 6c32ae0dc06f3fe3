"""The texels of a relief impostor: drawn sample by sample, four samples a texel, then gathered. Worker thread only.

A texel is one surface: the nearest that its samples show, as a plane. Where not all samples lie on it, the texel is an edge, and four bits
a sample say whether a neighbour's surface shows there, or nothing: outlines and creases keep twice the resolution of the surfaces.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass

import moderngl
import numpy as np

from ...maths.anchored_camera import AnchoredCamera
from ...maths.relief.outline import STEEPEST
from ...maths.relief.warp import CaptureFrame, shift_unit
from ..device import Device
from ..geometry.draw_list import DrawList
from ..gl.allocation import freed_with
from ..gl.depth_buffer import DepthBuffer
from ..gl.gl_raw import finish
from ..gl.programs import SAMPLER_UNITS, matrix_bytes, set_uniforms
from ..passes.gbuffer import pixel_rays
from ..passes.surface import SurfaceShader, draw_surfaces

EMPTY = np.float32(1e9)
SAMPLES = 2
"""Samples per texel and side."""
BYTES_PER_TEXEL = 33
"""32 of the texels themselves, one of the grids over them (`tiles.py`)."""
APART_TEXELS = 0.25
"""Surfaces nearer to each other than this are one when the back layer is peeled."""
KEPT_SAMPLES = 1 << 20
"""Targets of up to so many samples a layer (32 bytes each) are kept for the next capture."""
DEFINES = {"EMPTY": f"{EMPTY:.1f}", "STEEPEST": f"{STEEPEST:.1f}"}


@dataclass(eq=False)
class ImpostorTexels:
    """What the drawing shaders read: `layers` RGBA32F (±|relief|, its gradient per texel in u and v, |relief| of the back) and `both_ids`
    RGBA32UI of the front and the back as in the G-buffer. `common_impostor.glsl` says how edges are kept in the gradients."""

    layers: moderngl.Texture
    both_ids: moderngl.Texture

    @classmethod
    def of_size(cls, context: moderngl.Context, size: tuple[int, int]) -> ImpostorTexels:
        """New textures."""
        return cls(*(_texture(context, size, *kind) for kind in ((4, "f4"), (4, "u4"))))

    def bind(self) -> None:
        """Bind all to their units."""
        for name, texture in vars(self).items():
            texture.use(SAMPLER_UNITS[f"u_{name}"])

    def release(self) -> None:
        """Free all."""
        for texture in vars(self).values():
            texture.release()


def draw_texels(
    device: Device, draw_list: DrawList, rows: np.ndarray, frame: CaptureFrame, with_back: bool, with_last: bool
) -> tuple[ImpostorTexels, np.ndarray | None]:
    """(texels, last) of the instance rows of the mask `rows` (I,) as the frame's camera sees them; all empty where it sees none.

    `last` (h, w) float32, `with_last` only: |relief| of the farthest surface on the ray through each texel's middle, 0 without.
    """
    samples = kept_samples(device)
    front, back = samples.of_size((SAMPLES * frame.width, SAMPLES * frame.height))
    front.draw(device, draw_list, rows, frame, None)
    if with_back:
        back.draw(device, draw_list, rows, frame, front)
    else:
        back.clear(1.0)
    front.bind("sample_")
    back.bind("back_")
    texels = _texels(device, frame)
    last = None
    if with_last:
        front.draw(device, draw_list, rows, frame, None, farthest=True)
        last = front.relief((frame.width, frame.height))
    device.unbind()
    samples.release_large()
    return texels, last


def _texels(device: Device, frame: CaptureFrame) -> ImpostorTexels:
    """The texels of the samples bound."""
    context, size = device.context, (frame.width, frame.height)
    texels = ImpostorTexels.of_size(context, size)
    bare, normals, edges = _texture(context, size, 4, "f4"), _texture(context, size, 2, "f2"), context.depth_renderbuffer(size)
    targets = [bare, normals, texels.both_ids, texels.layers]
    context.enable_only(moderngl.DEPTH_TEST)
    context.depth_func = "1"
    _gather(device, "impostor_texels.frag", targets, edges, frame)
    texels.bind()
    bare.use(SAMPLER_UNITS["u_layers"])
    normals.use(SAMPLER_UNITS["u_front_normals"])
    context.depth_func = "<"
    _gather(device, "impostor_edges.frag", [texels.layers], edges, frame)
    for scratch in (bare, normals, edges):
        scratch.release()
    return texels


def _gather(device: Device, shader: str, targets: list[moderngl.Texture], edges: moderngl.Renderbuffer, frame: CaptureFrame) -> None:
    """Run one of the shaders that make texels of samples: the first marks the edge texels in `edges`, the second runs on them alone."""
    program = device.programs.get("fullscreen.vert", shader, **DEFINES)
    set_uniforms(program, u_unit=shift_unit(frame), u_size=(frame.width, frame.height))
    framebuffer = device.context.framebuffer(targets, edges)
    framebuffer.use()
    array = device.context.vertex_array(program, [])
    array.render(moderngl.TRIANGLES, vertices=3)
    device.unbind()
    array.release()
    framebuffer.release()


def kept_samples(device: Device) -> _KeptSamples:
    """The device's targets for captures, made on first use and released with it."""
    return device.attached("impostor samples", lambda: _KeptSamples(device))


class _KeptSamples:
    """The two layers' targets from capture to capture: to make them anew takes a third of a capture's time. Released with the device."""

    def __init__(self, device: Device) -> None:
        self._device, self._layers = device, ()

    def of_size(self, size: tuple[int, int]) -> tuple[_Samples, _Samples]:
        """Two targets of at least `size`."""
        if not self._layers or any(have < wanted for have, wanted in zip(self._layers[0].size, size, strict=True)):
            self.release()
            whole = tuple(-(-n // 64) * 64 for n in size)
            with ExitStack() as made:
                first, second = (freed_with(made, _Samples(self._device.context, whole)) for _ in range(2))
                made.pop_all()
            self._layers = first, second
        return self._layers

    def release_large(self) -> None:
        """Free what is too large to be kept."""
        if self._layers and self._layers[0].size[0] * self._layers[0].size[1] > KEPT_SAMPLES:
            self.release()

    def release(self) -> None:
        """Free them; idempotent."""
        self._device.unbind()
        for layer in self._layers:
            layer.release()
        self._layers = ()


class _Samples:
    """The targets of one layer of a capture, sample by sample. Where `ids` is 0 the others hold nothing of meaning."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.layers, self.normal, self.ids = (_texture(context, size, *kind) for kind in ((4, "f4"), (2, "f2"), (2, "u4")))
        with ExitStack() as made:  # freed when what follows fails
            self._depth = freed_with(made, DepthBuffer(context, size))
            self._framebuffer = self._depth.framebuffer([self.layers, self.normal, self.ids])
            self._found = self._depth.framebuffer([self.ids])
            made.pop_all()

    def clear(self, depth: float) -> None:
        """Nothing is seen, and all of this depth."""
        self._found.use()
        self._found.clear(depth=depth)

    def relief(self, size: tuple[int, int]) -> np.ndarray:
        """(h, w) float32 |relief| of the first `size` (w, h) samples, row 0 at the top; 0 where there is none."""
        finish(self._framebuffer.ctx)
        kinds = ((0, "f4", np.float32), (2, "u4", np.uint32))
        relief, ids = (
            np.frombuffer(self._framebuffer.read((0, 0, *size), 1, attachment=i, dtype=dtype), kind).reshape(size[::-1])
            for i, dtype, kind in kinds
        )
        return np.where(ids > 0, relief, np.float32(0.0))[::-1]

    def bind(self, prefix: str) -> None:
        """Bind the textures as `u_<prefix>layers` and so on."""
        for name in ("layers", "normal", "ids"):
            getattr(self, name).use(SAMPLER_UNITS[f"u_{prefix}{name}"])

    def draw(
        self, device: Device, draw_list: DrawList, rows: np.ndarray, frame: CaptureFrame, first: _Samples | None, farthest: bool = False
    ) -> None:
        """Draw the nearest surface, or the nearest behind those of `first` (depth peeling), or the farthest, one sample a texel."""
        eye, per_side = AnchoredCamera.of(frame.camera()), 1 if farthest else SAMPLES
        size = (per_side * frame.width, per_side * frame.height)
        self.clear(eye.depth.nearest if farthest else eye.depth.farthest)
        self._framebuffer.viewport = (0, 0, *size)
        self._framebuffer.use()
        if first is not None:
            first.bind("sample_")
        shader = _shader(frame, eye, size, is_behind=first is not None)
        draw_surfaces(device.context, device.programs, draw_list, eye, shader, size, rows, farthest=farthest)

    def release(self) -> None:
        """Free the targets."""
        for thing in (self._framebuffer, self._found, self.layers, self.normal, self.ids, self._depth):
            thing.release()


def _shader(frame: CaptureFrame, eye: AnchoredCamera, size: tuple[int, int], is_behind: bool) -> SurfaceShader:
    """What writes the samples of the nearest layer, or of the one behind it."""
    plane = -float(frame.source[2]) if frame.is_perspective else 0.0
    uniforms = {
        "u_along_from_pixel": matrix_bytes(pixel_rays(eye.camera, size)[0]),
        "u_plane": plane - eye.depth.near,
        "u_apart": APART_TEXELS * frame.texel_m,
    }
    return SurfaceShader("impostor_surface.frag", {"LAYER": is_behind, "PERSPECTIVE": f"{frame.is_perspective}".lower()}, uniforms)


def _texture(context: moderngl.Context, size: tuple[int, int], components: int, dtype: str) -> moderngl.Texture:
    texture = context.texture(size, components, dtype=dtype)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture
