"""What operators that work on a timer have in common: they start, are looked after at every tick, and end or are given up."""

from __future__ import annotations

import bpy

_running: list[Ticking] = []


def end_all(context: bpy.types.Context) -> None:
    """Give up every operator that is still at work: Blender drops those of a class that it unregisters without a word to them."""
    for operator in list(_running):
        operator.cancel(context)


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
        _running.remove(self)
        context.window_manager.progress_end()
        context.window_manager.event_timer_remove(self._timer)
