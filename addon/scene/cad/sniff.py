"""What a file really is, from its first bytes: so that a wrong name gives a plain message and no parser sees bytes it was not made for."""

from __future__ import annotations

import os
import re
import struct
from pathlib import Path

from ...errors import CadFileError
from ..plain_text import shown_name
from ..user_files import opened

SUFFIXES = (".glb", ".gltf", ".stl", ".obj", ".ply", ".off", ".3mf", ".step", ".stp")
SAME = {".stp": ".step"}
HEAD = 4096


def checked_path(path: str | Path) -> Path:
    """The path of a file that exists, can be read, is not empty and is what its suffix says; else `CadFileError`."""
    file = Path(path)
    suffix = file.suffix.lower()
    try:
        if file.is_dir():
            os.scandir(file).close()
            raise CadFileError(f"{file} is a folder without a CAD file in it: give a CAD file, or --recursive to look further down.")
        if suffix not in SUFFIXES:
            raise CadFileError(f"{shown_name(file.name)} is no CAD file this program reads: give one of {' '.join(SUFFIXES)}.")
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
    found = sniff(head, size)
    if found != SAME.get(suffix, suffix):
        if found is None:
            raise CadFileError(f"{file.name} holds no {suffix[1:].upper()} data: it is damaged or of another type. Export it again.")
        raise CadFileError(f"{file.name} is a {found[1:].upper()} file under a wrong name: rename it to {file.stem}{found}.")
    return file


def sniff(head: bytes, size: int) -> str | None:
    """The suffix that fits the first bytes of a file of `size` bytes, or None. Binary forms first, then text by its first words."""
    if head[:4] == b"glTF":
        return ".glb"
    if head[:4] == b"PK\x03\x04":
        return ".3mf"
    if len(head) >= 84 and size == 84 + 50 * struct.unpack_from("<I", head, 80)[0]:
        return ".stl"
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    if text.startswith(b"ISO-10303-21"):
        return ".step"
    if re.match(rb"ply[ \t]*\r?\n", text):
        return ".ply"
    if text.startswith(b"{"):
        return ".gltf"
    words = re.sub(rb"#[^\n]*", b"", text).lstrip()
    if re.match(rb"[A-Z0-9]{0,4}OFF\b", words):
        return ".off"
    if re.match(rb"solid\b", text, re.IGNORECASE) and (b"facet" in head or b"endsolid" in head):
        return ".stl"
    if b"\x00" not in head and re.search(rb"(?m)^\s*(v|vn|vt|f|o|g|mtllib|usemtl)\s", head):
        return ".obj"
    if text.startswith(b"#") and not words and b"\x00" not in head:
        return ".obj"
    return None
