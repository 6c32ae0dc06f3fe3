"""Asks a process of its own for a CAD file, watches it, and ends it when it takes too long or is given up."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from threading import Lock, Thread, Timer

from ...errors import CadFileError, Cancelled
from ..cad.formats import BY_SUFFIX
from ..cad.sniff import checked_path
from ..cad_model import CadModel
from ..plain_text import shown, shown_name
from ..user_files import note
from .limits import TOO_MUCH, Limits, cause, chosen, memory_bytes
from .process import given_back, taken

RAISE = "raise the limit (in the extension's preferences; on the command line {option})"
POLL_S = 0.1
_COMPLAINT = re.compile(rb"\*{3,4} ERR (\w+) ")


class Reading:
    """A file being read, as `studies.pending.Pending` has it: `progress`, `done`, `cancel`, `result`."""

    def __init__(self, path: str | Path, units: str | None = None, up: str | None = None, limits: Limits | None = None) -> None:
        """Start. Raises `CadFileError` for what is no such file, and when no process can be started."""
        self.path, self._limits = checked_path(path, BY_SUFFIX), limits or chosen()
        self._future: Future[CadModel] = Future()
        self._lock, self._why_ended, self._since = Lock(), "", time.monotonic()
        try:
            self._process = taken(self._limits)
        except OSError as error:
            raise CadFileError(f"{shown_name(self.path.name)} cannot be read: no process could be started ({error}).") from error
        self._timer = Timer(self._limits.seconds, self._end, ("time",)) if self._limits.seconds else None
        Thread(target=self._receive, args=(units, up), name="cad-shadow-reading", daemon=True).start()
        if self._timer is not None:
            self._timer.daemon = True
            self._timer.start()

    @property
    def progress(self) -> tuple[float, str]:
        """Readers do not say how far they are: 0, and since when they are at it."""
        return 0.0, f"Reading {shown_name(self.path.name)}, {time.monotonic() - self._since:.0f} s"

    def done(self) -> bool:
        """True when `result` will not wait."""
        return self._future.done()

    def cancel(self) -> None:
        """Give it up: the process is ended."""
        self._end("cancelled")

    def result(self, timeout_s: float | None = None) -> CadModel:
        """The model. Raises `CadFileError`, one line that says what to do, `Cancelled`, or `TimeoutError` when it is not done in time."""
        try:
            return self._future.result(timeout_s)
        except NotYet as error:
            raise TimeoutError from error

    def _end(self, why: str) -> None:
        with self._lock:
            if not self._future.done() and not self._why_ended:
                self._why_ended = why
                self._process.kill()

    def _receive(self, units: str | None, up: str | None) -> None:
        """On the thread: take the answer, or find out why there is none."""
        try:
            answer, said = self._process.ask(str(self.path), units, up)
            if self._timer is not None:
                self._timer.cancel()
            with self._lock:
                is_whole = not self._why_ended
                self._why_ended = self._why_ended or "over"
            if answer is not None and is_whole:
                given_back(self._process, _bytes_of(answer))
                self._settle(answer, said)
            else:
                self._future.set_exception(self._failure(self._process.end()))
        except BaseException as error:  # must reach the one who waits
            self._future.set_exception(error)

    def _settle(self, answer: dict, said: bytes) -> None:
        for path, is_read in answer["files"]:
            note(Path(path), is_read)
        if "model" in answer:
            self._future.set_result(_with_complaints(answer["model"], said))
        else:
            too_large = answer["is_memory"] and memory_bytes(self._limits)
            self._future.set_exception(CadFileError(self._too_large() if too_large else answer["error"]))

    def _failure(self, code: int) -> Exception:
        """Why there is no answer, in words."""
        name = shown_name(self.path.name)
        if self._why_ended == "cancelled":
            return Cancelled("Cancelled.")
        if self._why_ended == "time":
            advice = RAISE.format(option="--limit-seconds")
            return CadFileError(f"{name} was not read within {self._limits.seconds} s: {advice}, or export it simpler or in parts.")
        if code == TOO_MUCH:
            return CadFileError(self._too_large())
        why = f"its reader ended unexpectedly ({cause(code)}), as damaged files and those too large for the memory make it"
        return CadFileError(f"{name} cannot be read: {why}. Export it again.")

    def _too_large(self) -> str:
        limit, advice = memory_bytes(self._limits) >> 20, RAISE.format(option="--limit-memory")
        return (
            f"{shown_name(self.path.name)} needs more than the {limit:,} MiB of memory that reading may take: {advice}, or split the file."
        )


def _bytes_of(answer: dict) -> int:
    meshes = answer["model"].meshes if "model" in answer else ()
    return sum(mesh.positions.nbytes + mesh.triangles.nbytes for mesh in meshes)


def _with_complaints(model: CadModel, said: bytes) -> CadModel:
    """The model, with a warning where OpenCASCADE, which says so on standard output alone, has found errors."""
    kinds = [kind.decode() for kind in _COMPLAINT.findall(said)]
    if not kinds:
        return model
    complaints = ", ".join(f"{kind} ({kinds.count(kind)} ×)" for kind in sorted(set(kinds)))
    line = f"OpenCASCADE found errors in the file: {shown(complaints)}. Parts of the model may be missing: export it again."
    return replace(model, warnings=(*model.warnings, line))


def read(path: str | Path, units: str | None = None, up: str | None = None, check: Callable[[], None] | None = None) -> CadModel:
    """Read a file and wait; `check()` is called now and then and may raise. Raises as `Reading.result` does."""
    reading = Reading(path, units, up)
    try:
        while True:
            with suppress(TimeoutError):
                return reading.result(POLL_S)
            if check is not None:
                check()
    finally:
        reading.cancel()
