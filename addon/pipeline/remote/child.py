"""The process that `renderer.RemoteRenderer` starts: `python -m addon.pipeline.remote.child PEER` renders what it is sent until there is
no more; PEER is what the package is called in the process that sends."""

from __future__ import annotations

import os
import sys
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from dataclasses import replace
from threading import Lock
from typing import BinaryIO

from ...errors import Cancelled, GpuError, UserError
from ...scene.records import Mesh, Scene
from ..gl import machine
from ..gl.context import shutdown
from ..job import Job
from ..renderer import Task, Ticket, shared_renderer
from .words import receive, send


class _ReportingTicket(Ticket):
    """A ticket that sends every stage to the other process."""

    def __init__(self, report: object) -> None:
        super().__init__()
        self._report = report

    def enter(self, fraction: float, stage: str) -> None:
        """Note the stage and send it."""
        super().enter(fraction, stage)
        self._report("progress", (fraction, stage))


class Server:
    """Holds the last scene sent and the frames under way."""

    def __init__(self, out: BinaryIO) -> None:
        self._out, self._lock = out, Lock()
        self._current: Scene | None = None
        self._meshes: dict[object, Mesh] = {}
        self._tickets: dict[int, Ticket] = {}

    def take(self, message: tuple) -> None:
        """Do what one message asks."""
        getattr(self, f"_{message[0]}")(*message[1:])

    def _machine(self, chosen: machine.Machine) -> None:
        machine.choose(chosen)

    def _scene(self, scene: Scene, keys: list, new: tuple[Mesh, ...]) -> None:
        known = self._meshes | {mesh.key: mesh for mesh in new}
        self._meshes = {key: known[key] for key in keys}
        self._current = replace(scene, meshes=tuple(known[key] for key in keys))

    def _cancel(self, number: int) -> None:
        ticket = self._tickets.get(number)
        if ticket is not None:
            ticket.is_cancelled = True

    def _render(self, number: int, job: Job, task: Task, arguments: tuple) -> None:
        ticket = self._tickets[number] = _ReportingTicket(lambda kind, content: self._report(number, kind, content))
        future = shared_renderer().queue(replace(job, scene=self._current), ticket, task, *arguments)
        future.add_done_callback(lambda done: self._answer(number, done))

    def _answer(self, number: int, done: Future) -> None:
        self._tickets.pop(number, None)
        try:
            self._report(number, "done", done.result())
        except CancelledError:
            self._report(number, "failed", Cancelled("Cancelled."))
        except UserError as error:
            self._report(number, "failed", error)
        except Exception as error:  # must reach the one who waits
            self._report(number, "failed", GpuError(f"Rendering failed ({type(error).__name__}: {error}): please report this."))

    def _report(self, number: int, kind: str, content: object) -> None:
        with self._lock, suppress(OSError):  # nobody reads any more; Windows does not call it a broken pipe
            send(self._out, (number, kind, content))


def main(peer: str) -> None:
    """Serve until standard input ends. Standard output is for messages alone: what drivers print goes to standard error."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    server = Server(out)
    while (message := receive(sys.stdin.buffer, peer, takes_tasks=True)) is not None:
        server.take(message)
    shutdown()
    with suppress(OSError):  # the last answer, where nobody reads it
        out.close()


if __name__ == "__main__":
    main(sys.argv[1])
