"""Have Blender draw its areas again."""

from __future__ import annotations

import bpy


def redraw(context: bpy.types.Context) -> None:
    """Every area of every window, soon; without windows nothing."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()


def on_change(_self: object, context: bpy.types.Context) -> None:
    """`redraw` as the update of a property that areas show."""
    redraw(context)
