"""Drawing relief impostors into the G-buffer, as if they were geometry. Worker thread only.

`inverse`: every pixel follows its view ray through the relief's texels (exact cell walk, front and back layer; no rubber sheets, since what
lies behind a depth step is known to be unknown), or, where a block of pixels sees one smooth surface, goes straight to the texel that it
meets. `forward`: the texts' pre-warp, holes filled by interpolation, then the plane. `sprite`: the texture as it lies on the plane.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass

import moderngl
import numpy as np

from ...maths.depth_projection import DepthProjection, fitted
from ...maths.relief.frame import visible_extent
from ...maths.relief.warp import CaptureFrame, ReliefWarp, relief_warp, shift_unit
from ...maths.view import Camera
from ..device import Device
from ..gl.allocation import allocating, freed_with
from ..gl.depth_buffer import DepthBuffer, nearest_wins
from ..gl.programs import SAMPLER_UNITS, matrix_bytes, set_uniforms
from ..passes.gbuffer import FROM_TEXTURE, GBuffer
from ..passes.surface import depth_uniforms
from .capture import CONTINUOUS_TEXELS, ImpostorTextures
from .texels import DEFINES, EMPTY, ImpostorTexels
from .tiles import OVERLAP, STRIDES, TILE

_KINDS = {"inverse": 0, "sprite": 1, "forward": 2}
BLOCK = 8
"""Pixels per side of the blocks in which an impostor is drawn: those that no surface can be seen in are left out."""
MOST_STEPS = 256
"""Steps in depth at most, in which a block's rays are followed over the windows."""
LARGEST_PREWARP = 2
"""The pre-warped texture is at most so many times as large as the captured one, per side."""


@dataclass(frozen=True)
class _Source:
    """The textures that the shaders read, their size, and the plane coordinates of their first texel."""

    texels: ImpostorTexels
    tiles: moderngl.Texture
    size: tuple[int, int]
    corner: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, impostor: ImpostorTextures) -> _Source:
        """A capture as it is."""
        return cls(impostor.texels, impostor.tiles, (impostor.frame.width, impostor.frame.height))

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
    warp, source = relief_warp(frame, camera), _Source.of(impostor)
    place = clip_from_texel(frame, camera.clip_from_world)
    seen = _content(impostor, method) @ place.T
    hull = np.column_stack([hull_ws, np.ones(len(hull_ws))]) @ camera.clip_from_world.T
    scratch = None
    if method == "forward":
        extent = _whole_texels(visible_extent(frame, hull_ws, camera), frame)
        scratch = _Prewarped(device, source, frame, warp, extent)
        source, seen = scratch.source, _corners(extent, (0.0,)) @ place.T
    blocks = _Blocks.of(target.size, seen, hull)
    depth = target.projection or fitted(camera, np.stack([hull_ws.min(axis=0), hull_ws.max(axis=0)])[None])
    uniforms = _view_uniforms(frame, camera, warp, source) | _depth_uniforms(frame, camera, depth)
    uniforms |= blocks.uniforms(impostor, place, warp if method == "inverse" else None)
    uniforms |= {"u_fade": fade, "u_fade_rest": int(fade_rest), "u_behind": behind_texels * shift_unit(frame)}
    target.use()
    source.bind()
    with nearest_wins(device.context, depth):
        for is_smooth in (True, False) if method == "inverse" else (False,):
            program = _program(device, method, fill=fill, smooth=is_smooth)
            set_uniforms(program, **uniforms)
            blocks.draw(device.context, program)
    if scratch is not None:
        scratch.release()


def draw_caster(device: Device, impostor: ImpostorTextures, clip_from_world: np.ndarray, size: tuple[int, int]) -> None:
    """Draw the depth of an impostor captured from the light into the bound shadow map of `size` and projection `clip_from_world` (4, 4)."""
    frame = impostor.frame
    program = _program(device, "sprite", caster=True)
    place = clip_from_texel(frame, clip_from_world)
    blocks = _Blocks.of(size, _content(impostor, "sprite") @ place.T)
    set_uniforms(program, u_size=(frame.width, frame.height), u_fade=1.0, u_behind=0.0, **blocks.uniforms(impostor, place))
    _Source.of(impostor).bind()
    blocks.draw(device.context, program)


