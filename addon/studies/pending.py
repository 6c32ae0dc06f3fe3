"""Work under way: one protocol for what is asked for, watched, given up and taken, and what makes such work of futures and of steps.

No bpy, no OpenGL: who makes the work says where it is done.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from typing import Generic, Protocol, TypeVar

from ..errors import Cancelled, UserError

Progress = Callable[[float, str], None]
Cancels = Callable[[], bool]
POLL_S = 0.05
T = TypeVar("T")
Result = TypeVar("Result", covariant=True)


class Pending(Protocol[Result]):
    """Work under way. Every method returns at once, except `result` before it is `done`."""

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the stage it is in."""

    def done(self) -> bool:
        """True when `result` will not wait."""

    def cancel(self) -> None:
        """Give it up."""

    def result(self, timeout_s: float | None = None) -> Result:
        """What came of it. Raises what the work raised, `Cancelled`, or `TimeoutError` when it is not done in time."""


class PendingFuture(Generic[T]):
    """What a future stands for, or what `made` makes of its result. `give_up()` tells work that has begun already."""

    def __init__(
        self,
        future: Future,
        progress: Callable[[], tuple[float, str]],
        give_up: Callable[[], None] | None = None,
        made: Callable[[object], T] | None = None,
    ) -> None:
        self._future, self._progress, self._give_up, self._made = future, progress, give_up, made

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the stage it is in."""
        return self._progress()

    def done(self) -> bool:
        """True when `result` will not wait."""
        return self._future.done()

    def cancel(self) -> None:
        """Give it up: at once when it is still queued, else where it next asks."""
        if self._give_up is not None:
            self._give_up()
        self._future.cancel()

    def result(self, timeout_s: float | None = None) -> T:
        """What came of it."""
        try:
            found = self._future.result(timeout_s)
        except CancelledError:
            raise Cancelled("Cancelled.") from None
        return found if self._made is None else self._made(found)


def ready(result: T) -> Pending[T]:
    """What is there at once."""
    future: Future[T] = Future()
    future.set_result(result)
    return PendingFuture(future, lambda: (1.0, ""))


class Chained(Generic[T]):
    """One piece of work, then another made of its result: `then(result)`, called by the first `done` or `result` after the first piece.

    A `UserError` on the way is kept for `result`.
    """

    def __init__(self, first: Pending, then: Callable[[object], Pending[T]]) -> None:
        self._first, self._then = first, then
        self._second: Pending[T] | None = None
        self._error: UserError | None = None

    @property
    def progress(self) -> tuple[float, str]:
        """That of the piece it is at."""
        return (self._second or self._first).progress

    def done(self) -> bool:
        """True when `result` will not wait."""
        self._go_on(waits=False)
        return self._error is not None or (self._second is not None and self._second.done())

    def cancel(self) -> None:
        """Give up the piece it is at."""
        (self._second or self._first).cancel()

    def result(self, timeout_s: float | None = None) -> T:
        """What came of the second piece; `timeout_s` holds for that one."""
        self._go_on(waits=True)
        if self._error is not None:
            raise self._error
        return self._second.result(timeout_s)

    def _go_on(self, waits: bool) -> None:
        """Begin the second piece, once, when the first is done or may be waited for."""
        if self._second is not None or self._error is not None:
            return
        try:
            if waits or self._first.done():
                self._second = self._then(self._first.result())
        except UserError as error:
            self._error = error


def waited(pending: Pending[T], progress: Progress | None = None, cancelled: Cancels | None = None) -> T:
    """Wait for work, on the waiting thread calling `progress(fraction, stage)` and `cancelled()` now and then. Raises as `result` does."""
    while True:
        try:
            return pending.result(POLL_S)
        except TimeoutError:
            if pending.done():
                return pending.result()
        if progress:
            progress(*pending.progress)
        if cancelled and cancelled():
            pending.cancel()
