"""STL through trimesh's loader: one mesh, or one per solid of an ASCII file."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np

from .cad_format import CadFormat, Likeness
from .colors import of_faces, rgba
from .raw import RawFile, RawNode, RawPiece


def read_single(path: Path) -> RawFile:
    """A `.stl` file. Its facet normals are not kept: they say nothing the triangles do not say."""
    from trimesh.exchange.stl import load_stl

    with path.open("rb") as file:
        loaded = load_stl(file)
    raw = RawFile()
    geometry = loaded.get("geometry") or {path.stem: loaded}
    for name, g in geometry.items():
        if g.get("vertices") is None:
            continue
        title = _name(g) or (path.stem if len(geometry) == 1 else str(name))
        raw.meshes[name] = (title, [_piece(g)])
        raw.nodes.append(RawNode(title, mesh=name))
    return raw


def _name(g: dict) -> str | None:
    name = g.get("metadata", {}).get("name")
    return name if isinstance(name, str) and name.strip() else None


def _piece(g: dict) -> RawPiece:
    triangles = np.asarray(g.get("faces", np.empty((0, 3), np.int64))).reshape(-1, 3)
    colors = None
    if g.get("face_colors") is not None and len(g["face_colors"]) == len(triangles) and len(triangles):
        colors = of_faces(rgba(g["face_colors"], is_srgb=True))
    return RawPiece(g["vertices"], triangles, None, None, colors)


def likeness(head: bytes, size: int) -> Likeness:
    """A binary STL's length follows from its count of facets, whatever its first 80 bytes say; a text has the words."""
    if len(head) >= 84 and size == 84 + 50 * struct.unpack_from("<I", head, 80)[0]:
        return Likeness.BINARY
    is_solid = re.match(rb"[\xef\xbb\xbf \t\r\n]*solid\b", head, re.IGNORECASE)
    return Likeness.TEXT if is_solid and (b"facet" in head or b"endsolid" in head) else Likeness.NO


ROW = CadFormat("STL", {".stl": likeness}, read_single, place=20)
