"""USD, which Blender's own importer reads, with the unit and the axes of its stage."""

from __future__ import annotations

from pathlib import Path

from .cad_format import CadFormat, Likeness, only_in_blender, starts, starts_text
from .raw import RawFile

TEXT, CRATE = starts_text(rb"#usda"), starts(b"PXR-USDC")


def read_usd(path: Path) -> RawFile:
    """Raises `CadFileError`: it takes Blender."""
    raise only_in_blender(path)


def either(head: bytes, size: int) -> Likeness:
    """`.usd` may be a text or a binary file."""
    return max(TEXT(head, size), CRATE(head, size))


SIGNATURES = {".usd": either, ".usda": TEXT, ".usdc": CRATE, ".usdz": starts(b"PK\x03\x04")}
ROW = CadFormat("USD", SIGNATURES, read_usd, place=80, importers=("wm.usd_import",), fixes_unit=True)
