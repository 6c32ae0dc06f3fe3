"""Worker processes: each is this command line once more, with `--worker`, and takes one input after another.

They talk in lines of JSON: an item in on standard input, its report back on standard output, behind `MARK` because Blender prints there
too. A worker that dies costs the input it was at and is replaced; the others go on.
"""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import site
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from queue import Empty, Queue
from threading import Lock, Thread
from typing import TextIO

from ...blender.registering import is_python_module
from ...scene.reading.limits import cause
from ...studies import stopping
from ...studies.report import failed_report
from .items import Item

POLL_S = 0.1
PATIENCE_S = 10.0
MARK = "cad_shadow-worker:"
Answer = tuple[dict[str, object], str]
EXTENSION = Path(__file__).resolve().parents[3]


def worker_command(argv: list[str]) -> tuple[list[str], dict[str, str]]:
    """Command and environment that run `argv` again in a worker: inside Blender its own binary, elsewhere this Python."""
    bpy = sys.modules.get("bpy")
    if bpy is not None and not is_python_module(bpy.app):
        return [bpy.app.binary_path, "--command", "cad_shadow", *argv, "--worker"], dict(os.environ)
    paths = [str(EXTENSION), os.environ.get("PYTHONPATH", ""), wheels_folder()]
    command = [sys.executable, "-P", "-m", "addon", *argv, "--worker"]  # -P: no code from the current folder
    return command, {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}


def wheels_folder() -> str:
    """Where the extension's libraries are, when that is not where this Python looks by itself ('' then): Blender's folder for wheels."""
    found = importlib.util.find_spec("moderngl")
    folder = str(Path(found.origin).parents[1]) if found and found.origin else ""
    return "" if folder in site.getsitepackages() else folder


class Worker:
    """One worker process; started when first asked, ended by `stop`, or by `give_up` from any thread."""

    def __init__(self, argv: list[str]) -> None:
        self._argv = argv
        self._process: subprocess.Popen | None = None
        self._lock = Lock()
        self._is_given_up = False

    def answer(self, item: Item) -> Answer:
        """The item's report and line; a failed report when the process ends before it has answered."""
        process = self._running()
        if process is None:
            return failed_report(item.name, None, "Given up."), ""
        with suppress(OSError):  # it has ended: Windows says so with another error than BrokenPipeError
            process.stdin.write(json.dumps([item.source, item.name, str(item.stem)]) + "\n")
            process.stdin.flush()
            for line in process.stdout:
                if line.startswith(MARK):
                    report, text = json.loads(line.removeprefix(MARK))
                    return report, text
        return failed_report(item.name, None, _end_in_words(self.stop(), item)), ""

    def _running(self) -> subprocess.Popen | None:
        with self._lock:
            if self._process is None and not self._is_given_up:
                command, environment = worker_command(self._argv)
                pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
                self._process = subprocess.Popen(command, env=environment, **pipes, text=True, encoding="utf-8")
            return self._process

    def stop(self) -> int:
        """Let the process end after what it is at; gives its exit code."""
        with self._lock:
            process, self._process = self._process, None
        if process is None:
            return 0
        with suppress(OSError):
            process.stdin.close()
        code = process.wait()
        process.stdout.close()
        return code

    def give_up(self, timeout_s: float = PATIENCE_S) -> None:
        """End the process, in time for it to clean up, and start no other."""
        with self._lock:
            self._is_given_up, process = True, self._process
            if process is not None:
                process.terminate()
                with suppress(OSError, ValueError):  # one that waits for work is told that there is no more
                    process.stdin.close()
        if process is not None:
            try:
                process.wait(timeout_s)
            except subprocess.TimeoutExpired:
                process.kill()


def _end_in_words(code: int, item: Item) -> str:
    """Why there is no answer."""
    if hasattr(signal, "SIGALRM") and code == -signal.SIGALRM:
        return "Blender did not open it within the limit of time: raise --limit-seconds, or save it simpler."
    if item.is_blend:
        return f"The process that opened it ended unexpectedly ({cause(code)}), as damaged files make it: save it again from Blender."
    return f"The process that drew it ended ({cause(code)}): try it alone, without --jobs; if that fails too, please report it."


def answers(items: list[Item], argv: list[str], jobs: int) -> Iterator[tuple[Item, Answer]]:
    """Every item with its report and line, as they are finished, from `jobs` processes. Closing the iterator early ends them."""
    todo: Queue[Item] = Queue()
    done: Queue[tuple[Item, Answer]] = Queue()
    for item in items:
        todo.put(item)
    workers = [Worker(argv) for _ in range(min(jobs, len(items)))]
    threads = [Thread(target=_drain, args=(worker, todo, done), name=f"cad_shadow worker {i}") for i, worker in enumerate(workers)]
    for thread in threads:
        thread.start()
    is_complete = False
    try:
        for _ in items:
            yield _next(done)
        is_complete = True
    finally:
        enders = [Thread(target=worker.give_up) for worker in workers if not is_complete]
        for ender in enders:
            ender.start()
        for ender in enders:
            ender.join()
        for thread in threads:
            thread.join()


def _next(done: Queue[tuple[Item, Answer]]) -> tuple[Item, Answer]:
    """The next answer. Raises `KeyboardInterrupt` when the run is asked to stop meanwhile."""
    while True:
        stopping.check()
        with suppress(Empty):
            return done.get(timeout=POLL_S)


def _drain(worker: Worker, todo: Queue[Item], done: Queue[tuple[Item, Answer]]) -> None:
    while True:
        try:
            item = todo.get_nowait()
        except Empty:
            worker.stop()
            return
        try:
            done.put((item, worker.answer(item)))
        except Exception as error:  # must reach the one who waits
            message = f"A worker could not be used ({type(error).__name__}: {error}): run without --jobs."
            done.put((item, (failed_report(item.name, None, message), "")))


def serve(one: Callable[[Item], Answer], lines: TextIO, out: TextIO) -> None:
    """A worker's life: answer each line until there are no more, nobody listens, or it is asked to stop."""
    with suppress(OSError, KeyboardInterrupt):
        for line in lines:
            source, name, stem = json.loads(line)
            print(MARK + json.dumps(one(Item(source, name, Path(stem))), allow_nan=False), file=out, flush=True)
            stopping.check()
