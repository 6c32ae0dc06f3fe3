"""Draws the triangles of a scene as a camera sees them, the nearest in front: for the G-buffer and for captures. Worker thread only."""

from __future__ import annotations

from dataclasses import dataclass, field

import moderngl
import numpy as np

from ...maths.anchored_camera import AnchoredCamera
from ...maths.depth_projection import DepthProjection
from ..geometry.clusters import frustum_planes
from ..geometry.culling import Culling
from ..geometry.draw_list import DrawList
from ..gl.depth_buffer import has_clip_control, nearest_wins
from ..gl.gl_raw import draw_vertices
from ..gl.programs import Programs, set_uniforms
from .large_surfaces import large_in, pieces

RASTERISER, FRAGMENT = 0, 1  # who finds the depth: common_surface.glsl


@dataclass(frozen=True)
class SurfaceShader:
    """The fragment stage behind gbuffer.vert or gbuffer_cut.vert, with its own defines and uniforms."""

    fragment: str
    defines: dict[str, int | bool | str] = field(default_factory=dict)
    uniforms: dict[str, object] = field(default_factory=dict)


def draw_surfaces(
    context: moderngl.Context,
    programs: Programs,
    draw_list: DrawList,
    eye: AnchoredCamera,
    shader: SurfaceShader,
    size: tuple[int, int],
    rows: np.ndarray | None = None,
    *,
    farthest: bool = False,
    culled: bool = False,
) -> int:
    """Draw the scene, or only the instance rows of the mask `rows`, into the bound and cleared target of `size`.

    Returns the triangles sent. `farthest`: of all surfaces the farthest stays. `culled`: without the back faces of closed meshes.
    """
    uniforms = shader.uniforms | depth_uniforms(eye.depth) | _view_uniforms(context, eye)
    defines = shader.defines | {"DEPTH_BY": RASTERISER if has_clip_control(context) else FRAGMENT}

    def prepared(vertex: str, is_cut: bool, **more: int) -> moderngl.Program:
        program = programs.get(vertex, shader.fragment, IS_CUT=is_cut, **defines, **more)
        set_uniforms(program, **uniforms)
        return program

    frustum = frustum_planes(eye.camera.clip_from_world)
    large = large_in(draw_list, eye, frustum, rows)
    pair = [prepared("gbuffer.vert", False, INSTANCED=flag) for flag in (0, 1)]
    with nearest_wins(context, eye.depth, farthest=farthest):
        culling = Culling.by(eye.camera.clip_from_world, near=True) if culled else None
        sent = draw_list.draw(*pair, frustum, attributes=True, rows=rows, without=large, culling=culling)
        if large is not None:
            sent += draw_vertices(context, prepared("gbuffer_cut.vert", True), pieces(draw_list, large, eye, size))
    return sent


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
