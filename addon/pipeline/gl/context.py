"""The one OpenGL context and the one thread that owns it. Nothing else in the program creates, uses or releases GL objects.

Facts behind the design (measured): a context made on Blender's main thread draws in Blender's own context,
corrupts the viewport or crashes; a dedicated thread that keeps one context never did. Jobs and arrays pass through a queue; the caller may
wait (the wait releases the GIL) or keep the future.
"""

from __future__ import annotations

import atexit
import ctypes
import gc
import logging
import os
import queue
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from ctypes.util import find_library
from dataclasses import dataclass
from typing import TypeVar

import moderngl

from ...errors import DriverError, GpuError, UserError
from .machine import chosen, note_context

T = TypeVar("T")
log = logging.getLogger(__name__)
THREAD_NAME = "cad-shadow-gl"
REQUIRED_GL = 330

_LINUX_HINT = (
    "install Mesa's EGL libraries (Debian/Ubuntu: apt install libegl1 libgl1 libgl1-mesa-dri libegl-mesa0; "
    "Fedora: dnf install mesa-libEGL mesa-dri-drivers)"
)
_X_HINT = "it needs an X server (DISPLAY); choose OpenGL: Automatic in the extension's preferences to do without"
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
            with x_errors_handled_as_before():
                context = moderngl.create_context(standalone=True, require=REQUIRED_GL, **options)
        except Exception as error:  # glcontext raises bare Exception for every failure of the driver
            failures.append(f"{choice or 'native'}: {' '.join(str(error).split())}")
            continue
        context.gc_mode = "context_gc"
        note_context(choice or "native", context.info)
        return context
    hint = _OTHER_HINT if not sys.platform.startswith("linux") else _X_HINT if choices == [None] else _LINUX_HINT
    raise GpuError(f"No OpenGL 3.3 context could be made ({'; '.join(failures)}): {hint}.")


@contextmanager
def x_errors_handled_as_before() -> Iterator[None]:
    """Keep the process's handler of X errors, where there is an X library.

    glcontext leaves Xlib's own in its place, which ends the process at the first error; Blender's goes on.
    """
    name = find_library("X11") if sys.platform.startswith("linux") else None
    if name is None:
        yield
        return
    set_handler = ctypes.CDLL(name).XSetErrorHandler
    set_handler.restype, set_handler.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
    before = set_handler(None)
    set_handler(before)
    try:
        yield
    finally:
        set_handler(before)


def destroy_context(context: moderngl.Context) -> None:
    """Free the context and its objects, on the thread where it is current; none is current afterwards.

    A driver keeps a context, and its memory, as long as it is current somewhere. EGL's `release` leaves it current, its `__exit__` makes
    none current. The other platforms' `release` makes none current, and their `__exit__` what was current at `__enter__`: that is this
    context itself, and without an `__enter__` some address that was never written.
    """
    gc.collect()
    _collect(context)
    with context:
        pass
    context.release()


@dataclass(eq=False)
class _Item:
    """A job in the queue: what to call, whether it needs a context, how to tell it to stop (None: it is short, or cannot)."""

    future: Future
    job: Callable
    needs_context: bool
    give_up: Callable[[], None] | None


