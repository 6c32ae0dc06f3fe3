"""Drawing relief impostors into the G-buffer, as if they were geometry. Worker thread only.

`inverse`: every pixel of the quad follows its view ray through the relief's texels (exact cell walk, front and back layer; no rubber
sheets, since what lies behind a depth step is known to be unknown). `forward`: the texts' pre-warp, holes filled by interpolation, then
the quad. `sprite`: the texture as it lies on the plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from ..maths.relief import CaptureFrame, ReliefWarp, relief_warp, shift_unit
from ..maths.relief_frame import visible_extent
from ..maths.view import Camera
from .device import Device
from .gbuffer_pass import GBuffer
from .impostor_capture import CONTINUOUS_TEXELS, TILE, ImpostorTextures
from .impostor_texels import DEFINES, EMPTY, ImpostorTexels
from .programs import SAMPLER_UNITS, matrix_bytes, set_uniforms

METHODS = ("inverse", "forward")
_KINDS = {"inverse": 0, "sprite": 1, "forward": 2}
BLOCK_TEXELS = 16
"""Side of the blocks in which an impostor is drawn: those that no surface can be seen in are left out."""
LARGEST_PREWARP = 2
"""The pre-warped texture is at most so many times as large as the captured one, per side."""


@dataclass(frozen=True)
class _Source:
    """The textures that the quad's shader reads, their size, and the plane coordinates of their first texel."""

    texels: ImpostorTexels
    tiles: moderngl.Texture
    size: tuple[int, int]
    corner: tuple[float, float] = (0.0, 0.0)

    def bind(self) -> None:
        """Bind all to their units."""
        self.texels.bind()
        self.tiles.use(SAMPLER_UNITS["u_tiles"])


def clip_from_texel(frame: CaptureFrame, clip_from_world: np.ndarray) -> np.ndarray:
    """(4, 4) clip coordinates from (u, v, |δ|, 1): `clip_from_world · world_from_plane · ((u, v, 0, 1) + δ·S)`."""
    texel = np.eye(4)
    texel[:, 2] = frame.source * _away(frame)
    return clip_from_world @ frame.world_from_plane @ texel


def draw_impostor(
    device: Device,
    target: GBuffer,
    impostor: ImpostorTextures,
    hull_ws: np.ndarray,
    camera: Camera,
    *,
    method: str = "inverse",
    fade: float = 1.0,
    fade_rest: bool = False,
    fill: bool = True,
    behind_texels: float = 0.0,
) -> None:
    """Draw one impostor over what `target` holds (depth-tested, not cleared). `method`: 'inverse', 'forward' or 'sprite'.

    `fade` < 1 draws that share of the pixels, dithered, and with `fade_rest` exactly the others: old and new texture during a crossfade.
    `fill`: a surface that a nearer part hid at capture goes on behind it. `behind_texels`: with the depth of surfaces so much farther back.
    Raises `SceneError` when the eye does not stand before the impostor's plane.
    """
    frame = impostor.frame
    warp = relief_warp(frame, camera)
    extent = impostor.content_uv if method == "sprite" else _seen_extent(impostor, hull_ws, camera, warp)
    source = _Source(impostor.texels, impostor.tiles, (frame.width, frame.height))
    scratch = None
    if method == "forward":
        extent = _whole_texels(visible_extent(frame, hull_ws, camera), frame)
        scratch = _Prewarped(device, source, frame, warp, extent)
        source = scratch.source
    program = _program(device, method, fill=fill)
    _set(program, frame, camera, warp, source)
    behind = behind_texels * shift_unit(frame)
    set_uniforms(program, u_fade=fade, u_fade_rest=int(fade_rest), u_behind=behind)
    source.bind()
    target.use()
    device.context.enable_only(moderngl.DEPTH_TEST)
    _render_blocks(device.context, program, impostor, extent)
    if scratch is not None:
        scratch.release()


def draw_caster(device: Device, impostor: ImpostorTextures, clip_from_world: np.ndarray) -> None:
    """Draw the depth of an impostor captured from the light into the bound shadow map of projection `clip_from_world` (4, 4)."""
    frame = impostor.frame
    program = _program(device, "sprite", caster=True)
    set_uniforms(
        program,
        u_clip_from_texel=matrix_bytes(clip_from_texel(frame, clip_from_world)),
        u_size=(frame.width, frame.height),
        u_fade=1.0,
        u_behind=0.0,
    )
    _Source(impostor.texels, impostor.tiles, (frame.width, frame.height)).bind()
    _render_blocks(device.context, program, impostor, impostor.content_uv)


def _program(device: Device, method: str, *, fill: bool = False, caster: bool = False) -> moderngl.Program:
    """The program that draws by this method."""
    kind = {"METHOD": _KINDS[method], "FILL": fill, "CASTER": caster, "TILE": TILE, "BLOCK": BLOCK_TEXELS}
    return device.programs.get("impostor_blocks.vert", "impostor.frag", **kind, **DEFINES)


