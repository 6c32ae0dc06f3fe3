"""The renderer in a process of its own, for drivers that crash: what `pipeline/renderer.py` does, but a crash costs a message, not Blender.

A scene is sent once, and of its meshes only those that the other process does not have. Pictures come back whole.
"""

from __future__ import annotations

import itertools
import subprocess
from collections.abc import Callable, Hashable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import replace
from pickle import UnpicklingError
from queue import SimpleQueue
from threading import Lock, Thread
from typing import NamedTuple

from ...errors import Cancelled, GpuError
from ...scene.child_python import PEER, started
from ...scene.records import Scene
from ..gl.machine import Machine, chosen
from ..job import Job
from ..renderer import Task, Ticket, render_frame
from .words import PACKAGE, receive, send

CLOSE_S = 3.0  # the process may be killed: what it holds is its own


class RemoteTicket(Ticket):
    """A ticket whose cancelling is sent to the other process."""

    def __init__(self, cancel: Callable[[], None]) -> None:
        self._cancel, self._is_cancelled = cancel, False
        super().__init__()

    @property
    def is_cancelled(self) -> bool:
        """Whether the caller has given up."""
        return self._is_cancelled

    @is_cancelled.setter
    def is_cancelled(self, value: bool) -> None:
        if value and not self._is_cancelled:
            self._cancel()
        self._is_cancelled = value


class _Request(NamedTuple):
    """What the process is asked for; `again` asks another process for it."""

    future: Future
    ticket: Ticket
    again: Callable[[], None] | None


class _Child:
    """One process, with a thread that writes to it and one that reads from it. Ends when `close`d, or by itself."""

    def __init__(self, machine: Machine) -> None:
        streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self.process = started("pipeline.remote.child", [PACKAGE], ("moderngl", "glcontext", "numpy"), **streams)
        self.waiting: dict[int, _Request] = {}
        self.is_over = False
        self._is_closing = False
        self._outbox: SimpleQueue[tuple | None] = SimpleQueue()
        self._lock = Lock()
        self._scene: Scene | None = None
        self._keys: frozenset[Hashable] = frozenset()
        self._threads = [Thread(target=run, name=f"cad-shadow-{run.__name__}", daemon=True) for run in (self._write, self._read)]
        self.post(("machine", machine))
        for thread in self._threads:
            thread.start()

    def post(self, message: tuple | None) -> None:
        """Leave a message to be written; None closes."""
        self._outbox.put(message)

    def ask(self, number: int, asked: _Request, job: Job, task: Task, arguments: tuple) -> None:
        """Ask for a frame, or another task; the future gets its result, or the process's end as an error.

        What the process had not begun when it ended is no cause of that: `asked.again` is called.
        """
        with self._lock:
            is_over = self.is_over
            if not is_over:
                self.waiting[number] = asked
        if not is_over:
            self.post(("render", number, job, task, arguments))
        elif asked.again is not None:
            asked.again()
        else:
            asked.future.set_exception(GpuError("The rendering process has ended: try again."))

    def close(self, timeout_s: float = CLOSE_S) -> None:
        """End the process, which gives up what it is at, and the threads with it. One that does not end in time is killed."""
        self._is_closing = True
        self.post(None)
        try:
            self.process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.process.kill()
        for thread in self._threads:
            thread.join(timeout_s)

    def _write(self) -> None:
        with suppress(OSError):  # it has ended: `_read` says so
            while (message := self._outbox.get()) is not None:
                if message[0] == "render":
                    message = self._with_scene_sent(*message[1:])
                send(self.process.stdin, message)
        with suppress(OSError):
            self.process.stdin.close()

    def _with_scene_sent(self, number: int, job: Job, task: Task, arguments: tuple) -> tuple:
        """The message that asks for the task; its scene is sent before it, unless it was the last one sent."""
        scene = job.scene
        if scene is not self._scene:
            keys = [mesh.key for mesh in scene.meshes]
            new = tuple(mesh for mesh in scene.meshes if mesh.key not in self._keys)
            send(self.process.stdin, ("scene", replace(scene, meshes=()), keys, new))
            self._scene, self._keys = scene, frozenset(keys)
        return "render", number, replace(job, scene=None), task, arguments

    def _read(self) -> None:
        try:
            with suppress(OSError, EOFError):  # it has ended
                while (message := receive(self.process.stdout, PEER)) is not None:
                    self._take(*message)
        except UnpicklingError:  # it says what no message may
            self.process.kill()
        self.process.stdout.close()
        code = self.process.wait()
        with self._lock:
            self.is_over = True
            lost, self.waiting = self.waiting, {}
        error = GpuError(f"The rendering process ended unexpectedly (exit code {code}): update the graphics driver.")
        for asked in lost.values():
            if asked.again is not None and asked.ticket.stage == Ticket.stage and not self._is_closing:
                asked.again()
            else:
                _settle(asked.future, Cancelled("Cancelled.") if self._is_closing else error)
        self.post(None)

    def _take(self, number: int, kind: str, content: object) -> None:
        future, ticket, _ = self.waiting[number]
        if kind == "progress":
            ticket.fraction, ticket.stage = content
            return
        with self._lock:
            del self.waiting[number]
        _settle(future, content)


def _settle(future: Future, content: object) -> None:
    with suppress(InvalidStateError):  # the caller has given up meanwhile
        if isinstance(content, Exception):
            future.set_exception(content)
        else:
            future.set_result(content)


class RemoteRenderer:
    """Starts the process with the first frame asked for, and another one when it has ended."""

    def __init__(self) -> None:
        self._child: _Child | None = None
        self._numbers, self._lock = itertools.count(), Lock()

    def submit(self, job: Job, task: Task | None = None, *arguments: object) -> tuple[Future, Ticket]:
        """Queue a frame, or another task; as `Renderer.submit`."""
        child, number, future = self._living(), next(self._numbers), Future()
        ticket = RemoteTicket(lambda: self._cancel(number))

        def again() -> None:
            self._living().ask(number, _Request(future, ticket, None), job, task or render_frame, arguments)

        child.ask(number, _Request(future, ticket, again), job, task or render_frame, arguments)
        return future, ticket

    def _living(self) -> _Child:
        with self._lock:
            if self._child is None or self._child.is_over:
                self._child = _Child(chosen())
            return self._child

    def _cancel(self, number: int) -> None:
        """Whichever process is at it."""
        child = self._child
        if child is not None:
            child.post(("cancel", number))

    def close(self) -> None:
        """End the process; a later frame starts another."""
        child, self._child = self._child, None
        if child is not None:
            child.close()


_renderer = RemoteRenderer()


def shared_remote() -> RemoteRenderer:
    """The add-on's renderer in a process of its own."""
    return _renderer


def shutdown() -> None:
    """End its process, if there is one."""
    _renderer.close()
