"""The process that makes coarser casters: `python -m addon.pipeline.detail.child`.

Asks and answers go through standard input and output by `wire`; what a library prints goes to standard error.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress

from ...scene.reading.wire import receive, send
from ..geometry.clusters import clustered
from .collapse import coarser

KIND = 10  # how much it stands back for others


def main() -> None:
    """Answer until nobody asks any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the one who waits
    if hasattr(os, "nice"):
        os.nice(KIND)
    with suppress(EOFError, OSError), os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)
        while True:
            positions, triangles = receive(sys.stdin.buffer)
            levels = coarser(positions, clustered(positions, triangles)[0])
            send(out, tuple((level.positions, level.triangles, level.source, level.error) for level in levels))


if __name__ == "__main__":
    main()
