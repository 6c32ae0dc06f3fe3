"""The processes that read CAD files: one is kept for the next file, as long as nothing went wrong with it."""

from __future__ import annotations

import atexit
import os
import subprocess
import tempfile
from contextlib import suppress
from threading import Lock

from ..child_python import started
from . import wire
from .limits import Limits

LIBRARIES = ("numpy", "cascadio", "DracoPy", "ifcopenshell", "OCP")
MOST_SAID = 1 << 20
KEPT_BYTES = 64 << 20  # a process that has sent more is ended: Python hands little memory back


class ReaderProcess:
    """One process under `limits`. Raises `OSError` when none can be started."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self._scratch = tempfile.TemporaryDirectory(prefix="cad-shadow-")
        self._said = tempfile.TemporaryFile(dir=self._scratch.name) if os.name == "posix" else tempfile.TemporaryFile()  # noqa: SIM115
        arguments = [str(limits.seconds), str(limits.memory_mib)]
        streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": self._said}
        try:
            self._process = started("scene.reading.child", arguments, LIBRARIES, self._scratch.name, **streams)
        except BaseException:
            self._tidy()
            raise
        assert self._process.stdin and self._process.stdout, "pipes were asked for"
        self._stdin, self._stdout = self._process.stdin, self._process.stdout

    def ask(self, path: str, units: str | None, up: str | None) -> tuple[dict | None, bytes]:
        """Have a file read, and wait: the answer, None where there is none, and what native readers have said on standard error."""
        before = self._said.seek(0, os.SEEK_END)
        try:
            wire.send(self._stdin, (os.fsencode(path), units, up))
            answer = wire.receive(self._stdout)
        except (EOFError, OSError, ValueError, KeyError, TypeError, MemoryError):
            answer = None
        self._said.seek(before)
        return answer, self._said.read(MOST_SAID)

    @property
    def is_alive(self) -> bool:
        """Whether it can be asked."""
        return self._process.poll() is None

    def kill(self) -> None:
        """End it at once; `end` is still to be called."""
        self._process.kill()

    def end(self) -> int:
        """End it; its exit code."""
        with suppress(OSError):
            self._stdin.close()
        self._process.kill()
        code = self._process.wait()
        self._stdout.close()
        self._tidy()
        return code

    def _tidy(self) -> None:
        self._said.close()
        with suppress(OSError):
            self._scratch.cleanup()


_kept: list[ReaderProcess] = []
_lock = Lock()


@atexit.register
def shutdown() -> None:
    """End the process that is kept."""
    with _lock:
        kept = list(_kept)
        _kept.clear()
    for process in kept:
        process.end()


def prepare(limits: Limits) -> None:
    """Start the process that will be asked next, so that it gets ready meanwhile. Where none can be started the one who asks is told."""
    with _lock, suppress(OSError):
        if not _kept:
            _kept.append(ReaderProcess(limits))


def taken(limits: Limits) -> ReaderProcess:
    """The process that was kept, if its limits are these, else a new one."""
    with _lock:
        kept = _kept.pop() if _kept else None
    if kept is not None:
        if kept.limits == limits and kept.is_alive:
            return kept
        kept.end()
    return ReaderProcess(limits)


def given_back(process: ReaderProcess, sent_bytes: int) -> None:
    """Keep it for the next file, unless it holds much memory or another one is kept."""
    with _lock:
        is_kept = not _kept and sent_bytes <= KEPT_BYTES
        if is_kept:
            _kept.append(process)
    if not is_kept:
        process.end()
