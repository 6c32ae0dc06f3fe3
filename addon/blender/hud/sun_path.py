"""The sun's way over the sky at the scene's place and date, drawn round what the viewport looks at, and where the sun stands now."""

from __future__ import annotations

from collections.abc import Hashable

import bpy
import numpy as np

from ...errors import SettingsError
from ...maths.sun import Clock, Place
from ...studies.sun.moments import moment
from ..redraw import on_change
from ..sun_properties import sky_of

PROPERTY = "cad_shadow_sun_path"
RADIUS = 0.3  # of the view's distance
PATH, HOUR, NOW = (1.0, 0.72, 0.2, 0.9), (1.0, 0.85, 0.5, 0.7), (1.0, 0.55, 0.0, 1.0)
STEP_H, TICK = 0.25, 0.06
_handlers: list[object] = []
_known: list[tuple[Hashable, dict[str, np.ndarray]]] = []


def path_of(clock: Clock, place: Place, hours: float) -> dict[str, np.ndarray]:
    """Segments (S, 2, 3) on the unit sphere round the viewer: 'path' over the horizon, 'hours' ticks across it, and 'now', a ray."""
    times = np.arange(0.0, 24.0 + STEP_H / 2, STEP_H)
    day = [moment(clock, place, float(time)) for time in times]
    points, up = np.array([m.direction_ws for m in day]), np.array([m.is_up for m in day])
    both = up[:-1] & up[1:]
    path = np.stack([points[:-1], points[1:]], axis=1)[both]
    whole = up & (np.mod(times, 1.0) == 0.0)
    ticks = np.stack([points[whole] * (1.0 - TICK), points[whole] * (1.0 + TICK)], axis=1)
    now = moment(clock, place, hours)
    ray = np.array([[np.zeros(3), now.direction_ws]]) if now.is_up else np.empty((0, 2, 3))
    return {"path": path, "hours": ticks, "now": ray}


def _segments(scene: bpy.types.Scene) -> dict[str, np.ndarray]:
    """Of the scene's date; reckoned anew when place or time change. Nothing for a date that does not exist."""
    props = scene.cad_shadow.sun
    try:
        clock, place = sky_of(props)
    except SettingsError:
        return {}
    key = clock, place, props.hours
    if not _known or _known[0][0] != key:
        _known[:] = [(key, path_of(clock, place, props.hours))]
    return _known[0][1]


def _draw() -> None:
    """Blender calls this for every 3D viewport, after the scene."""
    context = bpy.context
    if not getattr(context.window_manager, PROPERTY) or not context.space_data.overlay.show_overlays:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    rv3d, shader = context.region_data, gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    centre, radius = np.array(rv3d.view_location), RADIUS * rv3d.view_distance
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    scale = context.preferences.system.ui_scale
    for name, color, width in (("path", PATH, 2.0), ("hours", HOUR, 1.5), ("now", NOW, 3.0)):
        segments = _segments(context.scene).get(name, ())
        if len(segments):
            shader.uniform_float("lineWidth", width * scale)
            shader.uniform_float("color", color)
            places = (centre + radius * segments).reshape(-1, 3)
            batch_for_shader(shader, "LINES", {"pos": places.astype(np.float32).tolist()}).draw(shader)
    gpu.state.blend_set("NONE")


def register() -> None:
    """Offer the switch and, where there are windows, draw."""
    switch = bpy.props.BoolProperty(
        name="Sun Path",
        description="Draw the sun's way over the sky on this day round what you look at, a tick for every hour, and where it stands now",
        update=on_change,
    )
    setattr(bpy.types.WindowManager, PROPERTY, switch)
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    """Stop drawing, take the switch back."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    _known.clear()
    delattr(bpy.types.WindowManager, PROPERTY)
