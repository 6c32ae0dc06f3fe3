"""Coarser casters on disk, by what their mesh holds: made once for a mesh, whatever file it comes from. No bpy, no GL.

Files are this program's own, in the user's cache folder, and of at most `MOST_BYTES` in all: those not used longest go first.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np

from .collapse import Coarse

FORMAT = b"coarse casters 1"  # changes with what is made
MOST_BYTES = 256 << 20
_FIELDS = (("positions", np.float32, 3), ("triangles", np.int32, 3), ("source", np.int32, 0))


def folder() -> Path:
    """Where they are kept."""
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "cad_shadow_preview" / "casters"


def name_of(positions: np.ndarray, triangles: np.ndarray) -> str:
    """What the file of a mesh is called."""
    digest = hashlib.blake2b(FORMAT, digest_size=20)
    for array in (positions, triangles):
        digest.update(np.ascontiguousarray(array).data)
    return f"{digest.hexdigest()}.npz"


def read(name: str, most_triangle: int) -> tuple[Coarse, ...] | None:
    """What was kept under that name; None where there is nothing, or nothing that can be used with so many triangles."""
    try:
        with np.load(folder() / name, allow_pickle=False) as file:
            errors = file["errors"]
            levels = tuple(Coarse(*(file[f"{field}{k}"] for field, *_ in _FIELDS), float(error)) for k, error in enumerate(errors))
        os.utime(folder() / name)
    except (OSError, ValueError, KeyError, zipfile.BadZipFile, EOFError):
        return None
    return levels if all(_is_sound(level, most_triangle) for level in levels) else None


def _is_sound(level: Coarse, count: int) -> bool:
    for field, kind, width in _FIELDS:
        array = getattr(level, field)
        if array.dtype != kind or array.ndim != (2 if width else 1) or (width and array.shape[1] != width) or not len(array):
            return False
    return (
        len(level.source) == len(level.triangles)
        and 0 <= level.triangles.min() <= level.triangles.max() < len(level.positions)
        and 0 <= level.source.min() <= level.source.max() < count
        and level.error >= 0.0
    )


def write(name: str, levels: tuple[Coarse, ...]) -> None:
    """Keep them; where that cannot be done they are made again another time."""
    arrays = {f"{field}{k}": getattr(level, field) for k, level in enumerate(levels) for field, *_ in _FIELDS}
    with suppress(OSError):
        folder().mkdir(parents=True, exist_ok=True)
        handle, made = tempfile.mkstemp(suffix=".part", dir=folder())
        try:
            with os.fdopen(handle, "wb") as file:
                np.savez(file, errors=np.array([level.error for level in levels], np.float64), **arrays)
            os.replace(made, folder() / name)
        except OSError:
            os.unlink(made)
            raise
        _make_room()


def _make_room() -> None:
    files = sorted(((path.stat().st_mtime, path.stat().st_size, path) for path in folder().iterdir()), reverse=True)
    total = 0
    for _, size, path in files:
        total += size
        if total > MOST_BYTES:
            with suppress(OSError):
                path.unlink()
