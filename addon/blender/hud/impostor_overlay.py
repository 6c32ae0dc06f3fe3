"""The viewport overlay of impostors: the quads of their textures and the critical points, of the last picture.

A point is where the predicted warping error begins: the near texel of the pair with the largest step in depth of each region (RI §5.6).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...studies.impostors.states import critical_places, quad_corners
from .. import session
from ..redraw import on_change

if TYPE_CHECKING:
    from ...pipeline.frame import ImpostorReport

PROPERTY = "cad_shadow_impostor_points"
POINT_PX, LINE_PX = 9.0, 1.5
COLORS = {"sprite": (0.4, 0.8, 0.4), "warp": (0.3, 0.6, 1.0), "regenerated": (1.0, 0.8, 0.2), "geometry": (0.6, 0.6, 0.6)}
POINT_COLOR, RIM_COLOR = (1.0, 0.2, 0.1, 1.0), (0.0, 0.0, 0.0, 1.0)
_handlers: list[object] = []


def shapes(reports: tuple[ImpostorReport, ...], origin_ws: np.ndarray) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """((P, 3) critical points, (stage, (4, 2, 3) segments of the quad) per texture) in true world coordinates."""
    with_texture = [report for report in reports if report.edges is not None]
    points = [critical_places(report.edges)[1] + origin_ws for report in with_texture]
    quads = []
    for report in with_texture:
        corners = quad_corners(report.edges) + origin_ws
        quads.append((report.stage, np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)))
    return np.concatenate([np.empty((0, 3)), *points]), quads


def _draw() -> None:
    """Blender calls this for every 3D viewport, after the scene."""
    if not getattr(bpy.context.window_manager, PROPERTY) or not bpy.context.space_data.overlay.show_overlays:
        return
    points, quads = shapes(session.impostors(), session.impostor_origin())
    if not len(quads):
        return
    import gpu

    gpu.state.blend_set("ALPHA")
    for stage, segments in quads:
        _batch("POLYLINE_UNIFORM_COLOR", "LINES", segments.reshape(-1, 3), (*COLORS.get(stage, COLORS["geometry"]), 0.8), LINE_PX)
    for size, color in ((POINT_PX + 3.0, RIM_COLOR), (POINT_PX, POINT_COLOR)):
        gpu.state.point_size_set(size * bpy.context.preferences.system.ui_scale)
        _batch("UNIFORM_COLOR", "POINTS", points, color)
    gpu.state.point_size_set(1.0)
    gpu.state.blend_set("NONE")


def _batch(shader_name: str, kind: str, points: np.ndarray, color: tuple[float, float, float, float], width: float = 0.0) -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    if not len(points):
        return
    shader = gpu.shader.from_builtin(shader_name)
    batch = batch_for_shader(shader, kind, {"pos": points.astype(np.float32).tolist()})
    shader.bind()
    shader.uniform_float("color", color)
    if width:
        shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        shader.uniform_float("lineWidth", width)
    batch.draw(shader)


def draw_switch(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """The part of the Overlays popover."""
    self.layout.prop(context.window_manager, PROPERTY)


def register() -> None:
    """Offer the switch and, where there are windows, draw."""
    switch = bpy.props.BoolProperty(
        name="Critical Points",
        description="Draw the quads of the impostors' textures and their critical points, where the warping error begins, "
        "as of the last picture",
        update=on_change,
    )
    setattr(bpy.types.WindowManager, PROPERTY, switch)
    bpy.types.VIEW3D_PT_overlay.append(draw_switch)
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    """Stop drawing, take the switch back."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    bpy.types.VIEW3D_PT_overlay.remove(draw_switch)
    delattr(bpy.types.WindowManager, PROPERTY)
