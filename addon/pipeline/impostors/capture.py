"""Capture of a relief impostor: what the frame's camera sees of some instances, and where the solids it sees end. Worker thread only.

A texel holds what the G-buffer holds (depth, normal, slot and triangle), not a colour: an impostor is shaded with the rest of the picture,
receives its shadows and follows its light. It stays valid as long as the slots and triangles it names mean the same (`fingerprint`).
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import moderngl
import numpy as np

from ...errors import GpuError, SceneError
from ...maths.relief.carry import carried
from ...maths.relief.edges import EdgeChoice, ReliefEdges, relief_edges
from ...maths.relief.warp import CaptureFrame, depth_from_relief, shift_unit
from ..device import Device
from ..geometry.draw_list import DrawList
from ..gl.allocation import allocating
from ..gl.readback import read_texture
from .texels import BYTES_PER_TEXEL, EMPTY, SAMPLES, ImpostorTexels, draw_texels
from .tiles import tiles_and_windows

CONTINUOUS_TEXELS = 1.0
"""Depth steps up to so many texels between neighbours are one surface: the ray meets it instead of passing through the gap."""


@dataclass(eq=False)
class ImpostorTextures:
    """A captured impostor on the GPU and what the predictors keep of it on the CPU.

    `tiles` RGB32F and `windows` RGBA32F, from fine to coarse, say at which depths a square of texels can be met (`tiles.py`),
    `nearest` from which any.
    `depth_m`, `back_m` (h, w) float32 metres behind the plane, `mask` (h, w) bool, row 0 at the top: whether any of the texel shows
    something; `content_uv` (2, 2) the smallest and largest (u, v) of those that do.
    """

    frame: CaptureFrame
    texels: ImpostorTexels
    tiles: moderngl.Texture
    windows: tuple[moderngl.Texture, ...]
    nearest: float
    edges: ReliefEdges
    depth_m: np.ndarray
    back_m: np.ndarray
    mask: np.ndarray
    content_uv: np.ndarray
    fingerprint: Hashable
    is_released: bool = False

    @property
    def bytes(self) -> int:
        """Texture memory."""
        return capture_bytes(self.frame)

    def release(self) -> None:
        """Free the textures; idempotent."""
        if not self.is_released:
            self.texels.release()
            for grid in (self.tiles, *self.windows):
                grid.release()
            self.is_released = True


def capture_bytes(frame: CaptureFrame) -> int:
    """The texture memory that a capture of this frame takes."""
    return frame.width * frame.height * BYTES_PER_TEXEL


def fingerprint(draw_list: DrawList, rows: np.ndarray) -> Hashable:
    """What must stay equal for captured slots and triangles to mean the same: where the rows' meshes lie, their slots and their placing."""
    chosen = np.flatnonzero(rows)
    ranges = draw_list.ranges
    baked = rows[ranges.rows] if len(ranges.rows) else np.zeros(0, bool)
    grouped = [(g.first_index, g.index_count, g.slots[rows[g.rows]].tobytes()) for g in draw_list.groups if rows[g.rows].any()]
    slots = np.flatnonzero(np.isin(draw_list.rows_of_slot, chosen))
    meshes = tuple(draw_list.scene.meshes[i].key for i in draw_list.scene.instances.mesh_index[chosen])
    return (
        ranges.first[baked].tobytes(),
        ranges.count[baked].tobytes(),
        tuple(grouped),
        slots.tobytes(),
        meshes,
        draw_list.scene.instances.world_from_object[chosen].tobytes(),
    )


def capture(
    device: Device,
    draw_list: DrawList,
    rows: np.ndarray,
    frame: CaptureFrame,
    *,
    with_back: bool = True,
    choice: EdgeChoice | None = None,
    known: ReliefEdges | None = None,
) -> ImpostorTextures:
    """Capture the instance rows of the mask `rows` (I,). `with_back` False leaves out the back layer: every surface is a sheet.

    `known`: edges of a capture of the same from farther away, to be carried over (where `carry.carries`) instead of gathered anew.

    Raises `SceneError` when nothing of them is seen, `GpuError` when the frame exceeds the driver's texture size or memory.
    """
    limit = device.context.info["GL_MAX_TEXTURE_SIZE"]
    if SAMPLES * max(frame.width, frame.height) > limit:
        size = f"{frame.width}×{frame.height}"
        raise GpuError(f"An impostor of {size} texels exceeds this driver's limit of {limit // SAMPLES}: lower its resolution.")
    with allocating(device.context, f"an impostor of {frame.width}×{frame.height} texels", "lower its resolution"):
        texels, last = draw_texels(device, draw_list, rows, frame, with_back, with_last=with_back and known is None)
    try:
        layers = read_texture(texels.layers)
        mask = layers[..., 0] < EMPTY
        near, far = np.abs(np.where(mask, layers[..., 0], 0.0)), np.where(mask, layers[..., 3], 0.0)
        depth, ends = (_metres(frame, relief) for relief in (near, far))
        if known is None:
            back, deepest = (ends, _metres(frame, last)) if with_back else (None, None)
            edges = relief_edges(frame, depth, mask, back, choice or EdgeChoice(), deepest)
        else:
            edges = carried(known, frame, int(mask.sum()))
    except (SceneError, GpuError):
        texels.release()
        raise
    tiles, windows = tiles_and_windows(layers, CONTINUOUS_TEXELS * shift_unit(frame))
    return ImpostorTextures(
        frame,
        texels,
        _texture(device.context, tiles),
        tuple(_texture(device.context, grid) for grid in windows),
        max(0.0, float(tiles[..., 0].min())),
        edges,
        depth,
        ends,
        mask,
        _content_uv(mask),
        fingerprint(draw_list, rows),
    )


def _metres(frame: CaptureFrame, relief: np.ndarray) -> np.ndarray:
    """float32 metres behind the plane of |relief|."""
    return depth_from_relief(frame.source, -relief if frame.is_perspective else relief).astype(np.float32)


def _content_uv(mask: np.ndarray) -> np.ndarray:
    """(2, 2) smallest and largest (u, v) of the texels of a mask (h, w) that is not empty."""
    v, u = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return np.array([[u[0], v[0]], [u[-1] + 1.0, v[-1] + 1.0]])


def _texture(context: moderngl.Context, image: np.ndarray) -> moderngl.Texture:
    """A float texture whose first row is the image's."""
    components = 1 if image.ndim == 2 else image.shape[2]
    texture = context.texture((image.shape[1], image.shape[0]), components, np.ascontiguousarray(image).tobytes(), dtype="f4", alignment=1)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture
