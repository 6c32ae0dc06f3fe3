"""A job under way, and what came of it. Every face of the add-on renders through a `Job`, so they agree bit by bit.

No bpy: `blender/sources.py` makes jobs from Blender's data.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from threading import Thread
from typing import TYPE_CHECKING, TypeVar

from ..errors import GpuError
from ..pipeline.frame import Frame
from ..pipeline.gl.machine import chosen
from ..pipeline.job import Job
from . import stopping
from .pending import Cancels, Pending, PendingFuture, Progress, waited
from .report import report_of

if TYPE_CHECKING:
    from ..pipeline.remote.renderer import RemoteRenderer
    from ..pipeline.renderer import Renderer, Task


_ADDON = __package__.removesuffix(".studies")
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Outcome:
    """A job done: its frame, and the report (a dictionary, made on first use)."""

    job: Job
    frame: Frame

    @cached_property
    def report(self) -> dict[str, object]:
        """The report JSON as a dictionary."""
        return report_of(self.job, self.frame)


def _pipeline() -> Callable[[], Renderer | RemoteRenderer]:
    """What gives the shared renderer. Loaded with the first picture, so that enabling the add-on stays quick."""
    try:
        from ..pipeline.renderer import shared_renderer

        if chosen().is_separate:
            from ..pipeline.remote.renderer import shared_remote as shared_renderer
    except ImportError as error:
        raise GpuError(f"A library is missing ({error}): install the extension from its zip, which brings all of them.") from error
    return shared_renderer


def renderer() -> Renderer | RemoteRenderer:
    """What draws pictures: on the worker of this process, or in a process of its own, as the machine is to be used."""
    return _pipeline()()


def submit_task(task: Task, job: Job, *arguments: object) -> Pending[object]:
    """Ask for a task of the renderer about the job. Raises `GpuError` when a library is missing."""
    future, ticket = renderer().submit(job, task, *arguments)
    return PendingFuture(future, lambda: (ticket.fraction, ticket.stage), ticket.give_up)


_importing: list[Thread] = []


def libraries_ready() -> bool:
    """True when a job need not wait for what renders to be imported. The first call begins the import, on a thread of its own.

    True also after an import that failed: the job that is asked for then says why.
    """
    module = sys.modules.get(f"{_ADDON}.pipeline.renderer")
    if hasattr(module, "shared_renderer"):  # its last line: it is complete
        return True
    if not _importing:
        _importing.append(Thread(target=_import_quietly, name="cad-shadow-import", daemon=True))
        _importing[0].start()
    return not _importing[0].is_alive()


def _import_quietly() -> None:
    with suppress(GpuError):
        _pipeline()


def on_worker(work: Callable[[], T]) -> Future[T]:
    """Queue work without OpenGL on the worker, between the pictures: what takes long and may use any thread."""
    _pipeline()
    from ..pipeline.gl.context import shared_worker

    return shared_worker().submit_plain(work)


def submit(job: Job, on: Renderer | RemoteRenderer | None = None) -> Pending[Outcome]:
    """Ask for the job's picture, of the shared renderer or `on` another. Raises `GpuError` when a library is missing.

    The result raises `SceneError`, `SettingsError`, `GpuError`, `Cancelled`.
    """
    future, ticket = (on or renderer()).submit(job)
    return PendingFuture(future, lambda: (ticket.fraction, ticket.stage), ticket.give_up, lambda frame: Outcome(job, frame))


def run(
    job: Job, progress: Progress | None = None, cancelled: Cancels | None = None, on: Renderer | RemoteRenderer | None = None
) -> Outcome:
    """`submit` and wait for it. Callable from any thread but the worker's.

    `progress(fraction, stage)` and `cancelled()` are called on the waiting thread.
    """
    return waited(submit(job, on), progress, lambda: stopping.is_asked() or (cancelled is not None and cancelled()))


def stop_worker() -> None:
    """Stop the GL thread (and the rendering process) and free all GL objects, if anything was ever rendered. A later job starts anew."""
    for name in ("gl.context", "remote.renderer"):
        module = sys.modules.get(f"{_ADDON}.pipeline.{name}")
        if module is not None:
            module.shutdown()
