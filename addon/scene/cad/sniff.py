"""What a file really is, from its first bytes: so that a wrong name gives a plain message and no parser sees bytes it was not made for."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from ...errors import CadFileError
from ..plain_text import shown_name
from ..user_files import opened
from .cad_format import CadFormat, Likeness

HEAD = 4096


def checked_path(path: str | Path, formats: Mapping[str, CadFormat]) -> Path:
    """The path of a file that exists, can be read, is not empty and is what its suffix says; else `CadFileError`. `formats` by suffix."""
    file = Path(path)
    suffix = file.suffix.lower()
    try:
        if file.is_dir():
            os.scandir(file).close()
            raise CadFileError(f"{file} is a folder without a CAD file in it: give a CAD file, or --recursive to look further down.")
        if suffix not in formats:
            raise CadFileError(f"{shown_name(file.name)} is no CAD file this program reads: give one of {' '.join(formats)}.")
        with opened(file) as stream:
            head = stream.read(HEAD)
        size = file.stat().st_size
    except FileNotFoundError as error:
        raise CadFileError(f"{shown_name(str(file), 1000)} does not exist: check the path.") from error
    except OSError as error:
        raise CadFileError(f"{shown_name(str(file), 1000)} cannot be read ({error.strerror}): check it and its permissions.") from error
    except ValueError as error:
        raise CadFileError(f"{shown_name(str(file), 1000)} is no name that a file can have: check the path.") from error
    if not head:
        raise CadFileError(f"{file.name} is empty (0 bytes): export it again.")
    fitting = sniff(head, size, formats)
    if not fitting:
        raise CadFileError(f"{file.name} holds no {suffix[1:].upper()} data: it is damaged or of another type. Export it again.")
    if suffix not in fitting:
        raise CadFileError(f"{file.name} is a {fitting[0][1:].upper()} file under a wrong name: rename it to {file.stem}{fitting[0]}.")
    return file


def sniff(head: bytes, size: int, formats: Mapping[str, CadFormat]) -> tuple[str, ...]:
    """The suffixes that fit the first bytes of a file of `size` bytes: those whose format is surest that it is its own; else none."""
    likeness = {suffix: row.signatures[suffix](head, size) for suffix, row in formats.items()}
    surest = max(likeness.values())
    return tuple(suffix for suffix, sure in likeness.items() if sure == surest is not Likeness.NO)
