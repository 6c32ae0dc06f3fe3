"""What operators that work on a timer have in common: they start, are looked after at every tick, and end or are given up."""

from __future__ import annotations

import logging
from contextlib import suppress

import bpy

from ..errors import UserError

log = logging.getLogger(__name__)
_running: list[Ticking] = []


def end_all(context: bpy.types.Context) -> None:
    """Give up every operator that is still at work: Blender drops those of a class that it unregisters without a word to them."""
    for operator in list(_running):
        with suppress(ReferenceError):  # Blender has freed it meanwhile
            operator.cancel(context)
    _running.clear()


def takes_operators(window: bpy.types.Window | None) -> bool:
    """Whether an operator may go on in this window.

    One whose class was unregistered keeps its empty place in the window's list until the next event there, and Blender crashes when
    another operator is put into the list before.
    """
    if window is None:
        return False
    try:
        return all(operator.bl_idname for operator in window.modal_operators)
    except ValueError:  # such an empty place
        return False


def say(context: bpy.types.Context, line: str | None) -> None:
    """A line in the status bar; None gives it back to Blender."""
    if context.workspace is not None:
        context.workspace.status_text_set(line)


def refused(operator: bpy.types.Operator, error: UserError) -> set[str]:
    """Tell the user why nothing came of it."""
    log.info("%s: %s", operator.bl_idname, error)
    operator.report({"ERROR"}, str(error))
    return {"CANCELLED"}


class Ticking:
    """Mix-in of a modal operator: `tick(context)` gives the result when all is over, None before; `give_up(context)` ends it early."""

    every_s = 0.05

    def begin(self, context: bpy.types.Context) -> set[str]:
        """Go on in the background: what `execute` or `invoke` returns."""
        self._timer = context.window_manager.event_timer_add(self.every_s, window=context.window)
        context.window_manager.progress_begin(0, 100)
        context.window_manager.modal_handler_add(self)
        _running.append(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Look after it; Esc gives up."""
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            result = self.tick(context)
        except Exception:
            self._release(context)
            raise
        if result is None:
            return {"RUNNING_MODAL"}
        self._release(context)
        return result

    def cancel(self, context: bpy.types.Context) -> None:
        """Esc, or Blender closes the window or the file while it runs."""
        self.give_up(context)
        self._release(context)

    def _release(self, context: bpy.types.Context) -> None:
        """Once, whatever Blender calls afterwards."""
        if self not in _running:
            return
        _running.remove(self)
        context.window_manager.progress_end()
        say(context, None)
        context.window_manager.event_timer_remove(self._timer)
