"""Feature edges: creases, borders, silhouettes and where parts meet, as anti-aliased lines over the picture. Worker thread only.

Made from the G-buffer, so the cost is that of its pixels, however many triangles there are, and what is hidden has no line. Each pixel
first finds the edge of its own triangle that is nearest (edge_lines.frag): the line is where the mesh's edge is, not where pixels change.
Then every pixel takes the nearest line of its neighbourhood (edge_coverage.frag).
"""

from __future__ import annotations

import math
from contextlib import ExitStack

import moderngl
import numpy as np

from ...maths.anchored_camera import AnchoredCamera
from ...maths.view import Camera
from ...scene.looks import CAP, GROUND
from ...settings.stage import EdgeLines
from ..geometry.draw_list import DrawList
from ..gl.allocation import freed_with
from ..gl.gl_raw import BufferTexture, draw_triangles
from ..gl.programs import Programs, matrix_bytes, set_uniforms
from .fill import bind, fill, fill_over
from .gbuffer import FROM_TEXTURE, GBuffer, pixel_rays

SLACK = 0.01  # of a depth, by which a line may lie behind the surface of a pixel beside it and be seen
ANGLE_SLACK = 1e-3  # faces at exactly the angle have no line


class EdgeTarget:
    """Of one picture: the line each pixel keeps (`lines` RGBA16F, `depth` R32F) and how much lines cover of each (`coverage` R32F)."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        with ExitStack() as made:
            self.lines = freed_with(made, context.texture(size, 4, dtype="f2"))
            self.depth = freed_with(made, context.texture(size, 1, dtype="f4"))
            self.coverage = freed_with(made, context.texture(size, 1, dtype="f4"))
            self.line_target = freed_with(made, context.framebuffer([self.lines, self.depth]))
            self.coverage_target = freed_with(made, context.framebuffer([self.coverage]))
            self._made = made.pop_all()

    def release(self) -> None:
        """Free the targets."""
        self._made.close()


def draw_edges(
    context: moderngl.Context,
    programs: Programs,
    target: EdgeTarget,
    gbuffer: GBuffer,
    draw_list: DrawList,
    triangles: dict[str, BufferTexture],
    camera: Camera,
    edges: EdgeLines,
    side: int = 1,
) -> None:
    """Fill `target.coverage` with the edges of what `gbuffer` shows; `triangles` with what lies across their edges (`u_links`).

    `side`: pixels of the G-buffer along one of the picture, in which widths are counted.
    """
    width = max(edges.width * side, 1.0)
    radius = max(1, math.ceil(math.sqrt(2.0) * (width / 2.0 + 0.5)))
    marks = {"CAP": CAP, "GROUND": GROUND, "FROM_TEXTURE": f"{FROM_TEXTURE}u"}
    lines = programs.get("fullscreen.vert", "edge_lines.frag", INSTANCED=0, **marks)
    set_uniforms(lines, **_view_uniforms(camera, target.size))
    set_uniforms(lines, u_crease_cos=math.cos(math.radians(edges.crease_deg) + ANGLE_SLACK), u_most_px=width / 2.0 + 1.5)
    bind(triangles | {"u_view_depth": gbuffer.view_depth, "u_ids": gbuffer.ids, "u_normal": gbuffer.normal})
    draw_list.bind_table()
    _fill_surfaces(context, target.line_target, lines, gbuffer)
    coverage = programs.get("fullscreen.vert", "edge_coverage.frag", RADIUS=radius)
    set_uniforms(coverage, u_width=edges.width * side, u_slack=SLACK)
    bind({"u_lines": target.lines, "u_line_depth": target.depth, "u_view_depth": gbuffer.view_depth})
    fill(context, target.coverage_target, coverage)


def _fill_surfaces(context: moderngl.Context, target: moderngl.Framebuffer, program: moderngl.Program, gbuffer: GBuffer) -> None:
    """Run `program` for the pixels of `target` in which `gbuffer` has a surface; the others are 0. The depth test tells them apart before
    a shader runs."""
    depth = gbuffer.projection
    target.clear()
    array = context.vertex_array(program, [])
    with gbuffer.depth.attached(target):
        set_uniforms(program, u_ndc_depth=2.0 * depth.farthest - 1.0)
        context.enable_only(moderngl.DEPTH_TEST)
        context.depth_func = {"<": ">", ">": "<"}[depth.nearer]
        draw_triangles(context, array, 3)
        context.depth_func = "<"
    array.release()
    context.enable_only(moderngl.NOTHING)


def blend_edges(context: moderngl.Context, programs: Programs, target: EdgeTarget, picture: moderngl.Texture, edges: EdgeLines) -> None:
    """Lay the lines of `target` over `picture` (RGBA, premultiplied)."""
    program = programs.get("fullscreen.vert", "edge_blend.frag")
    set_uniforms(program, u_edge_color=(*edges.color, edges.strength))
    bind({"u_coverage": target.coverage})
    fill_over(context, picture, program)


def _view_uniforms(camera: Camera, size: tuple[int, int]) -> dict[str, object]:
    """How places relative to an anchor near what is seen and pixels belong together."""
    eye = AnchoredCamera.of(camera)
    along, start = pixel_rays(camera, size)
    return {
        "u_origin": tuple(eye.anchor_ws),
        "u_rows": np.ascontiguousarray(eye.rows, np.float32).tobytes(),
        "u_w_rule": (1.0, 0.0) if camera.is_orthographic else (eye.depth.near, 1.0),
        "u_along_from_pixel": matrix_bytes(along),
        "u_start_from_pixel": matrix_bytes(start - eye.anchor_ws[:, None] * [0.0, 0.0, 1.0]),
        "u_pixel_m": 2.0 / float(camera.clip_from_view[1, 1]) / size[1],
        "u_is_parallel": camera.is_orthographic,
        "u_half_size": (0.5 * size[0], 0.5 * size[1]),
    }