class _Life(threading.Thread):
    """One life of the worker's thread, from the first job after a start to `end`, with its own queue and context."""

    def __init__(self, backend: str) -> None:
        super().__init__(name=THREAD_NAME, daemon=True)
        self._backend = backend
        self._jobs: queue.SimpleQueue[_Item | None] = queue.SimpleQueue()
        self._current: _Item | None = None
        self._is_ending = False
        self._context: moderngl.Context | None = None
        self.releases: list[Callable[[], None]] = []

    def put(self, item: _Item) -> None:
        """Queue a job."""
        self._jobs.put(item)

    def end(self) -> None:
        """Drop the queued jobs, tell the running one to stop, and let the thread end. From any thread."""
        self._is_ending = True
        self._drop_queued()
        self._jobs.put(None)
        running = self._current
        if running is not None and running.give_up is not None:
            running.give_up()

    def run(self) -> None:
        """Do the jobs until the end, then release everything."""
        while (item := self._jobs.get()) is not None:
            self._current = item  # before `_is_ending` is read: `end` writes that first, so one of the two sees the other
            if self._is_ending:
                item.future.cancel()
            if item.future.set_running_or_notify_cancel():
                self._do(item)
            self._current = None
            del item
            if self._context is not None:
                _collect(self._context)
        self._drop_queued()
        self._release()

    def _do(self, item: _Item) -> None:
        try:
            if item.needs_context and self._context is None:
                self._context = create_context(self._backend)
            result = item.job(self._context)
        except BaseException as error:  # handed to the caller, who raises it
            if self._context is not None and (isinstance(error, DriverError) or not isinstance(error, UserError)):
                self._start_afresh()
            item.future.set_exception(_in_words(error))
        else:
            item.future.set_result(result)

    def _start_afresh(self) -> None:
        """Drop the context and all that is in it, whatever state a failure has left them in: the next job gets another."""
        try:
            self._release()
        except Exception as error:  # one that is lost may fail at its release too
            log.info("a context was dropped: %r", error)

    def _drop_queued(self) -> None:
        while True:
            try:
                item = self._jobs.get_nowait()
            except queue.Empty:
                return
            if item is not None:
                item.future.cancel()

    def _release(self) -> None:
        """Release what was registered, in that order, then the context. What fails is raised when all was tried."""
        with ExitStack() as stack:
            if self._context is not None:
                stack.callback(destroy_context, self._context)
            for release in reversed(self.releases):
                stack.callback(release)
            self._context, self.releases = None, []


def _in_words(error: BaseException) -> BaseException:
    """The error as users are told it: what moderngl raises is the driver's failure."""
    if not isinstance(error, moderngl.Error):
        return error
    words = DriverError(f"The graphics driver failed ({' '.join(str(error).split())}): try again, or update the driver.")
    words.__cause__ = error
    return words


class GpuWorker:
    """A thread that owns a context. `submit` queues a job, `call` also waits for it; both work from any thread but the worker's own.

    The thread starts with the first job and lives until `close`; the context is made by the first job that needs it.
    """

    def __init__(self, backend: str = "auto") -> None:
        self._backend = backend
        self._life: _Life | None = None
        self._lock = threading.Lock()

    @property
    def is_running(self) -> bool:
        """True while the thread lives."""
        return self._life is not None and self._life.is_alive()

    def submit(self, job: Callable[[moderngl.Context], T], give_up: Callable[[], None] | None = None) -> Future[T]:
        """Queue `job(context)`; its result or error comes through the future. A future cancelled before its turn is never run.

        `give_up`, called from another thread when the worker is closed, asks a job under way to stop soon.
        """
        return self._queue(job, True, give_up)

    def submit_plain(self, job: Callable[[], T]) -> Future[T]:
        """Queue work that needs no OpenGL, as `submit` does; no context is made for it."""
        return self._queue(lambda _context: job(), False, None)

    def _queue(self, job: Callable, needs_context: bool, give_up: Callable[[], None] | None) -> Future[T]:
        future: Future[T] = Future()
        with self._lock:
            if not self.is_running:
                self._life = _Life(self._backend)
                self._life.start()
            self._life.put(_Item(future, job, needs_context, give_up))
        return future

    def call(self, job: Callable[[moderngl.Context], T]) -> T:
        """Run `job(context)` on the worker and wait."""
        if threading.current_thread() is self._life:
            raise RuntimeError("GpuWorker.call from the worker itself would wait for ever")
        return self.submit(job).result()

    def at_close(self, release: Callable[[], None]) -> None:
        """Register, on the worker's thread, what to release there before its context goes."""
        threading.current_thread().releases.append(release)

    def close(self, timeout_s: float = 10.0) -> None:
        """Tell the running job to stop, drop the queued ones, release everything and join. Idempotent; a later job starts afresh."""
        with self._lock:
            life, self._life = self._life, None
            if life is not None:
                life.end()
        if life is not None and life is not threading.current_thread():
            life.join(timeout_s)


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
