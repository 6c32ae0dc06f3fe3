"""Wavefront OBJ, read here: trimesh's reader joins the names of parts and materials, misreads relative indices of files with several
parts, and cuts polygons that are not convex wrongly. Lines are sorted by their first word in Python, numbers are read by numpy.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..cad_model import CadMaterial
from ..plain_text import shown_name
from .cad_format import CadFormat, Likeness
from .colors import rgba
from .companions import companion
from .mtl import read_mtl
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece
from .text_numbers import numbers, table


@dataclass(eq=False)
class _Run:
    """Faces of one part and material. `counts` of vertices and normals so far, where the faces count backwards from there; else None."""

    part: bytes
    material: bytes | None
    counts: tuple[int, int] | None
    faces: list[bytes] = field(default_factory=list)


@dataclass(eq=False)
class _Lines:
    """The lines of a file by kind."""

    vertices: list[bytes] = field(default_factory=list)
    normals: list[bytes] = field(default_factory=list)
    runs: dict[tuple, _Run] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)


def read_obj(path: Path) -> RawFile:
    """An `.obj` file with its `.mtl` files; parts are the `o` groups, or the `g` groups of a file without any `o`."""
    lines = _sorted_lines(path.read_bytes().replace(b"\\\r\n", b" ").replace(b"\\\n", b" "), path.stem)
    raw = RawFile()
    _add_materials(raw, path, lines.libraries)
    vertices = table(lines.vertices, 3)
    normals = table(lines.normals, 3)[:, :3]
    for run in lines.runs.values():
        piece = _piece(run, vertices, normals, raw.materials)
        if run.part not in raw.meshes:
            name = run.part.decode("utf-8", "replace")
            raw.meshes[run.part] = (name, [])
            raw.nodes.append(RawNode(name, mesh=run.part))
        raw.meshes[run.part][1].append(piece)
    return raw


def _sorted_lines(data: bytes, stem: str) -> _Lines:
    out = _Lines()
    by_object = b"\no " in data or data.startswith(b"o ") or b"\no\t" in data
    part, material, run = stem.encode("utf-8", "surrogateescape"), None, None
    for line in data.split(b"\n"):
        words = line.split(None, 1)
        if len(words) < 2:
            continue
        word, rest = words
        if word == b"v":
            out.vertices.append(rest)
        elif word == b"f":
            counts = (len(out.vertices), len(out.normals)) if b"-" in rest else None
            if run is None or run.counts != counts:
                run = out.runs.setdefault((part, material, counts), _Run(part, material, counts))
            run.faces.append(rest)
        elif word == b"vn":
            out.normals.append(rest)
        elif word == b"usemtl":
            material, run = rest.strip(), None
        elif word == (b"o" if by_object else b"g"):
            part, run = rest.strip(), None
        elif word == b"mtllib":
            out.libraries.append(rest.strip().decode("utf-8", "surrogateescape"))
    return out


def _add_materials(raw: RawFile, path: Path, libraries: list[str]) -> None:
    """Read the material files; a line in the warnings says which of them cannot be."""
    for name in dict.fromkeys(libraries):
        file, title = companion(path, name), shown_name(name)
        if file is None:
            raw.warnings.append(f"The material file {title} is missing: parts are grey. Put it beside {path.name}.")
            continue
        try:
            raw.materials.update(read_mtl(file))
        except OSError as error:
            raw.warnings.append(f"The material file {title} is not read ({error.strerror}): parts are grey.")


def _piece(run: _Run, vertices: np.ndarray, normals: np.ndarray, materials: dict[object, CadMaterial]) -> RawPiece:
    """The run's faces as triangles on the vertices (and normals) they use."""
    index, sizes = _corners(run)
    vertex = _resolved(index[:, 0], run.counts and run.counts[0], len(vertices))
    normal = _resolved(index[:, 2], run.counts and run.counts[1], len(normals)) if index.shape[1] > 2 else np.full(len(vertex), -1)
    has_normals = len(normals) > 0 and bool((normal >= 0).all())
    pairs, of_corner = np.unique(vertex * (len(normals) + 1) + normal if has_normals else vertex, return_inverse=True)
    used = pairs // (len(normals) + 1) if has_normals else pairs
    positions = np.where((used >= 0)[:, None], vertices[np.maximum(used, 0), :3], np.nan)
    triangles, _ = triangulate(positions[of_corner], sizes)
    triangles = of_corner[triangles].reshape(-1, 3)
    own = normals[pairs % (len(normals) + 1)] if has_normals else None
    material = run.material if run.material in materials else None
    colors = None
    if material is None and vertices.shape[1] >= 6 and len(triangles):
        colors = rgba(vertices[np.maximum(used, 0), 3:6], is_srgb=True)[triangles]
    return RawPiece(positions, triangles, own, material, colors)


def _corners(run: _Run) -> tuple[np.ndarray, np.ndarray]:
    """(C, k) indices as written (k = 1: vertex; 3: vertex, texture, normal; 0 where left out) and the (F,) corners of each face."""
    faces = [line.split(b"#")[0] if b"#" in line else line for line in run.faces]
    sizes = np.array([len(line.split()) for line in faces], dtype=np.int64)
    text, count = b" ".join(faces), int(sizes.sum())
    if b"/" not in text:
        return numbers(text, np.int64).reshape(count, 1), sizes
    text = text.replace(b"//", b"/0/")
    if text.count(b"/") == 2 * count:
        return numbers(text.replace(b"/", b" "), np.int64).reshape(count, 3), sizes
    rows = [(*(int(i or 0) for i in corner.split(b"/")), 0, 0)[:3] for corner in text.split()]
    return np.array(rows, dtype=np.int64).reshape(count, 3), sizes


def _resolved(index: np.ndarray, count: int | None, total: int) -> np.ndarray:
    """0-based indices; −1 where there is none or it points outside. Negative ones count back from `count`."""
    zero_based = np.where(index > 0, index - 1, index + (count or 0))
    return np.where((index != 0) & (zero_based >= 0) & (zero_based < total), zero_based, -1)


def likeness(head: bytes, _size: int) -> Likeness:
    """A text with a line that begins with one of the format's words, or of comments alone so far."""
    if b"\x00" in head:
        return Likeness.NO
    is_comment = b"#" in head and not re.sub(rb"#[^\n]*", b"", head).strip(b"\xef\xbb\xbf \t\r\n")
    has_word = re.search(rb"(?m)^\s*(v|vn|vt|f|o|g|mtllib|usemtl)\s", head)
    return Likeness.MAYBE if is_comment or has_word else Likeness.NO


ROW = CadFormat("OBJ", {".obj": likeness}, read_obj, place=30, up="Y")
