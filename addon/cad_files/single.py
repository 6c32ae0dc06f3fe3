"""STL and PLY through trimesh's loaders: one mesh, or one per solid of an ASCII STL."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .colors import rgba
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece


def read_single(path: Path) -> RawFile:
    """A `.stl` or `.ply` file. STL's facet normals are not kept: they say nothing the triangles do not say."""
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
    triangles = np.empty((0, 3), dtype=np.int64) if faces is None else _triangles(np.asarray(faces), np.asarray(g["vertices"]))
    colors = None
    if g.get("face_colors") is not None and len(g["face_colors"]) == len(triangles) and len(triangles):
        colors = rgba(g["face_colors"], is_srgb=True)
    elif g.get("vertex_colors") is not None and len(g["vertex_colors"]) == len(g["vertices"]) and len(triangles):
        colors = rgba(g["vertex_colors"], is_srgb=True)[triangles].mean(axis=1)
    return RawPiece(g["vertices"], triangles, g.get("vertex_normals"), None, colors)


def _triangles(faces: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """The loader leaves files of only quads (or only n-gons) as (F, n)."""
    if faces.ndim == 2 and faces.shape[1] > 3 and faces.size and faces.min() >= 0 and faces.max() < len(vertices):
        corners, _ = triangulate(vertices[faces.ravel()].astype(np.float64), np.full(len(faces), faces.shape[1]))
        return faces.ravel()[corners]
    return faces.reshape(-1, 3)
