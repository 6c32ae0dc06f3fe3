"""OFF, read here: trimesh's reader stops at files that mix polygons of more than four corners with others."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .cad_format import CadFormat, starts_text
from .colors import rgba
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece
from .text_numbers import table


def read_off(path: Path) -> RawFile:
    """A text `.off` file (also COFF and the like: of each vertex only the position and a colour behind it are read)."""
    text = re.sub(rb"#[^\n]*", b"", path.read_bytes())
    kind, body = re.match(rb"\s*([A-Z0-9]*OFF)\b(.*)", text, re.DOTALL).groups()
    lines = [line for line in body.split(b"\n") if line.strip()]
    vertex_count, face_count = (int(word) for word in lines[0].split()[:2])
    if min(vertex_count, face_count) < 0 or vertex_count + face_count >= len(lines):
        raise ValueError(f"{vertex_count} vertices and {face_count} faces are announced, {len(lines) - 1} lines follow")
    vertices = table(lines[1 : vertex_count + 1], 3)
    faces = [line.split() for line in lines[vertex_count + 1 : vertex_count + face_count + 1]]
    sizes = np.array([int(face[0]) for face in faces], dtype=np.int64)
    corners = np.array([int(word) for face in faces for word in face[1 : int(face[0]) + 1]], dtype=np.int64)
    if len(corners) != sizes.sum() or (len(corners) and not 0 <= corners.min() <= corners.max() < vertex_count):
        raise ValueError("a face uses a vertex that is not there")
    triangles, _ = triangulate(vertices[corners, :3], sizes)
    triangles = corners[triangles].reshape(-1, 3)
    colors = _vertex_colors(kind, vertices)
    per_corner = None if colors is None or not len(triangles) else colors[triangles]
    raw = RawFile(meshes={path: (path.stem, [RawPiece(vertices[:, :3], triangles, None, None, per_corner)])})
    raw.nodes.append(RawNode(path.stem, mesh=path))
    return raw


def _vertex_colors(kind: bytes, vertices: np.ndarray) -> np.ndarray | None:
    """(V, 4) linear colours of a COFF file, whose channels run to 1 or to 255."""
    if kind != b"COFF" or vertices.shape[1] < 6:
        return None
    channels = vertices[:, 3:7]
    return rgba(channels / 255.0 if channels.max() > 1.0 else channels, is_srgb=True)


ROW = CadFormat("OFF", {".off": starts_text(rb"(?:\s|#[^\n]*\n)*[A-Z0-9]{0,4}OFF\b")}, read_off, place=50)
