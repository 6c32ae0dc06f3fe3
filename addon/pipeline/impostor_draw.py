"""Drawing relief impostors into the G-buffer, as if they were geometry. Worker thread only.

`inverse`: every pixel of the quad follows its view ray through the relief's texels (exact cell walk, front and back layer).
`sprite`: the texture as it lies on the plane.
"""

from __future__ import annotations

import moderngl
import numpy as np

from ..maths.relief import CaptureFrame, relief_warp
from ..maths.relief_frame import visible_extent
from ..maths.view import Camera
from .device import Device
from .gbuffer_pass import GBuffer
from .impostor_capture import ImpostorTextures
from .programs import SAMPLER_UNITS, matrix_bytes, set_uniforms

CONTINUOUS_TEXELS = 1.0
"""Depth steps up to so many texels between neighbours are one surface: the ray meets it instead of passing through the gap."""


def clip_from_texel(frame: CaptureFrame, camera: Camera) -> np.ndarray:
    """(4, 4) clip coordinates from (u, v, |δ|, 1): `clip_from_world · world_from_plane · ((u, v, 0, 1) + δ·S)`."""
    texel = np.eye(4)
    texel[:, 2] = frame.source * _away(frame)
    return camera.clip_from_world @ frame.world_from_plane @ texel


def draw_impostor(device: Device, target: GBuffer, impostor: ImpostorTextures, hull_ws: np.ndarray, camera: Camera, *,
                  sprite: bool = False, fade: float = 1.0, fade_rest: bool = False) -> None:
    """Draw one impostor over what `target` holds (depth-tested, not cleared).

    `fade` < 1 draws that share of the pixels, dithered, and with `fade_rest` exactly the others: old and new texture during a crossfade.
    Raises `SceneError` when the eye does not stand before the impostor's plane.
    """
    context, frame = device.context, impostor.frame
    warp = relief_warp(frame, camera)
    program = device.programs.get("impostor_quad.vert", "impostor.frag", SPRITE=sprite)
    away = _away(frame)
    extent = np.array([[0.0, 0.0], [frame.width, frame.height]]) if sprite else visible_extent(frame, hull_ws, camera)
    view_row = -camera.view_from_world[2] @ frame.world_from_plane
    set_uniforms(
        program, u_clip_from_texel=matrix_bytes(clip_from_texel(frame, camera)), u_extent=tuple(map(float, extent.ravel())),
        u_view_depth_from_texel=(float(view_row[0]), float(view_row[1]), float(view_row @ frame.source * away), float(view_row[3])),
        u_warp=tuple(float(k) * away for k in warp.K), u_size=(frame.width, frame.height), u_source_w=float(frame.source[3]) * away,
        u_deepest=abs(frame.deepest_relief) * (1.0 + 1e-5), u_fade=fade, u_fade_rest=int(fade_rest),
        u_continuous=CONTINUOUS_TEXELS * frame.texel_m / abs(float(frame.source[2])))
    for name, texture in (("u_layers", impostor.layers), ("u_normal", impostor.normal), ("u_ids", impostor.ids),
                          ("u_back_normal", impostor.back_normal), ("u_back_ids", impostor.back_ids)):
        texture.use(SAMPLER_UNITS[name])
    target.framebuffer.use()
    context.enable_only(moderngl.DEPTH_TEST)
    array = context.vertex_array(program, [])
    array.render(moderngl.TRIANGLE_STRIP, vertices=4)
    array.release()


def _away(frame: CaptureFrame) -> float:
    """Sign of the relief behind the plane."""
    return -1.0 if frame.is_perspective else 1.0
