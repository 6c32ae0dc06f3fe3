"""Wavefront OBJ, read here: trimesh's reader joins the names of parts and materials, misreads relative indices of files with several
parts, and cuts polygons that are not convex wrongly.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..cad_model import CadMaterial
from ..plain_text import shown_name
from .cad_format import CadFormat, Likeness
from .colors import rgba
from .companions import companion
from .losses import Losses
from .mtl import read_mtl, text_of
from .obj_lines import COMMENT, Faces, ObjLines, obj_lines
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece
from .text_numbers import numbers, table, with_points, word_begins, words_per_line

SLASH_AT_END = re.compile(rb"/(?=[\s/])")


def read_obj(path: Path) -> RawFile:
    """An `.obj` file with its `.mtl` files; parts are the `o` groups, or the `g` groups of a file without any `o`."""
    lines, losses = obj_lines(path.read_bytes()), Losses()
    raw = RawFile()
    _add_materials(raw, path, lines.libraries, losses)
    tables, corners = _Tables(lines, path, raw), _corners_of(list(lines.faces.values()))
    for faces in lines.faces.values():
        if faces.part not in raw.meshes:
            own = lines.parts[faces.part]
            name = path.stem if own is None else text_of(own)
            raw.meshes[faces.part] = (name, [])
            raw.nodes.append(RawNode(name, mesh=faces.part))
        raw.meshes[faces.part][1].append(tables.piece(faces, *corners(faces), raw.materials))
    for kind, part in lines.lost:
        own = lines.parts[part]
        losses.add(kind, path.stem if own is None else text_of(own))
    raw.warnings += losses.lines(path.name)
    return raw


def _add_materials(raw: RawFile, path: Path, libraries: list[bytes], losses: Losses) -> None:
    """Read the material files; a line in the warnings says which of them cannot be."""
    for file, title in _material_files(path, libraries):
        if file is None:
            raw.warnings.append(f"The material file {title} is missing: parts are grey. Put it beside {path.name}.")
            continue
        try:
            raw.materials.update(read_mtl(file, losses))
        except OSError as error:
            raw.warnings.append(f"The material file {title} is not read ({error.strerror}): parts are grey.")


def _material_files(path: Path, libraries: list[bytes]) -> list[tuple[Path | None, str]]:
    """The files that the lines name, each a name with blanks or several without, and how to call them; what is called like the model stands
    in for one that is missing or not named."""
    found: dict[str, Path | None] = {}
    for line in libraries:
        words = [] if _companion(path, line) is not None else line.split()
        names = words if any(_companion(path, word) is not None for word in words) else [line]
        found.update({shown_name(text_of(name)): _companion(path, name) for name in names})
    own = path.with_suffix(".mtl")
    if (not found or None in found.values()) and own not in found.values() and own.is_file():
        found = {**{title: file for title, file in found.items() if file is not None}, own.name: own}
    return [(file, title) for title, file in found.items()]


def _companion(path: Path, name: bytes) -> Path | None:
    """The file of a name as its bytes say, else in the letters that Windows programs write."""
    return companion(path, name.decode("utf-8", "surrogateescape")) or companion(path, text_of(name))


class _Tables:
    """The numbers of a file that its faces refer to."""

    def __init__(self, lines: ObjLines, path: Path, raw: RawFile) -> None:
        self._lines = lines
        self.vertices = table(with_points(_plain(lines.vertices, b"v"), path.name, raw.warnings), 3)
        self.normals = table(_plain(lines.normals, b"vn"), 3)[:, :3]
        self._texture: np.ndarray | None = None

    @property
    def texture(self) -> np.ndarray:
        """(N, 2) texture coordinates, read when they are asked for."""
        if self._texture is None:
            self._texture = table(_plain(self._lines.texture, b"vt"), 2)[:, :2]
        return self._texture

    def piece(self, faces: Faces, index: np.ndarray, sizes: np.ndarray, materials: dict[object, CadMaterial]) -> RawPiece:
        """The faces, by the indices of their corners, as triangles on the vertices (and normals) they use."""
        vertex = _resolved(index[:, 0], len(self.vertices))
        normal = _resolved(index[:, 2], len(self.normals)) if index.shape[1] > 2 else np.full(len(vertex), -1)
        has_normals = len(self.normals) > 0 and bool((normal >= 0).all())
        pairs, of_corner = np.unique(vertex * (len(self.normals) + 1) + normal if has_normals else vertex, return_inverse=True)
        used = pairs // (len(self.normals) + 1) if has_normals else pairs
        positions = np.where((used >= 0)[:, None], self.vertices[np.maximum(used, 0), :3], np.nan)
        corners, _ = triangulate(positions[of_corner], sizes)
        triangles = of_corner[corners].reshape(-1, 3)
        own = self.normals[pairs % (len(self.normals) + 1)] if has_normals else None
        material = faces.material if faces.material in materials else None
        colors = self._colors(used, triangles) if material is None else None
        has_image = material is not None and materials[material].image is not None
        uvs = self._uvs(index, corners) if has_image and index.shape[1] > 1 else None
        return RawPiece(positions, triangles, own, material, colors, uvs)

    def _colors(self, used: np.ndarray, triangles: np.ndarray) -> np.ndarray | None:
        """(T, 3, 4) the colours behind the coordinates, which run to 1 or to 255."""
        if self.vertices.shape[1] < 6 or not len(triangles):
            return None
        channels = self.vertices[np.maximum(used, 0), 3:6]
        return rgba(channels / 255.0 if np.nanmax(channels) > 1.0 else channels, is_srgb=True)[triangles]

    def _uvs(self, index: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
        """(T, 3, 2) texture coordinates; 0 where a corner names none."""
        named = _resolved(index[:, 1], len(self.texture))
        if not len(self.texture):
            return None
        return np.where((named >= 0)[:, None], np.nan_to_num(self.texture[np.maximum(named, 0)]), 0.0)[corners]


def _plain(runs: list[bytes], word: bytes) -> bytes:
    """Lines without the word that they begin with, and without comments."""
    text = b"".join(runs)
    return (COMMENT.sub(b"", text) if b"#" in text else text).replace(word, b" ")


def _corners_of(groups: list[Faces]) -> Callable[[Faces], tuple[np.ndarray, np.ndarray]]:
    """What gives the corners of each group: read all together where they are written alike, as numpy costs microseconds per call."""
    texts = [_plain(faces.chunks, b"f") for faces in groups]
    whole = b"".join(texts)
    slashes, has_relative = whole.count(b"/"), b"-" in whole
    if has_relative or len(groups) < 2 or not whole:
        return _corners
    sizes = words_per_line(whole)
    total = int(sizes.sum())
    if slashes not in (0, total, 2 * total) or SLASH_AT_END.search(whole):
        return _corners
    index = _indices(whole, total)
    lines = np.cumsum([0, *(text.count(b"\n") for text in texts)])
    firsts = np.concatenate([[0], np.cumsum(sizes)])[lines]
    place = {id(faces): k for k, faces in enumerate(groups)}

    def own(faces: Faces) -> tuple[np.ndarray, np.ndarray]:
        k = place[id(faces)]
        return index[firsts[k] : firsts[k + 1]], sizes[lines[k] : lines[k + 1]]

    return own


def _corners(faces: Faces) -> tuple[np.ndarray, np.ndarray]:
    """(C, k) indices from 1 on (k = 1: vertex; 2, 3: texture, normal), 0 where there is none; and the (F,) corners of each face."""
    text = _plain(faces.chunks, b"f")
    sizes = words_per_line(text)
    index = _indices(text, int(sizes.sum()))
    if b"-" in text:
        lines = np.array([chunk.count(b"\n") for chunk in faces.chunks])
        before = np.repeat(np.repeat(np.array(faces.before), lines, axis=0), sizes, axis=0)[:, : index.shape[1]]
        index = np.where(index < 0, np.maximum(index + before + 1, 0), index)
    return index, sizes


def _indices(text: bytes, count: int) -> np.ndarray:
    """(C, k) the indices as written, 0 where one is left out."""
    if b"/" not in text:
        return numbers(text, np.int64).reshape(count, 1)
    text = SLASH_AT_END.sub(b"/0", text)
    slashes = text.count(b"/")
    if slashes in (count, 2 * count):
        width = slashes // count + 1
        per_word = numbers(text.replace(b"/", b" "), np.int64)
        if len(per_word) == count * width and _are_even(text, width - 1):
            return per_word.reshape(count, width)
    rows = [(*(int(i or 0) for i in corner.split(b"/")), 0, 0)[:3] for corner in text.split()]
    return np.array(rows, dtype=np.int64).reshape(count, 3)


def _are_even(text: bytes, slashes: int) -> bool:
    """Whether every word of a text has that many slashes."""
    raw = np.frombuffer(text, np.uint8)
    words = word_begins(raw)
    before = np.searchsorted(np.flatnonzero(raw == ord("/")), words)
    return bool((before == slashes * np.arange(len(words))).all())


def _resolved(index: np.ndarray, total: int) -> np.ndarray:
    """0-based indices; −1 where there is none or it points outside."""
    return np.where((index > 0) & (index <= total), index - 1, -1)


def likeness(head: bytes, _size: int) -> Likeness:
    """A text with a line that begins with one of the format's words, or of comments alone so far."""
    if b"\x00" in head:
        return Likeness.NO
    is_comment = b"#" in head and not re.sub(rb"#[^\n]*", b"", head).strip(b"\xef\xbb\xbf \t\r\n")
    has_word = re.search(rb"(?m)^\s*(v|vn|vt|f|o|g|mtllib|usemtl)\s", head)
    return Likeness.MAYBE if is_comment or has_word else Likeness.NO


ROW = CadFormat("OBJ", {".obj": likeness}, read_obj, place=30, up="Y")
