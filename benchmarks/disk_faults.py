"""A disk that fails, put in wherever a command writes: at every file opened for writing, folder made, file renamed and flushed, and after
any number of bytes. The points are those that Python itself tells of (its audit events) and a limit on the size of files, Blender's too.
"""

from __future__ import annotations

import errno
import io
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from addon.images.whole import check_picture
from benchmarks.fault_jobs import Fault

if sys.platform != "win32":
    import resource

OLD = b"what was there before\n"
SMALL = ("--size", "64x48", "--map-size", "64", "--quiet")
DAY = ("--latitude", "51", "--longitude", "0", "--date", "2026-06-21", "--from", "10:00", "--steps", "1", "--pictures")
COMMANDS = {
    "preview": ("--passes", "combined,shadow", "--report", "OUT/all.json"),
    "preview exr": ("--format", "exr"),
    "preview npz": ("--format", "npz"),
    "preview batch": ("IN/two.obj", "--contact-sheet"),
    "analyse": ("--report", "OUT/all.json"),
    "sun-study": DAY,
    "impostor": ("--plane",),
    "theory": ("--near", "1", "--far", "9", "--report", "OUT/theory.json"),
    "advise": (
        "--error",
        "0.5",
    ),
}
"""Commands, with a word for one of several ways, and what they are given beside the model."""
LEFT_OUT = {"compare", "sun-hours", "impostor-path", "bench"}
"""Commands that take long; they write through the same place."""
WRITES = {"os.mkdir", "os.rename", "open"}


@dataclass
class Disk:
    """A folder whose writes are counted as they come; number `at` fails."""

    folder: str = ""
    at: int = -1
    number: int = errno.ENOSPC
    passed: list[str] = field(default_factory=list)

    def event(self, name: str, path: object, flags: object = None) -> None:
        """Told of everything; raises where it is time."""
        if not self.folder or name not in WRITES | {"os.fsync"} or (name == "open" and not _writes(flags)):
            return
        if name != "os.fsync" and not (isinstance(path, str | bytes | os.PathLike) and os.fsdecode(path).startswith(self.folder)):
            return
        if name == "os.mkdir" and os.path.isdir(path):
            return  # nothing is made
        self.passed.append(name)
        if len(self.passed) - 1 == self.at:
            raise OSError(self.number, os.strerror(self.number), os.fsdecode(path) if name != "os.fsync" else None)


def _writes(flags: object) -> bool:
    return isinstance(flags, int) and bool(flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))


_disks: list[Disk] = []


def _hook(event: str, arguments: tuple) -> None:
    for disk in _disks:
        disk.event(event, arguments[0] if arguments else None, arguments[2] if event == "open" else None)


_hooked: list[bool] = []


@contextmanager
def failing(disk: Disk) -> Iterator[Disk]:
    """While this lasts that folder's writes are counted and fail."""
    if not _hooked:
        sys.addaudithook(_hook)  # for good: Python takes none back
        _hooked.append(True)
    real = os.fsync

    def fsync(handle: int) -> None:
        disk.event("os.fsync", handle)
        real(handle)

    _disks.append(disk)
    os.fsync = fsync
    try:
        yield disk
    finally:
        os.fsync = real
        _disks.remove(disk)


@contextmanager
def small_files(count: int) -> Iterator[None]:
    """While this lasts no file of this process grows beyond so many bytes, as on a full disk; Blender's too."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (count, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


class Command:
    """A way of one command that writes into a folder of its own; `main(argv)` is the command line."""

    def __init__(self, main: Callable[[list[str]], int], name: str, folder: Path) -> None:
        self.main, self.name, self.out = main, name, folder / name.replace(" ", "_")
        sources = folder / "in"
        sources.mkdir(exist_ok=True)
        for model in ("box.obj", "two.obj"):
            (sources / model).write_text("v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        words = [word.replace("OUT", str(self.out)).replace("IN", str(sources)) for word in COMMANDS[name]]
        command = name.split()[0]
        self.argv = [command, *words] if command == "theory" else [command, str(sources / "box.obj"), *words, "-o", str(self.out), *SMALL]
        self.out.mkdir()
        with failing(Disk(str(self.out))) as disk:
            code, said = self.run()
        if code:
            raise RuntimeError(f"{self.argv} fails without a fault: {said}")
        self.points = list(disk.passed)
        self.files = {path.relative_to(self.out) for path in self.out.rglob("*") if path.is_file()}
        self.largest = max((self.out / path).stat().st_size for path in self.files)

    def run(self) -> tuple[int, str]:
        """The exit code and what was said."""
        said = io.StringIO()
        with redirect_stderr(said):
            code = self.main(self.argv)
        return code, said.getvalue()

    def faults(self, step: int = 1) -> Iterator[Fault]:
        """Every `step`-th write fails, in turn full and broken; then files end after more and more bytes."""
        for at in range(0, len(self.points), step):
            number = (errno.ENOSPC, errno.EIO)[at % 2]
            self._put_old()
            with failing(Disk(str(self.out), at, number)):
                wrong = "; ".join(self._wrong())
            yield Fault(f"{self.name}: {self.points[at]}", errno.errorcode[number], wrong or self._after())
        for size in sorted({0, 1, 64, 1000, self.largest // 2, self.largest - 1})[::step] if sys.platform != "win32" else ():
            self._put_old()
            with small_files(size):
                wrong = "; ".join(self._wrong())
            yield Fault(f"{self.name}: after {size} bytes", "full", wrong or self._after())

    def _put_old(self) -> None:
        for path in self.files:
            (self.out / path).write_bytes(OLD)

    def _wrong(self) -> Iterator[str]:
        try:
            code, said = self.run()
        except BaseException as error:
            yield f"{type(error).__name__}: {error}"
            return
        if code != 1:
            yield f"exit code {code}"
        lines = [line for line in said.splitlines() if line.startswith("cad_shadow")]
        if not lines or "Traceback" in said or "please report" in said:
            yield f"says {said[-200:]!r}"
        found = {path.relative_to(self.out) for path in self.out.rglob("*") if path.is_file()}
        if found != self.files:
            yield f"left: {sorted(map(str, found - self.files))}, lost: {sorted(map(str, self.files - found))}"
        yield from (f"{path} is neither the old file nor a whole one" for path in found & self.files if not _is_whole(self.out / path))

    def _after(self) -> str:
        code, said = self.run()
        return "" if code == 0 else f"the next run fails: {said}"


def _is_whole(path: Path) -> bool:
    data = path.read_bytes()
    if data == OLD:
        return True
    try:
        if path.suffix == ".json":
            json.loads(data)
        elif path.suffix == ".npz":
            with np.load(path) as arrays:
                return all(arrays[name] is not None for name in arrays)
        else:
            check_picture(path)
    except (ValueError, OSError):
        return False
    return bool(data)