def _set(program: moderngl.Program, frame: CaptureFrame, camera: Camera, warp: ReliefWarp, source: _Source) -> None:
    """All uniforms of the view and the texture but the fade."""
    away, view_row = _away(frame), -camera.view_from_world[2] @ frame.world_from_plane
    set_uniforms(
        program,
        u_clip_from_texel=matrix_bytes(clip_from_texel(frame, camera.clip_from_world)),
        u_view_depth_from_texel=(float(view_row[0]), float(view_row[1]), float(view_row @ frame.source * away), float(view_row[3])),
        u_warp=tuple(float(k) * away for k in warp.K),
        u_size=source.size,
        u_source_w=float(frame.source[3]) * away,
        u_corner=source.corner,
        u_continuous=CONTINUOUS_TEXELS * shift_unit(frame),
    )


class _Prewarped:
    """The forward pre-warp of a texture for one eye, on the part `extent` of its plane, one texel to one texel."""

    def __init__(self, device: Device, source: _Source, frame: CaptureFrame, warp: ReliefWarp, extent: np.ndarray) -> None:
        context = device.context
        size = tuple(int(n) for n in extent[1] - extent[0])
        texels = ImpostorTexels.of_size(context, size)
        self._depth = context.depth_texture(size)
        self._framebuffer = context.framebuffer([texels.layers, texels.normal, texels.ids], self._depth)
        self._framebuffer.use()
        self._framebuffer.clear(red=float(EMPTY))
        context.enable_only(moderngl.DEPTH_TEST)
        source.bind()
        for mesh, mode, count in (
            (1, moderngl.TRIANGLES, 6 * (frame.width - 1) * (frame.height - 1)),
            (0, moderngl.POINTS, frame.width * frame.height),
        ):
            program = device.programs.get("impostor_prewarp.vert", "impostor_prewarp.frag", MESH=mesh, **DEFINES)
            set_uniforms(
                program,
                u_extent=tuple(map(float, extent.ravel())),
                u_size=source.size,
                u_deepest=_deepest(frame),
                u_warp=tuple(float(k) * _away(frame) for k in warp.K),
            )
            _render(context, program, mode, count)
        self.source = _Source(texels, source.tiles, size, tuple(map(float, extent[0])))

    def release(self) -> None:
        """Free the target."""
        for thing in (self._framebuffer, self._depth, self.source.texels):
            thing.release()


def _seen_extent(impostor: ImpostorTextures, hull_ws: np.ndarray, camera: Camera, warp: ReliefWarp) -> np.ndarray:
    """(2, 2) the part of the plane under which `camera` can see what the texels hold: within the bounds, on rays of full texels."""
    frame = impostor.frame
    within = visible_extent(frame, hull_ws, camera)
    corners = np.array([[u, v] for u in impostor.content_uv[:, 0] for v in impostor.content_uv[:, 1]])
    ends = np.concatenate([warp.forward(corners, np.full(4, relief)) for relief in (0.0, frame.deepest_relief)])
    low, high = np.maximum(within[0], ends.min(axis=0)), np.minimum(within[1], ends.max(axis=0))
    return np.stack([low, np.maximum(low, high)])


def _whole_texels(extent: np.ndarray, frame: CaptureFrame) -> np.ndarray:
    """(2, 2) the extent grown to whole texels and kept within `LARGEST_PREWARP` times the texture round its middle."""
    size = np.array([frame.width, frame.height])
    low, high = np.floor(extent[0] - 0.5), np.ceil(extent[1] + 0.5)
    reach = LARGEST_PREWARP * size // 2
    return np.stack([np.maximum(low, size // 2 - reach), np.minimum(high, size // 2 + reach)])


def _render_blocks(context: moderngl.Context, program: moderngl.Program, impostor: ImpostorTextures, extent: np.ndarray) -> None:
    """Draw the part `extent` (2, 2) of the plane block by block."""
    columns, rows = np.maximum(np.ceil((extent[1] - extent[0]) / BLOCK_TEXELS), 1.0).astype(int)
    set_uniforms(
        program,
        u_extent=tuple(map(float, extent.ravel())),
        u_columns=int(columns),
        u_nearest=impostor.nearest,
        u_deepest=_deepest(impostor.frame),
    )
    _render(context, program, moderngl.TRIANGLES, 6 * int(columns) * int(rows))


def _render(context: moderngl.Context, program: moderngl.Program, mode: int, vertices: int) -> None:
    """Draw without attributes."""
    array = context.vertex_array(program, [])
    array.render(mode, vertices=vertices)
    array.release()


def _deepest(frame: CaptureFrame) -> float:
    return abs(frame.deepest_relief) * (1.0 + 1e-5)


def _away(frame: CaptureFrame) -> float:
    """Sign of the relief behind the plane."""
    return -1.0 if frame.is_perspective else 1.0
