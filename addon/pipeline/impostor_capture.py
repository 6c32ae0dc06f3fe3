"""Capture of a relief impostor: what the frame's camera sees of some instances, and where the solids it sees end. Worker thread only.

A texel holds what the G-buffer holds (depth, normal, slot and triangle), not a colour: an impostor is shaded with the rest of the picture,
receives its shadows and follows its light. It stays valid as long as the slots and triangles it names mean the same (`fingerprint`).
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import moderngl
import numpy as np

from ..errors import GpuError, SceneError
from ..maths.relief import CaptureFrame, relief_from_depth
from ..maths.relief_edges import EdgeChoice, ReliefEdges, relief_edges
from ..maths.view import Camera
from .clusters import frustum_planes
from .device import Device
from .draw_list import DrawList
from .gbuffer_pass import GBuffer, draw_gbuffer, pixel_rays
from .programs import SAMPLER_UNITS, matrix_bytes, set_uniforms
from .readback import read_texture

EMPTY = np.float32(1e9)
BYTES_PER_TEXEL = 40
APART_TEXELS = 0.25
TILE = 8


@dataclass(eq=False)
class ImpostorTextures:
    """A captured impostor on the GPU and what the predictors keep of it on the CPU.

    `layers` RGBA32F (|relief|, its gradient per texel in u and v, |relief| of the back); `normal`, `ids` as in the G-buffer, and the same
    of the back layer; `tiles` R32F the nearest |relief| of every `TILE` × `TILE` texels (row 0 first), `nearest` of all. `depth_m`,
    `back_m` (h, w) float32 metres behind the plane, `mask` (h, w) bool, row 0 at the top.
    """

    frame: CaptureFrame
    layers: moderngl.Texture
    normal: moderngl.Texture
    ids: moderngl.Texture
    back_normal: moderngl.Texture
    back_ids: moderngl.Texture
    tiles: moderngl.Texture
    nearest: float
    edges: ReliefEdges
    depth_m: np.ndarray
    back_m: np.ndarray
    mask: np.ndarray
    fingerprint: Hashable
    is_released: bool = False

    @property
    def bytes(self) -> int:
        """Texture memory."""
        return capture_bytes(self.frame)

    def release(self) -> None:
        """Free the textures; idempotent."""
        if not self.is_released:
            for texture in (self.layers, self.normal, self.ids, self.back_normal, self.back_ids, self.tiles):
                texture.release()
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
    device: Device, draw_list: DrawList, rows: np.ndarray, frame: CaptureFrame, *, with_back: bool = True, choice: EdgeChoice | None = None
) -> ImpostorTextures:
    """Capture the instance rows of the mask `rows` (I,). `with_back` False leaves out the back layer: every surface is a sheet.

    Raises `SceneError` when nothing of them is seen, `GpuError` when the frame exceeds the driver's texture size.
    """
    context, size = device.context, (frame.width, frame.height)
    limit = context.info["GL_MAX_TEXTURE_SIZE"]
    if max(size) > limit:
        raise GpuError(f"An impostor of {size[0]}×{size[1]} texels exceeds this driver's limit of {limit}: lower its resolution.")
    camera = frame.camera()
    front, back = GBuffer(context, size), GBuffer(context, size)
    try:
        draw_gbuffer(context, device.programs, front, draw_list, camera, rows)
        if with_back:
            _draw_back(device, front, back, draw_list, camera, rows, APART_TEXELS * frame.texel_m)
        mask = read_texture(front.ids)[..., 0] > 0
        depth, ends = _depths(frame, front, back, with_back)
        edges = relief_edges(frame, depth, mask, ends if with_back else None, choice or EdgeChoice())
        layers = _layers(frame, depth, ends, mask)
        tiles = nearest_of_tiles(layers)
    except (SceneError, GpuError):
        device.unbind()
        for target in (front, back):
            target.release()
        raise
    device.unbind()
    for target in (front, back):
        for thing in (target.framebuffer, target.view_depth, target.depth):
            thing.release()
    return ImpostorTextures(
        frame,
        _texture(context, layers[::-1]),
        front.normal,
        front.ids,
        back.normal,
        back.ids,
        _texture(context, tiles),
        max(0.0, float(tiles.min())),
        edges,
        depth,
        ends,
        mask,
        fingerprint(draw_list, rows),
    )


def _draw_back(
    device: Device, front: GBuffer, back: GBuffer, draw_list: DrawList, camera: Camera, rows: np.ndarray, apart_m: float
) -> None:
    """The nearest surface more than `apart_m` behind the first (depth peeling, one layer)."""
    back.framebuffer.use()
    back.framebuffer.clear()
    device.context.enable_only(moderngl.DEPTH_TEST)
    front.view_depth.use(SAMPLER_UNITS["u_view_depth"])
    along = pixel_rays(camera, front.size)[0]
    pair = [device.programs.get("gbuffer.vert", "impostor_back.frag", INSTANCED=flag) for flag in (0, 1)]
    for program in pair:
        set_uniforms(
            program,
            u_clip_from_world=matrix_bytes(camera.clip_from_world),
            u_apart=apart_m,
            u_view_depth_from_world=np.asarray(-camera.view_from_world[2], np.float32).tobytes(),
            u_along_from_pixel=np.ascontiguousarray(along.T, np.float32).tobytes(),
        )
    draw_list.draw(*pair, frustum_planes(camera.clip_from_world), attributes=True, rows=rows)


def _depths(frame: CaptureFrame, front: GBuffer, back: GBuffer, with_back: bool) -> tuple[np.ndarray, np.ndarray]:
    """(depth, back) in metres behind the plane; where the back layer is empty the surface is a sheet."""
    plane = -float(frame.source[2]) if frame.is_perspective else 0.0
    depth = np.maximum(read_texture(front.view_depth) - np.float32(plane), np.float32(0.0))
    if not with_back:
        return depth, depth
    ends = read_texture(back.view_depth) - np.float32(plane)
    return depth, np.where(read_texture(back.ids)[..., 0] > 0, np.maximum(ends, depth), depth)


def _layers(frame: CaptureFrame, depth: np.ndarray, ends: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """(h, w, 4) float32: `layers` of `ImpostorTextures`, row 0 at the top."""
    near = np.where(mask, np.abs(relief_from_depth(frame.source, np.where(mask, depth, 0.0))), 0.0)
    far = np.abs(relief_from_depth(frame.source, np.where(mask, ends, 0.0)))
    unit = frame.texel_m / abs(float(frame.source[2]))
    image = np.empty((*mask.shape, 4), np.float32)
    image[..., 0] = np.where(mask, near, EMPTY)
    image[..., 1], image[..., 2] = relief_gradient(near, mask, 1, unit), relief_gradient(near, mask, 0, unit)
    image[..., 3] = np.where(mask, far, -1.0)
    return image


def nearest_of_tiles(layers: np.ndarray) -> np.ndarray:
    """(⌈h/TILE⌉, ⌈w/TILE⌉) float32: no front surface in the square lies nearer, its slopes included; `EMPTY` without one."""
    nearest = layers[..., 0] - 0.5 * np.abs(layers[..., 1:3]).sum(axis=-1)
    height, width = (-(-n // TILE) for n in nearest.shape)
    padded = np.full((height * TILE, width * TILE), EMPTY, np.float32)
    padded[: nearest.shape[0], : nearest.shape[1]] = nearest
    return padded.reshape(height, TILE, width, TILE).min(axis=(1, 3))


def _texture(context: moderngl.Context, image: np.ndarray) -> moderngl.Texture:
    """A float texture whose first row is the image's."""
    components = 1 if image.ndim == 2 else image.shape[2]
    texture = context.texture((image.shape[1], image.shape[0]), components, np.ascontiguousarray(image).tobytes(), dtype="f4", alignment=1)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture


STEEPEST = 8.0


def relief_gradient(relief: np.ndarray, mask: np.ndarray, axis: int, unit: float) -> np.ndarray:
    """Change of relief per texel along `axis`: the smaller of the steps to both sides, which does not reach across depth edges.

    Exact for planes: relief of a plane is linear in u and v (orthographic: metres; perspective: 1/z).
    """
    step = np.where(np.diff(mask.astype(np.int8), axis=axis) == 0, np.diff(relief, axis=axis), np.inf)
    pad = [(0, 0), (0, 0)]
    pad[axis] = (1, 1)
    padded = np.pad(step, pad, constant_values=np.inf)
    before, after = (padded[:-1], padded[1:]) if axis == 0 else (padded[:, :-1], padded[:, 1:])
    chosen = np.where(np.abs(before) <= np.abs(after), before, after)
    return np.where(np.abs(chosen) <= STEEPEST * unit, chosen, 0.0).astype(np.float32)
