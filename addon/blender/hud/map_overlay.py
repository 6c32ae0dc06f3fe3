"""The viewport overlay: splits of the camera's view and volumes of the shadow maps, of the last preview or analysis, in the maps' colours.

The geometry is `studies/map_outlines.py`'s; here it is drawn after the scene. Blender's `gpu` module is there only when it has a window.
"""

from __future__ import annotations

from weakref import ReferenceType, ref

import bpy
import numpy as np

from ...studies.map_outlines import map_color, map_volumes, split_sections
from ...studies.run import Outcome
from .. import session
from ..redraw import on_change

PROPERTY = "cad_shadow_overlay"
LINE_WIDTH = 1.5
ITEMS = (
    ("OFF", "Off", "No overlay"),
    ("SPLITS", "Splits", "Where the camera's view is divided among the shadow maps"),
    ("MAPS", "Maps", "The volume that every shadow map covers"),
    ("BOTH", "Both", "Splits and maps"),
)
_handlers: list[object] = []
# Of what was drawn last: the outcome (by a weak reference, so that it is recognised and not kept), the wish, the batches.
_batches: list[tuple[ReferenceType[Outcome], str, list[tuple[tuple[float, float, float], object]]]] = []


def segments_of(outcome: Outcome, what: str) -> list[tuple[int, np.ndarray]]:
    """(map index, (S, 2, 3) segments) in true world coordinates of what is to be drawn; empty without shadow maps."""
    plan, job = outcome.frame.plan, outcome.job
    if plan is None:
        return []
    found = split_sections(job.camera, plan) if what in ("SPLITS", "BOTH") else []
    if what in ("MAPS", "BOTH"):
        found = found + map_volumes(plan)
    return [(index, segments + job.scene.origin_ws) for index, segments in found]


def _built(outcome: Outcome, what: str) -> list[tuple[tuple[float, float, float], object]]:
    """GPU batches, made anew only when there is a new outcome or another wish."""
    from gpu_extras.batch import batch_for_shader

    if not _batches or _batches[0][0]() is not outcome or _batches[0][1] != what:
        shader = _shader()
        made = [
            (map_color(index), batch_for_shader(shader, "LINES", {"pos": segments.reshape(-1, 3).astype(np.float32).tolist()}))
            for index, segments in segments_of(outcome, what)
        ]
        _batches[:] = [(ref(outcome), what, made)]
    return _batches[0][2]


def _shader() -> object:
    import gpu

    return gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")


def _draw() -> None:
    """Blender calls this for every 3D viewport, after the scene."""
    what, outcome = getattr(bpy.context.window_manager, PROPERTY), session.last()
    if what == "OFF" or outcome is None or not bpy.context.space_data.overlay.show_overlays:
        return
    import gpu

    batches, shader = _built(outcome, what), _shader()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", LINE_WIDTH)
    for color, batch in batches:
        shader.uniform_float("color", (*color, 0.9))
        batch.draw(shader)
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")


def register() -> None:
    """Offer the switch and, where there are windows, draw."""
    switch = bpy.props.EnumProperty(
        name="Overlay", description="Draw where the shadow maps of the last preview or analysis lie", items=ITEMS, update=on_change
    )
    setattr(bpy.types.WindowManager, PROPERTY, switch)
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    """Stop drawing, free the batches, take the switch back."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    _batches.clear()
    delattr(bpy.types.WindowManager, PROPERTY)