def _program(device: Device, method: str, *, fill: bool = False, caster: bool = False, smooth: bool = False) -> moderngl.Program:
    """The program that draws by this method; `smooth`: those blocks that see one smooth surface, else the others."""
    kind = {"METHOD": _KINDS[method], "FILL": fill, "CASTER": caster, "SMOOTH": smooth, "BLOCK": BLOCK}
    grids = {"TILE": TILE, "OVERLAP": OVERLAP, "MOST_STEPS": MOST_STEPS}
    mark = {"FROM_TEXTURE": f"{FROM_TEXTURE}u"}
    return device.programs.get("impostor_blocks.vert", "impostor.frag", **kind, **grids, **mark, **DEFINES)


def _view_uniforms(frame: CaptureFrame, camera: Camera, warp: ReliefWarp, source: _Source) -> dict[str, object]:
    """The uniforms of the view and the texture."""
    away = _away(frame)
    return {
        "u_warp": tuple(float(k) * away for k in warp.K),
        "u_size": source.size,
        "u_source_w": float(frame.source[3]) * away,
        "u_corner": source.corner,
        "u_continuous": CONTINUOUS_TEXELS * shift_unit(frame),
    }


def _depth_uniforms(frame: CaptureFrame, camera: Camera, depth: DepthProjection) -> dict[str, object]:
    """The uniforms of the target's depths: w times the metres behind the near plane of a texel's point, w = 1 + u_source_w a."""
    row = -camera.view_from_world[2] @ frame.world_from_plane
    row[3] -= depth.near
    return {
        "u_behind_near_from_texel": (float(row[0]), float(row[1]), float(row @ frame.source) * _away(frame), float(row[3])),
        "u_section": (camera.near - depth.near, camera.far - depth.near),
        **depth_uniforms(depth),
    }


class _Prewarped:
    """The forward pre-warp of a texture for one eye, on the part `extent` of its plane, one texel to one texel."""

    def __init__(self, device: Device, source: _Source, frame: CaptureFrame, warp: ReliefWarp, extent: np.ndarray) -> None:
        context = device.context
        size = tuple(int(n) for n in extent[1] - extent[0])
        with allocating(context, f"an impostor of {size[0]}×{size[1]} texels", "lower its resolution"):
            texels = ImpostorTexels.of_size(context, size)
            with ExitStack() as made:  # freed when what follows fails
                self._depth = freed_with(made, DepthBuffer(context, size))
                self._framebuffer = self._depth.framebuffer([texels.layers, texels.both_ids])
                made.pop_all()
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


def _content(impostor: ImpostorTextures, method: str) -> np.ndarray:
    """(8, 4) (u, v, |δ|, 1): the corners of what the texels hold; of a sprite, which lies on the plane, (4, 4)."""
    return _corners(impostor.content_uv, (0.0,) if method == "sprite" else (impostor.nearest, _deepest(impostor.frame)))


def _corners(extent: np.ndarray, depths: tuple[float, ...]) -> np.ndarray:
    """(4·n, 4) (u, v, |δ|, 1) of the part `extent` (2, 2) of the plane at n depths."""
    return np.array([[u, v, depth, 1.0] for u in extent[:, 0] for v in extent[:, 1] for depth in depths])


