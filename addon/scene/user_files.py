"""The user's files: read only when they are regular and not too large, and known while a run lasts, so that no result replaces one.

No bpy. A name that stands in a model is anybody's word: it may name a device, a pipe that nobody writes to, or all of the disk.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, NamedTuple

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFLNK: "a link",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}
MEBI = 2**20

Key = tuple[int, int] | str


class Noted(NamedTuple):
    """An input: the path that it was noted by first, and whether what it holds counts (a model's textures only must not be lost)."""

    path: Path
    is_read: bool


_runs: list[dict[Key, Noted]] = []  # of the process, not of a context: a file that any thread reads must not be lost


@contextmanager
def run_of_inputs() -> Iterator[dict[Key, Noted]]:
    """While this lasts every file noted counts as an input; gives them by what the disk knows them by."""
    noted: dict[Key, Noted] = {}
    _runs.append(noted)
    try:
        yield noted
    finally:
        _runs.pop()


def note(path: Path, is_read: bool = False) -> None:
    """Count a file, if there is one, as an input of the runs that last."""
    with suppress(OSError, ValueError):  # not there, or not a name that a file can have
        key = _key(path)
        for noted in _runs:
            before = noted.get(key, Noted(Path(path), False))
            noted[key] = Noted(before.path, before.is_read or is_read)


def is_input(path: Path) -> bool:
    """Whether this is a file, by whatever name, that was noted in a run that lasts."""
    return any(_key(path) in noted for noted in _runs)


def _key(path: Path) -> Key:
    state = os.stat(path)
    return (state.st_dev, state.st_ino) if state.st_ino else os.path.normcase(os.path.realpath(path))


def kind_of(mode: int) -> str | None:
    """What a file is that is not a regular one, in words; None for a regular one."""
    return None if stat.S_ISREG(mode) else KINDS.get(stat.S_IFMT(mode), "no file")


def opened(path: Path, is_own: bool = False) -> BinaryIO:
    """A regular file, open for reading and noted, unless it `is_own`, a result of ours.

    Raises `OSError` with a reason in words for anything else, without opening it.
    """
    _refuse(kind_of(os.stat(path).st_mode), path)
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))
    file = os.fdopen(handle, "rb")
    try:
        _refuse(kind_of(os.fstat(handle).st_mode), path)  # it may have been replaced meanwhile
    except OSError:
        file.close()
        raise
    if not is_own:
        note(path, is_read=True)
    return file


def _refuse(kind: str | None, path: Path) -> None:
    if kind is not None:
        raise OSError(errno.EINVAL, f"it is {kind}, not a file", str(path))


def read_bytes(path: Path, most: int, is_own: bool = False) -> bytes:
    """The content of a regular file of at most so many bytes, noted as by `opened`. Raises `OSError` with a reason in words."""
    with opened(path, is_own) as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"it is larger than the {size_text(most)} allowed", str(path))
    return data


def size_text(count: int) -> str:
    """Bytes in words."""
    return f"{count / (1 << 30):g} GiB" if count >= 1 << 30 else f"{count // MEBI} MiB"
