"""OFF, read here: trimesh's reader stops at files that mix polygons of more than four corners with others."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from .cad_format import CadFormat, starts_text
from .colors import of_faces, rgba
from .losses import Losses
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece
from .text_numbers import numbers, table, words_per_line


def read_off(path: Path) -> RawFile:
    """A text `.off` file (also COFF, NOFF and the like): positions, and the colours of vertices or faces."""
    text = re.sub(rb"#[^\n]*", b"", path.read_bytes().removeprefix(b"\xef\xbb\xbf").replace(b"\r", b"\n"))
    head = re.match(rb"\s*([A-Z0-9]*OFF)\b(.*)", text, re.DOTALL)
    if head is None:
        raise ValueError("it does not begin with OFF")
    kind, body = head.groups()
    if re.match(rb"\s*BINARY\b", body):
        raise ValueError("it is a binary OFF, which is not read: export it as text")
    lines = [line for line in body.split(b"\n") if line.strip()]
    vertex_count, face_count = (int(word) for word in b" ".join(lines[:3]).split()[:2])
    if min(vertex_count, face_count) < 0:
        raise ValueError(f"{vertex_count} vertices and {face_count} faces are announced")
    first = 1 if len(lines[0].split()) > 1 else 3
    is_by_lines = len(lines) >= first + vertex_count + face_count
    read = _by_lines if is_by_lines else _by_words
    vertices, sizes, corners, colors = read(lines[first:] if is_by_lines else lines, vertex_count, face_count)
    if len(corners) and not 0 <= corners.min() <= corners.max() < vertex_count:
        raise ValueError("a face uses a vertex that is not there")
    piece = _piece(kind, vertices, sizes, corners, colors)
    raw, losses = RawFile(meshes={path: (path.stem, [piece])}, nodes=[RawNode(path.stem, mesh=path)]), Losses()
    losses.add("line{s} and points among its faces", path.stem, int((sizes < 3).sum()))
    raw.warnings += losses.lines(path.name)
    return raw


def _by_lines(lines: list[bytes], vertex_count: int, face_count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """Vertices, how many corners each face has, the corners, and the faces' colours; each has a line, what stands behind is a colour."""
    vertices = table(b"\n".join([*lines[:vertex_count], b""]), 3)
    text = b"\n".join([*lines[vertex_count : vertex_count + face_count], b""]) if face_count else b""
    values = numbers(text, np.float64)
    width = words_per_line(text) if text else np.zeros(0, np.int64)
    if len(values) != width.sum():
        raise ValueError("something stands where a number should")
    begins = np.cumsum(width) - width
    sizes = values[begins].astype(np.int64)
    if (sizes < 0).any() or (sizes + 1 > width).any():
        raise ValueError("a face has fewer corners than it announces")
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    corners = values[np.repeat(begins + 1, sizes) + within].astype(np.int64)
    return vertices, sizes, corners, _face_colors(values, begins + 1 + sizes, width - 1 - sizes)


def _face_colors(values: np.ndarray, begins: np.ndarray, counts: np.ndarray) -> np.ndarray | None:
    """(F, 4) linear; grey for faces without three or four numbers behind their corners; None where no face has them."""
    has = counts >= 3
    if not has.any():
        return None
    rows = values[np.minimum(begins[:, None] + np.arange(4), len(values) - 1)]
    rows[counts < 4, 3] = 255.0 if rows[has, :3].max() > 1.0 else 1.0
    colors = rgba(rows / 255.0 if rows[has].max() > 1.0 else rows, is_srgb=True)
    colors[~has] = (0.8, 0.8, 0.8, 1.0)
    return colors


def _by_words(lines: list[bytes], vertex_count: int, face_count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, None]:
    """The same where lines mean nothing: three numbers for each vertex, and faces without colours."""
    values = numbers(b" ".join(lines), np.float64)
    end = 3 + 3 * vertex_count
    if end > len(values):
        raise ValueError(f"{vertex_count} vertices and {face_count} faces are announced, the file ends before")
    begins, at = [], end
    for _ in range(face_count):
        if at >= len(values) or not 0 <= values[at] <= len(values) - at - 1:
            raise ValueError(f"{face_count} faces are announced, the file ends before")
        begins.append(at)
        at += 1 + int(values[at])
    sizes = np.array([after - begin - 1 for begin, after in pairwise([*begins, at])], dtype=np.int64)
    places = np.concatenate([np.arange(b + 1, b + 1 + n) for b, n in zip(begins, sizes.tolist(), strict=True)] or [np.zeros(0, np.int64)])
    return values[3:end].reshape(-1, 3), sizes, values[places].astype(np.int64), None


def _piece(kind: bytes, vertices: np.ndarray, sizes: np.ndarray, corners: np.ndarray, face_colors: np.ndarray | None) -> RawPiece:
    flat, polygon = triangulate(vertices[corners, :3], sizes)
    triangles = corners[flat].reshape(-1, 3)
    own = _vertex_colors(kind, vertices)
    colors = None
    if face_colors is not None:
        colors = of_faces(face_colors[polygon])
    elif own is not None and len(triangles):
        colors = own[triangles]
    return RawPiece(vertices[:, :3], triangles, None, None, colors)


def _vertex_colors(kind: bytes, vertices: np.ndarray) -> np.ndarray | None:
    """(V, 4) linear colours of a COFF file, behind the normals where it has such; channels run to 1 or to 255."""
    first = 6 if b"N" in kind else 3
    if b"C" not in kind or vertices.shape[1] < first + 3:
        return None
    channels = vertices[:, first : first + 4]
    return rgba(channels / 255.0 if channels.max() > 1.0 else channels, is_srgb=True)


ROW = CadFormat("OFF", {".off": starts_text(rb"(?:\s|#[^\n]*\n)*[A-Z0-9]{0,4}OFF\b")}, read_off, place=50)
