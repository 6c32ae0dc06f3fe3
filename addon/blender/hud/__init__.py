"""What is drawn over a 3D viewport in pixels: the live view's legend, and the graph of the error; and their switches.

The lines in the scene are `map_overlay.py`'s.
"""

from __future__ import annotations

import bpy

from .. import viewport
from ..redraw import on_change
from . import graph, legend
from .canvas import Canvas, free_box

_handlers: list[object] = []


def _draw() -> None:
    """Blender calls this for every 3D viewport, after everything else in it."""
    context = bpy.context
    if not context.space_data.overlay.show_overlays:
        return
    canvas = Canvas(free_box(context.area, context.region), context.preferences.system.ui_scale)
    manager = context.window_manager
    live = viewport.live_view_in(context.region) if manager.cad_shadow_legend and viewport.is_live(context) else None
    if live is not None:
        legend.draw(canvas, live)
    if manager.cad_shadow_graph:
        graph.draw(canvas)


def draw_switches(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """The add-on's part of the Overlays popover."""
    manager, column = context.window_manager, self.layout.column()
    column.separator()
    column.label(text="CAD Shadow")
    column.row().prop(manager, "cad_shadow_overlay", expand=True)
    row = column.row()
    row.prop(manager, "cad_shadow_graph")
    row.prop(manager, "cad_shadow_legend")


def register() -> None:
    """Offer the switches and, where there are windows, draw."""
    manager = bpy.types.WindowManager
    manager.cad_shadow_legend = bpy.props.BoolProperty(
        name="Legend", description="What the colours of a live view that shows Aliasing or Partitions mean", default=True, update=on_change
    )
    manager.cad_shadow_graph = bpy.props.BoolProperty(
        name="Error Graph",
        description="The error m over view depth, of the last preview or analysis: what the theory predicts for each map (coloured lines, "
        "T4 (25), (19)), what the picture has (white: median and 95 % of the pixels), and where the maps meet",
        update=on_change,
    )
    bpy.types.VIEW3D_PT_overlay.append(draw_switches)
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Stop drawing, take the switches back."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    bpy.types.VIEW3D_PT_overlay.remove(draw_switches)
    graph.clear()
    legend.clear()
    del bpy.types.WindowManager.cad_shadow_legend
    del bpy.types.WindowManager.cad_shadow_graph
