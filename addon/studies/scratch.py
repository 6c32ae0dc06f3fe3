"""Folders of this process's own beside the files it is about to write: nobody else can guess, enter or link them. No bpy.

A process that is killed leaves its folder behind. The next one that writes there takes it away: a folder whose lock nobody holds is
nobody's.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

if sys.platform != "win32":
    import fcntl

PREFIX = ".cad_shadow-"
LOCK = "lock"
PART = "part"
FRESH_S = 30.0  # a folder this young may not have its lock yet

_swept: set[Path] = set()


@contextmanager
def beside(folder: Path) -> Iterator[Path]:
    """A folder inside `folder`, gone with all that is in it at the end. Raises `OSError`."""
    _sweep_once(folder)
    place = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
    try:
        with (place / LOCK).open("xb") as lock:
            _hold(lock)
            yield place
    finally:
        _remove(place)


def _hold(lock: BinaryIO) -> bool:
    """Take the lock (open files are locked on Windows); False where somebody has it or the file system knows no locks."""
    if sys.platform == "win32":
        return True
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _sweep_once(folder: Path) -> None:
    """Take away what processes that are no more have left in `folder`; once for each process and folder."""
    if folder in _swept:
        return
    _swept.add(folder)
    with suppress(OSError), os.scandir(folder) as found:
        for place in [Path(one.path) for one in found if one.name.startswith(PREFIX) and one.is_dir(follow_symlinks=False)]:
            if _is_left_behind(place):
                _remove(place)


def _is_left_behind(place: Path) -> bool:
    lock = place / LOCK
    try:
        if time.time() - place.lstat().st_mtime < FRESH_S or not os.path.lexists(lock):
            return False
        if sys.platform == "win32":
            lock.unlink()  # refused while its process has it open
            return True
        with lock.open("r+b") as file:
            return _hold(file)
    except OSError:
        return False


def _remove(place: Path) -> None:
    """Remove such a folder with the files that it can have; one that holds anything else stays."""
    with suppress(OSError):
        for name in os.listdir(place):
            if name == LOCK or name.startswith(PART):
                (place / name).unlink()
        place.rmdir()
