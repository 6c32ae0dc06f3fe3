"""Standard output and standard error as they may be: closed, full, of any encoding, read by nobody. No bpy."""

from __future__ import annotations

import io
import os
import sys
from contextlib import suppress
from typing import TextIO

from ..scene.plain_text import shown_lines

ERRORS = {"stdout": "replace", "stderr": "backslashreplace"}


def make_ready() -> None:
    """Have the three standard streams open and able to take any text: a file opened later must not become one of them."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number, which is this one
    for name, errors in ERRORS.items():
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Closed())
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=errors)


class Closed(io.TextIOBase):
    """A stream that was closed when the process began."""

    def write(self, text: str) -> int:
        """Refuse all but nothing."""
        if text:
            raise OSError(9, "it is closed")
        return 0


def printed(stream: TextIO, text: str) -> bool:
    """Write a line and flush; False, with a complaint, when nobody can get it."""
    try:
        print(text, file=stream, flush=True)
    except OSError as error:
        _drain(stream)
        complain(f"cad_shadow: standard output cannot be written ({error.strerror}).")
        return False
    return True


def complain(text: str) -> None:
    """A line on standard error, what is foreign in it made plain; nothing where there is no such stream."""
    with suppress(OSError):
        print(shown_lines(text), file=sys.stderr, flush=True)


def flushed() -> bool:
    """Whether all that was printed has gone out; if not, the rest is dropped, so that Python does not fail on it when it ends."""
    try:
        sys.stdout.flush()
    except OSError:
        _drain(sys.stdout)
        return False
    return True


def _drain(stream: TextIO) -> None:
    """Have what a broken stream still holds go nowhere."""
    with suppress(OSError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        stream.flush()
