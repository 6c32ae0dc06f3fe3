"""PLY, read here: trimesh's reader needs scipy for files with edges, stops at binary ones of mixed polygons, and knows no strips."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..plain_text import shown_name
from .cad_format import CadFormat, starts_text
from .colors import of_faces, rgba
from .ply_elements import Columns, Lists, ply_elements
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece

COLORS = (("red", "green", "blue", "alpha"), ("diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"), ("r", "g", "b", "a"))
KNOWN = ("vertex", "face", "tristrips", "edge", "material")


def read_ply(path: Path) -> RawFile:
    """A `.ply` file: its faces and strips of triangles, with the colours and normals of its vertices or the colours of its faces."""
    elements = ply_elements(path.read_bytes())
    vertices = elements.get("vertex", {})
    if not all(axis in vertices for axis in "xyz"):
        raise ValueError("it has no vertices with x, y and z")
    positions = _table(vertices, "xyz")
    raw = RawFile(meshes={path: (path.stem, [_piece(elements, vertices, positions)])}, nodes=[RawNode(path.stem, mesh=path)])
    left = [f"{name} ({_count(columns)})" for name, columns in elements.items() if name not in KNOWN and _count(columns)]
    if left:
        raw.warnings.append(f"{path.name} also holds what is not drawn: {shown_name(', '.join(left))}.")
    return raw


def _count(columns: Columns) -> int:
    first = next(iter(columns.values()), ())
    return len(first.sizes if isinstance(first, Lists) else first)


def _table(columns: Columns, names: str | tuple[str, ...]) -> np.ndarray:
    """(N, len(names)) float64 of these columns."""
    return np.stack([np.asarray(columns[name], dtype=np.float64) for name in names], axis=1)


def _piece(elements: dict[str, Columns], vertices: Columns, positions: np.ndarray) -> RawPiece:
    faces = elements.get("face", {})
    polygons = _lists(faces) or Lists(np.zeros(0, np.int64), np.zeros(0, np.int64))
    corners = _resolved(polygons.values, len(positions))
    points = np.where((corners >= 0)[:, None], positions[np.maximum(corners, 0)] if len(positions) else np.nan, np.nan)
    triangles, polygon = triangulate(points, polygons.sizes)
    triangles = np.concatenate([corners[triangles].reshape(-1, 3), _strips(elements.get("tristrips", {}), len(positions))])
    normals = _table(vertices, ("nx", "ny", "nz")) if all(name in vertices for name in ("nx", "ny", "nz")) else None
    colors, own = None, _colors(faces)
    if own is not None and len(polygon) == len(triangles):
        colors = of_faces(own[polygon])
    elif (own := _colors(vertices)) is not None and len(triangles):
        colors = own[np.maximum(triangles, 0)]
    return RawPiece(positions, triangles, normals, None, colors)


def _lists(columns: Columns) -> Lists | None:
    """The corners of faces or strips; None where there are none."""
    lists = columns.get("vertex_indices", columns.get("vertex_index"))
    if lists is None or isinstance(lists, Lists):
        return lists
    raise ValueError("its faces are no lists of vertices")


def _resolved(index: np.ndarray, count: int) -> np.ndarray:
    """int64 indices; −1 for what names no vertex."""
    named = np.asarray(index, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        return np.where((named >= 0) & (named < count), named, -1.0).astype(np.int64)


def _strips(columns: Columns, count: int) -> np.ndarray:
    """(T, 3) the triangles of all strips, every other one turned; a negative index begins another strip."""
    lists = _lists(columns)
    if lists is None:
        return np.empty((0, 3), np.int64)
    index, place = _resolved(lists.values, count), np.arange(len(lists.values))
    begins = np.zeros(len(index) + 1, bool)
    begins[np.cumsum(lists.sizes) - lists.sizes] = True
    cut = np.asarray(lists.values) < 0
    last_start = np.maximum.accumulate(np.where(cut, place + 1, np.where(begins[:-1], place, 0)))
    third = np.flatnonzero((place - last_start >= 2) & ~cut)
    triangles = np.stack([index[third - 2], index[third - 1], index[third]], axis=1)
    odd = (third - last_start[third]) % 2 == 1
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    return triangles


def _colors(columns: Columns) -> np.ndarray | None:
    """(N, 4) linear colours of an element's rows; None where it has none."""
    for names in COLORS:
        own = [name for name in names if name in columns and not isinstance(columns[name], Lists)]
        if own[:3] == list(names[:3]):
            channels = np.stack([np.asarray(columns[name]) for name in own], axis=1)
            is_bytes = channels.dtype.kind == "f" and len(channels) > 0 and bool(np.nanmax(channels) > 1.0)  # floats that run to 255
            return rgba(channels / 255.0 if is_bytes else channels, is_srgb=True)
    return None


ROW = CadFormat("PLY", {".ply": starts_text(rb"ply[ \t]*\r?\n")}, read_ply, place=40)