def _whole_texels(extent: np.ndarray, frame: CaptureFrame) -> np.ndarray:
    """(2, 2) the extent grown to whole texels and kept within `LARGEST_PREWARP` times the texture round its middle."""
    size = np.array([frame.width, frame.height])
    low, high = np.floor(extent[0] - 0.5), np.ceil(extent[1] + 0.5)
    reach = LARGEST_PREWARP * size // 2
    return np.stack([np.maximum(low, size // 2 - reach), np.minimum(high, size // 2 + reach)])


@dataclass(frozen=True)
class _Blocks:
    """The rectangle of a picture's grid of blocks in which something can be seen."""

    picture: tuple[int, int]
    first: tuple[int, int]
    count: tuple[int, int]

    @classmethod
    def of(cls, picture: tuple[int, int], *clips: np.ndarray) -> _Blocks:
        """The blocks under the images of all sets of points `clips` (n, 4), clip coordinates; points behind the eye may be anywhere."""
        low, high = np.zeros(2), np.array(picture, float)
        for clip in clips:
            if (clip[:, 3] > 0.0).all():
                pixel = (0.5 + 0.5 * clip[:, :2] / clip[:, 3:]) * picture
                low, high = np.maximum(low, pixel.min(axis=0)), np.minimum(high, pixel.max(axis=0))
        first = np.floor(low / BLOCK).astype(int)
        return cls(picture, tuple(first.tolist()), tuple(np.maximum(np.ceil(high / BLOCK).astype(int) - first, 0).tolist()))

    def uniforms(self, impostor: ImpostorTextures, clip_from_texel: np.ndarray, warp: ReliefWarp | None = None) -> dict[str, object]:
        """The uniforms of the blocks, and of the rays through their pixels, warped or not; the windows that these need are bound."""
        half_w, half_h = self.picture[0] / 2.0, self.picture[1] / 2.0
        pixel_from_clip = np.array([[half_w, 0.0, 0.0, half_w], [0.0, half_h, 0.0, half_h], [0.0, 0.0, 0.0, 1.0]])
        plane_from_pixel = np.linalg.inv(pixel_from_clip @ clip_from_texel[:, [0, 1, 3]])
        level = self._level(plane_from_pixel, warp, _deepest(impostor.frame) - impostor.nearest)
        windows = impostor.windows[level]
        windows.use(SAMPLER_UNITS["u_windows"])
        return {
            "u_clip_from_texel": matrix_bytes(clip_from_texel),
            "u_plane_from_pixel": matrix_bytes(plane_from_pixel),
            "u_stride": STRIDES[level],
            "u_last_window": (windows.width - 1, windows.height - 1),
            "u_picture": self.picture,
            "u_first": self.first,
            "u_columns": max(self.count[0], 1),
            "u_nearest": impostor.nearest,
            "u_deepest": _deepest(impostor.frame),
        }

    def _level(self, plane_from_pixel: np.ndarray, warp: ReliefWarp | None, depth: float) -> int:
        """The finest grid whose windows hold a block, with room to follow its rays over the `depth` of |relief| in `MOST_STEPS`."""
        corners = BLOCK * (np.array(self.first) + np.array(self.count) * [[0, 0], [1, 0], [0, 1], [1, 1]])
        beside = corners + BLOCK * np.array([[[0, 0]], [[1, 0]], [[0, 1]]])
        place = beside @ plane_from_pixel[:, :2].T + plane_from_pixel[:, 2]
        if place[..., 2].min() <= 0.0:
            return len(STRIDES) - 1
        uv = place[..., :2] / place[..., 2:]
        texels = np.abs(uv[1:] - uv[0]).sum(axis=0).max()
        moved = 0.0 if warp is None else np.abs(uv * warp.K[2] - warp.K[:2]).max() * depth
        fits = [(OVERLAP - 1.25) * stride >= texels + moved / MOST_STEPS for stride in STRIDES]
        return fits.index(True) if any(fits) else len(STRIDES) - 1

    def draw(self, context: moderngl.Context, program: moderngl.Program) -> None:
        """Draw each as a point."""
        if all(self.count):
            context.enable(moderngl.PROGRAM_POINT_SIZE)
            _render(context, program, moderngl.POINTS, self.count[0] * self.count[1])


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
