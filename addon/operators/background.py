"""Operators that render: without blocking the window when a user presses the button, blocking when a script calls them."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from threading import Thread
from typing import TYPE_CHECKING
from weakref import WeakSet

import bpy

from ..blender import image_editor, session, sources
from ..blender.redraw import redraw
from ..errors import Cancelled, UserError
from ..studies.pending import Cancels, Chained, Pending, PendingFuture, Progress
from ..studies.run import Outcome, submit
from .ticking import Ticking, refused, say, takes_operators

if TYPE_CHECKING:
    import numpy as np


WORK_THREAD = "cad-shadow-work"
_at_work: WeakSet[OnThread] = WeakSet()


def end_threads(timeout_s: float = 10.0) -> None:
    """Give up all work on threads of its own, and wait for it to end."""
    working, deadline = list(_at_work), time.monotonic() + timeout_s
    for work in working:
        work.cancel()
    for work in working:
        work.thread.join(max(deadline - time.monotonic(), 0.0))


class NeedsMeshes:
    """Mix-in: grey while there is nothing to draw."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Grey with a reason when there is nothing to draw."""
        if not any(o.type in sources.DRAWN_TYPES for o in context.view_layer.objects):
            cls.poll_message_set("The scene has no mesh to draw: add or import one (File > Import > CAD)")
            return False
        return True


def view_read(
    context: bpy.types.Context,
    ask: Callable[[sources.ViewReading], Pending] | None = None,
    reading: sources.ViewReading | None = None,
) -> Pending:
    """A picture of what the user looks at, from reading the scene on, which takes slices of Blender's time; on the main thread.

    `ask(reading)` asks for something else than the picture, once the scene is read; it may raise `UserError`. `reading` reads something
    else than the view.
    """
    reading = reading or sources.ViewReading()
    reading.collect(context, sources.SLICE_S)
    return Chained(reading, ask or (lambda reading: submit(reading.job(bpy.context))))


class OnThread(PendingFuture):
    """Work on a thread of its own: `work(say, is_given_up)` may tell `say(fraction, stage)` how far it is and asks `is_given_up()` now
    and then. It must not touch Blender.

    The thread is a daemon: Python does not wait for it at its end, as it does for those of an executor.
    """

    def __init__(self, work: Callable[[Progress, Cancels], object]) -> None:
        self._said, self._is_given_up = (0.0, ""), False
        super().__init__(Future(), lambda: self._said, self._note_given_up)
        self._future.set_running_or_notify_cancel()  # the thread begins at once: nothing is left to cancel
        self.thread = Thread(target=self._run, args=(work,), name=WORK_THREAD, daemon=True)
        _at_work.add(self)
        self.thread.start()

    def _run(self, work: Callable[[Progress, Cancels], object]) -> None:
        try:
            self._future.set_result(work(self._say, lambda: self._is_given_up))
        except BaseException as error:  # handed to the one who takes the result
            self._future.set_exception(error)

    def _say(self, fraction: float, stage: str) -> None:
        self._said = (fraction, stage)

    def _note_given_up(self) -> None:
        self._is_given_up = True


def on_thread(context: bpy.types.Context, work: Callable[..., object], *more: object) -> Pending:
    """Have the view read, then `work(job, *more, say, is_given_up)` done on a thread of its own."""
    return view_read(context, lambda reading: OnThread(partial(work, reading.job(bpy.context), *more)))


class JobOperator(Ticking, NeedsMeshes):
    """Mix-in: makes a job of the current view, runs it, remembers the outcome, and calls `finish(context, outcome)`.

    Whoever asks for something else than one picture has a `start` and a `take` of their own.
    """

    def start(self, context: bpy.types.Context) -> Pending:
        """Ask the worker; raises `UserError`."""
        return view_read(context)

    def take(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Use what `start` asked for."""
        session.remember(outcome, context.scene)
        for warning in outcome.report["warnings"]:
            self.report({"WARNING"}, warning)
        self.finish(context, outcome)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Render and wait."""
        try:
            return self._done(context, self.start(context).result())
        except UserError as error:
            return refused(self, error)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Start rendering and return to the window at once."""
        if not takes_operators(context.window):
            return JobOperator.execute(self, context)
        try:
            self._pending = self.start(context)
        except UserError as error:
            return refused(self, error)
        return self.begin(context)

    def tick(self, context: bpy.types.Context) -> set[str] | None:
        """Watch the worker."""
        if not self._pending.done():
            fraction, stage = self._pending.progress
            context.window_manager.progress_update(100 * fraction)
            say(context, f"{self.bl_label}: {stage}, {fraction:.0%} · Esc stops")
            return None
        try:
            return self._done(context, self._pending.result())
        except Cancelled:
            return {"CANCELLED"}
        except UserError as error:
            return refused(self, error)

    def give_up(self, _context: bpy.types.Context) -> None:
        """Tell the worker."""
        self._pending.cancel()

    def _done(self, context: bpy.types.Context, result: object) -> set[str]:
        self.take(context, result)
        redraw(context)
        return {"FINISHED"}


class PictureOperator(JobOperator):
    """Mix-in: the operator's `work(job, say, is_given_up)` makes of the view an outcome and a data picture as an editor holds it, which is
    shown under the operator's `title`. The outcome is remembered: the Quality panel lists its numbers.
    """

    def start(self, context: bpy.types.Context) -> Pending:
        """Have the view read, then the work done."""
        return on_thread(context, self.work)

    def take(self, context: bpy.types.Context, result: tuple[Outcome, np.ndarray]) -> None:
        """Show the picture."""
        outcome, picture = result
        super().take(context, outcome)
        image_editor.show(context, image_editor.to_image(picture, f"{image_editor.NAME}: {self.title}", is_data=True))
