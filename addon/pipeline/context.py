"""The one OpenGL context and the one thread that owns it. Nothing else in the program creates, uses or releases GL objects.

Facts behind the design (measured, `../shared/research/gui.md`): a context made on Blender's main thread draws in Blender's own context,
corrupts the viewport or crashes; a dedicated thread that keeps one context never did. Jobs and arrays pass through a queue; the caller may
wait (the wait releases the GIL) or keep the future.
"""

from __future__ import annotations

import atexit
import gc
import os
import queue
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import TypeVar

import moderngl

from ..errors import Cancelled, GpuError
from .machine import chosen

T = TypeVar("T")
THREAD_NAME = "cad-shadow-gl"
REQUIRED_GL = 330
POLL_S = 0.05

_LINUX_HINT = (
    "install Mesa's EGL libraries (Debian/Ubuntu: apt install libegl1 libgl1 libgl1-mesa-dri libegl-mesa0; "
    "Fedora: dnf install mesa-libEGL mesa-dri-drivers)"
)
_OTHER_HINT = "update the graphics driver; OpenGL 3.3 or newer is needed"


def create_context(backend: str = "auto") -> moderngl.Context:
    """A standalone OpenGL ≥ 3.3 context; EGL first on Linux. Raises `GpuError` naming what is missing and how to get it."""
    if backend == "auto":
        choices = ["egl", None] if sys.platform.startswith("linux") else [None]
    else:
        choices = [None if backend == "native" else backend]
    if chosen().threads:
        os.environ["LP_NUM_THREADS"] = str(chosen().threads)  # Mesa's software driver reads it when a context is made
    failures = []
    for choice in choices:
        try:
            options = {"backend": choice} if choice else {}
            context = moderngl.create_context(standalone=True, require=REQUIRED_GL, **options)
        except Exception as error:  # glcontext raises bare Exception for every failure of the driver
            failures.append(f"{choice or 'native'}: {' '.join(str(error).split())}")
            continue
        context.gc_mode = "context_gc"
        return context
    hint = _LINUX_HINT if sys.platform.startswith("linux") else _OTHER_HINT
    raise GpuError(f"No OpenGL 3.3 context could be made ({'; '.join(failures)}): {hint}.")


class GpuWorker:
    """A thread that owns a context. `submit` queues a job, `call` also waits for it; both work from any thread but the worker's own.

    The thread starts with the first job and lives until `close`; the context is made by the first job that needs it.
    """

    def __init__(self, backend: str = "auto") -> None:
        self._backend = backend
        self._jobs: queue.SimpleQueue[tuple[Future, Callable, bool] | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()
        self._at_close: list[Callable[[], None]] = []

    @property
    def is_running(self) -> bool:
        """True while the thread lives."""
        return self._thread is not None and self._thread.is_alive()

    def submit(self, job: Callable[[moderngl.Context], T]) -> Future[T]:
        """Queue `job(context)`; its result or error comes through the future. A future cancelled before its turn is never run."""
        return self._queue(job, True)

    def submit_plain(self, job: Callable[[], T]) -> Future[T]:
        """Queue work that needs no OpenGL, as `submit` does; no context is made for it."""
        return self._queue(lambda _context: job(), False)

    def _queue(self, job: Callable[[moderngl.Context | None], T], needs_context: bool) -> Future[T]:
        future: Future[T] = Future()
        with self._lock:
            if not self.is_running:
                self._thread = threading.Thread(target=self._run, name=THREAD_NAME, daemon=True)
                self._thread.start()
            self._jobs.put((future, job, needs_context))
        return future

    def call(self, job: Callable[[moderngl.Context], T], cancelled: Callable[[], bool] | None = None) -> T:
        """Run `job(context)` on the worker and wait. `cancelled` is asked on the calling thread; True gives up with `Cancelled`."""
        if threading.current_thread() is self._thread:
            raise RuntimeError("GpuWorker.call from the worker itself would wait for ever")
        future = self.submit(job)
        while True:
            try:
                return future.result(timeout=POLL_S if cancelled else None)
            except FutureTimeoutError:
                if future.done():
                    return future.result()
                if cancelled():
                    future.cancel()
                    raise Cancelled("Cancelled.") from None

    def at_close(self, release: Callable[[], None]) -> None:
        """Register what to release, on the worker, before the context goes."""
        self._at_close.append(release)

    def close(self, timeout_s: float = 10.0) -> None:
        """Finish the running job, drop the queued ones, release everything and join. Idempotent; a later job starts afresh."""
        with self._lock:
            thread, self._thread = self._thread, None
            if thread is not None and thread.is_alive():
                self._jobs.put(None)
        if thread is not None and thread is not threading.current_thread():
            thread.join(timeout_s)

    def _run(self) -> None:
        context: moderngl.Context | None = None
        while (item := self._jobs.get()) is not None:
            future, job, needs_context = item
            if not future.set_running_or_notify_cancel():
                continue
            try:
                if needs_context and context is None:
                    context = create_context(self._backend)
                future.set_result(job(context))
            except BaseException as error:  # handed to the caller, who raises it
                future.set_exception(error)
            del future, job, item
            if context is not None:
                _collect(context)
        self._drop_queued()
        self._release(context)

    def _drop_queued(self) -> None:
        while not self._jobs.empty():
            item = self._jobs.get()
            if item is not None:
                item[0].cancel()

    def _release(self, context: moderngl.Context | None) -> None:
        releases, self._at_close = self._at_close, []
        for release in releases:
            release()
        if context is not None:
            gc.collect()
            _collect(context)
            context.__exit__(None, None, None)  # no longer current: drivers keep a released context, and its memory, as long as it is
            context.release()


def _collect(context: moderngl.Context) -> None:
    """Release what Python has dropped. moderngl's own `gc()` fails on objects that were also released by hand, hence the check."""
    while context.objects:
        dropped = context.objects.popleft()
        if hasattr(dropped, "release"):
            dropped.release()


_worker: GpuWorker | None = None
_worker_lock = threading.Lock()


def shared_worker() -> GpuWorker:
    """The add-on's worker, made on first use and closed by `shutdown` (unregister) or at exit."""
    global _worker
    with _worker_lock:
        if _worker is None:
            _worker = GpuWorker(chosen().backend)
            atexit.register(shutdown)
        return _worker


def shutdown() -> None:
    """Close the shared worker: every GL object freed, the thread joined."""
    global _worker
    with _worker_lock:
        worker, _worker = _worker, None
    if worker is not None:
        atexit.unregister(shutdown)
        worker.close()
