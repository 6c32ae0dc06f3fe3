"""Draws the triangles of a scene as a camera sees them, the nearest in front: for the G-buffer and for captures. Worker thread only."""

from __future__ import annotations

from dataclasses import dataclass, field

import moderngl
import numpy as np

from ..maths.anchored_camera import AnchoredCamera
from ..maths.depth_projection import DepthProjection
from .clusters import frustum_planes
from .depth_buffer import has_clip_control, nearest_wins
from .draw_list import DrawList
from .programs import Programs, set_uniforms


@dataclass(frozen=True)
class SurfaceShader:
    """The fragment stage behind gbuffer.vert, with its own defines and uniforms."""

    fragment: str
    defines: dict[str, int | bool | str] = field(default_factory=dict)
    uniforms: dict[str, object] = field(default_factory=dict)


def draw_surfaces(
    context: moderngl.Context,
    programs: Programs,
    draw_list: DrawList,
    eye: AnchoredCamera,
    shader: SurfaceShader,
    rows: np.ndarray | None = None,
    *,
    farthest: bool = False,
) -> int:
    """Draw the scene, or only the instance rows of the mask `rows`, into the bound and cleared target; returns the triangles sent.

    `farthest`: of all surfaces the farthest stays.
    """
    by = 0 if has_clip_control(context) else 1
    pair = [programs.get("gbuffer.vert", shader.fragment, INSTANCED=flag, DEPTH_BY=by, **shader.defines) for flag in (0, 1)]
    uniforms = shader.uniforms | depth_uniforms(eye.depth) | _view_uniforms(context, eye)
    for program in pair:
        set_uniforms(program, **uniforms)
    with nearest_wins(context, eye.depth, farthest=farthest):
        return draw_list.draw(*pair, frustum_planes(eye.camera.clip_from_world), attributes=True, rows=rows)


def depth_uniforms(depth: DepthProjection) -> dict[str, object]:
    """What `common_depth.glsl` and view depths need."""
    return {"u_depth_rule": depth.rule, "u_near": depth.near}


def _view_uniforms(context: moderngl.Context, eye: AnchoredCamera) -> dict[str, object]:
    """What the vertex stage needs, and where the picture ends where the rasteriser cannot tell."""
    a, b, c, e = eye.depth.rule
    if not has_clip_control(context):
        a, b = eye.depth.clip_rule
    return {
        "u_anchor": tuple(eye.anchor_ws),
        "u_rows": np.ascontiguousarray(eye.rows, np.float32).tobytes(),
        "u_clip_rule": (a, b, c, e),
        "u_section": eye.camera.far - eye.depth.near,
    }
