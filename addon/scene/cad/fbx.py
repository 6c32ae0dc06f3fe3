"""FBX, which Blender's own importers read: the one in C++ where there is one (4.5), else the add-on that comes with it."""

from __future__ import annotations

from pathlib import Path

from .cad_format import CadFormat, Likeness, only_in_blender
from .raw import RawFile


def read_fbx(path: Path) -> RawFile:
    """Raises `CadFileError`: it takes Blender."""
    raise only_in_blender(path)


def likeness(head: bytes, _size: int) -> Likeness:
    """A binary file by its mark; a text by the comment it begins with, or its first section."""
    if head.startswith(b"Kaydara FBX Binary"):
        return Likeness.BINARY
    is_text = head.lstrip().startswith(b";") and b"FBX" in head[:200]
    return Likeness.TEXT if is_text or b"FBXHeaderExtension" in head else Likeness.NO


IMPORTERS = ("wm.fbx_import", "import_scene.fbx")
ROW = CadFormat("FBX", {".fbx": likeness}, read_fbx, place=90, unit="cm", up="Y", importers=IMPORTERS, fixes_unit=True)
