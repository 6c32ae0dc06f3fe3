"""A Python process of our own beside Blender's: this package, started where no code from the current folder runs. No bpy, no OpenGL."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

PEER = "addon"  # what the package is called in such a process
EXTENSION = Path(__file__).resolve().parents[2]


def started(
    module: str, arguments: Iterable[str], libraries: Iterable[str], scratch: str | None = None, **streams: Any
) -> subprocess.Popen[bytes]:
    """Start `python -m addon.<module>`; `libraries` are what it imports beside Python's own, found here: Blender keeps its wheels where
    only it looks. Its temporary files go to the folder `scratch`. `streams` as for `Popen`. Raises `OSError` when it cannot be started."""
    paths = [str(EXTENSION), *dict.fromkeys(folder for name in libraries if (folder := _folder(name)))]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [*paths, os.environ.get("PYTHONPATH", "")]))}
    if scratch is not None:
        environment |= dict.fromkeys(("TMPDIR", "TEMP", "TMP"), scratch)
    command = [sys.executable, "-P", "-m", f"{PEER}.{module}", *arguments]  # -P: no code from the current folder
    return subprocess.Popen(command, env=environment, creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0), **streams)


def _folder(library: str) -> str | None:
    """The folder that a library, without being imported, would come from; None where there is none."""
    spec = find_spec(library)
    if spec is None or not spec.origin:
        return None
    return str(Path(spec.origin).parents[0 if spec.submodule_search_locations is None else 1])
