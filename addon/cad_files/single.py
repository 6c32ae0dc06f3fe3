"""STL, PLY and OFF through trimesh's loaders: one mesh, or one per solid of an ASCII STL."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .colors import rgba
from .raw import RawFile, RawNode, RawPiece


def read_single(path: Path) -> RawFile:
    """A `.stl`, `.ply` or `.off` file. STL's facet normals are not kept: they say nothing the triangles do not say."""
    from trimesh.exchange.load import mesh_loaders

    kind = path.suffix.lower()[1:]
    with path.open("rb") as file:
        loaded = mesh_loaders[kind](file, file_type=kind)
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
    faces = g.get("faces")
    triangles = np.empty((0, 3), dtype=np.int32) if faces is None else np.asarray(faces).reshape(-1, 3)
    colors = None
    if g.get("face_colors") is not None and len(g["face_colors"]) == len(triangles) and len(triangles):
        colors = rgba(g["face_colors"], is_srgb=True)
    elif g.get("vertex_colors") is not None and len(g["vertex_colors"]) == len(g["vertices"]) and len(triangles):
        colors = rgba(g["vertex_colors"], is_srgb=True)[triangles].mean(axis=1)
    return RawPiece(g["vertices"], triangles, g.get("vertex_normals"), None, colors)
