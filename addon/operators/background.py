"""Operators that render: without blocking the window when a user presses the button, blocking when a script calls them."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from threading import Thread
from typing import TYPE_CHECKING, Protocol
from weakref import WeakSet

import bpy

from ..blender import image_editor, session, sources
from ..blender.redraw import redraw
from ..errors import Cancelled, UserError
from ..studies.run import Cancels, Outcome, Pending, Progress
from .ticking import Ticking, takes_operators

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


class Asked(Protocol):
    """Work under way on the worker, as `Pending` is; `result` is what `JobOperator.take` gets."""

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the stage it is in."""

    def done(self) -> bool:
        """True when `result` will not wait."""

    def cancel(self) -> None:
        """Give it up."""

    def result(self) -> object:
        """What came of it; raises `UserError`."""


class PendingView:
    """A picture of what the user looks at, from reading the scene on; it is asked as `Pending` is, on the main thread.

    `ask(reading)` asks for something else than the picture, once the scene is read; it may raise `UserError`. `reading` reads something
    else than the view. Each `done` takes at most a slice of Blender's time.
    """

    def __init__(
        self,
        context: bpy.types.Context,
        ask: Callable[[sources.ViewReading], Asked] | None = None,
        reading: sources.ViewReading | None = None,
    ) -> None:
        self._ask_for = ask or (lambda reading: Pending(reading.job(bpy.context)))
        self._reading = reading or sources.ViewReading()
        self._reading.collect(context, sources.SLICE_S)
        self._pending: Asked | None = None
        self._error: UserError | None = None

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the stage it is in."""
        return self._pending.progress if self._pending is not None else (0.0, "reading the scene")

    def done(self) -> bool:
        """True when `result` will not wait. Goes on reading; asks for the picture when the scene has been read."""
        if self._pending is None and self._error is None and self._is_read():
            self._ask()
        return self._error is not None or (self._pending is not None and self._pending.done())

    def cancel(self) -> None:
        """Give it up."""
        if self._pending is not None:
            self._pending.cancel()
        else:
            self._reading.cancel()

    def result(self) -> object:
        """The outcome, or what was asked for instead; raises what reading and rendering raise."""
        if self._pending is None and self._error is None:
            self._ask()
        if self._error is not None:
            raise self._error
        return self._pending.result()

    def _is_read(self) -> bool:
        try:
            return self._reading.collect(bpy.context, sources.SLICE_S) and self._reading.done()
        except UserError as error:
            self._error = error
            return False

    def _ask(self) -> None:
        try:
            self._pending = self._ask_for(self._reading)
        except UserError as error:
            self._error = error


class Ready:
    """What is there at once, asked as `Pending` is."""

    progress = (1.0, "")

    def __init__(self, result: object) -> None:
        self._result = result

    def done(self) -> bool:
        """Always."""
        return True

    def cancel(self) -> None:
        """Nothing to give up."""

    def result(self) -> object:
        """What it was made with."""
        return self._result


class OnThread:
    """Work on a thread of its own, asked as `Pending` is: `work(say, is_given_up)` may tell `say(fraction, stage)` how far it is and asks
    `is_given_up()` now and then. It must not touch Blender.

    The thread is a daemon: Python does not wait for it at its end, as it does for those of an executor.
    """

    def __init__(self, work: Callable[[Progress, Cancels], object]) -> None:
        self.progress = (0.0, "")
        self._is_given_up = False
        self._future: Future[object] = Future()
        self.thread = Thread(target=self._run, args=(work,), name=WORK_THREAD, daemon=True)
        _at_work.add(self)
        self.thread.start()

    def _run(self, work: Callable[[Progress, Cancels], object]) -> None:
        try:
            self._future.set_result(work(self._say, lambda: self._is_given_up))
        except BaseException as error:  # handed to the one who takes the result
            self._future.set_exception(error)

    def _say(self, fraction: float, stage: str) -> None:
        self.progress = (fraction, stage)

    def done(self) -> bool:
        """True when `result` will not wait."""
        return self._future.done()

    def cancel(self) -> None:
        """Give it up where the work next asks."""
        self._is_given_up = True

    def result(self) -> object:
        """What came of it; raises what it raised."""
        return self._future.result()


def on_thread(context: bpy.types.Context, work: Callable[..., object], *more: object) -> PendingView:
    """Have the view read, then `work(job, *more, say, is_given_up)` done on a thread of its own."""
    return PendingView(context, lambda reading: OnThread(partial(work, reading.job(bpy.context), *more)))


class JobOperator(Ticking, NeedsMeshes):
    """Mix-in: makes a job of the current view, runs it, remembers the outcome, and calls `finish(context, outcome)`.

    Whoever asks for something else than one picture has a `start` and a `take` of their own.
    """

    def start(self, context: bpy.types.Context) -> PendingView:
        """Ask the worker; raises `UserError`."""
        return PendingView(context)

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
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Start rendering and return to the window at once."""
        if not takes_operators(context.window):
            return JobOperator.execute(self, context)
        try:
            self._pending = self.start(context)
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self.begin(context)

    def tick(self, context: bpy.types.Context) -> set[str] | None:
        """Watch the worker."""
        if not self._pending.done():
            context.window_manager.progress_update(100 * self._pending.progress[0])
            return None
        try:
            return self._done(context, self._pending.result())
        except Cancelled:
            return {"CANCELLED"}
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

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

    def start(self, context: bpy.types.Context) -> PendingView:
        """Have the view read, then the work done."""
        return on_thread(context, self.work)

    def take(self, context: bpy.types.Context, result: tuple[Outcome, np.ndarray]) -> None:
        """Show the picture."""
        outcome, picture = result
        super().take(context, outcome)
        image_editor.show(context, image_editor.to_image(picture, f"{image_editor.NAME}: {self.title}", is_data=True))
