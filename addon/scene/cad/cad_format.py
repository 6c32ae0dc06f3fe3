"""What a file format is to this program: the row that the module of its reader registers as its `ROW`."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

from ...errors import CadFileError
from .raw import RawFile


class Likeness(IntEnum):
    """How sure it is that bytes are of a format: where several say yes, the surest is believed."""

    NO = 0
    MAYBE = 1  # words that other texts could hold, too
    TEXT = 2  # the words a file of this format begins with
    BINARY = 3  # a mark or a length that no text has


Signature = Callable[[bytes, int], Likeness]  # of the first bytes of a file, and its size


@dataclass(frozen=True, eq=False)
class CadFormat:
    """A row: the name that users know, a signature for each suffix, the reader, the `place` in lists, and what a file means that says
    nothing of unit and axis.

    `importers`: Blender's own operators, the first of which that there is reads it; `read` then only says so.
    Of suffixes with the same signature the first is the one that a file under a wrong name is told to take.
    """

    name: str
    signatures: Mapping[str, Signature]
    read: Callable[[Path], RawFile]
    place: int
    unit: str = "m"
    up: str = "Z"
    importers: tuple[str, ...] = ()
    fixes_unit: bool = False  # the format itself says the unit; of the others a missing one is a guess, and a warning

    @property
    def suffixes(self) -> tuple[str, ...]:
        """In lower case, with the dot."""
        return tuple(self.signatures)


def starts(mark: bytes) -> Signature:
    """A binary file with this mark at its beginning."""
    return lambda head, _size: Likeness.BINARY if head.startswith(mark) else Likeness.NO


def starts_text(pattern: bytes) -> Signature:
    """A text that begins with what fits the pattern, after a byte order mark and blanks."""
    first = re.compile(rb"[\xef\xbb\xbf \t\r\n]*(?:" + pattern + rb")")
    return lambda head, _size: Likeness.TEXT if first.match(head) else Likeness.NO


def only_in_blender(path: Path) -> CadFileError:
    """What the reader of a format raises that Blender's own importers read."""
    suffix = path.suffix[1:].upper()
    return CadFileError(f"{path.name} is read by Blender's own {suffix} importer: open it in Blender, or with this program's commands.")
