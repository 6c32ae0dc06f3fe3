"""The process that reads CAD files: `python -m addon.scene.reading.child SECONDS MEMORY_MIB`.

Asks and answers go through standard input and output by `wire`; whatever native readers print goes to standard error.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress

from ...errors import CadFileError, CadMemoryError
from .. import cad
from ..user_files import run_of_inputs
from .limits import Limits, allow_processor, enforce_memory
from .wire import receive, send


def answer(path: bytes, units: str | None, up: str | None) -> dict[str, object]:
    """What came of it: `model`, or `error` in words and whether it `is_memory`; and the `files` that were read, as (path, is_read)."""
    with run_of_inputs() as noted:
        result: dict[str, object]
        try:
            result = {"model": cad.read(os.fsdecode(path), units, up)}
        except CadFileError as error:
            result = {"error": str(error), "is_memory": isinstance(error, CadMemoryError)}
    return {**result, "files": [(os.fspath(file.path), file.is_read) for file in noted.values()]}


def main(seconds: str, memory_mib: str) -> None:
    """Answer until nobody asks any more."""
    limits = Limits(int(seconds), int(memory_mib))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the one who waits
    with suppress(EOFError, OSError), os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)
        enforce_memory(limits)
        while True:
            path, units, up = receive(sys.stdin.buffer)
            allow_processor(limits)
            send(out, answer(path, units, up))


if __name__ == "__main__":
    main(*sys.argv[1:])
