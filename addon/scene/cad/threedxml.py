"""3DXML of Dassault Systèmes with tessellated shapes, read here: trimesh's reader needs lxml and networkx. Shapes in the makers' own binary
form are counted and named. Source: 3D XML User's Guide 4.3."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...errors import CadFileError
from ...images.srgb import linear_from_srgb
from ..cad_model import CadMaterial
from .cad_format import CadFormat, Likeness
from .losses import Losses
from .raw import RawFile, RawNode, RawPiece
from .text_numbers import numbers

MOST_BYTES, MOST_PARTS, MOST_DEPTH = 2 << 30, 1 << 18, 64
Element = ElementTree.Element
Color = tuple[float, float, float, float]


def read_3dxml(path: Path) -> RawFile:
    """A `.3dxml` package: its product structure, and the polygons of its parts in millimetres."""
    with zipfile.ZipFile(path) as archive:
        if sum(one.file_size for one in archive.infolist()) > MOST_BYTES:
            raise CadFileError(f"{path.name} unpacks to more than {MOST_BYTES >> 30} GiB: split it.")
        package = _Products(archive, path)
        package.place_roots()
    package.raw.warnings += package.losses.lines(path.name)
    return package.raw


def _local(element: Element) -> str:
    return element.tag.rpartition("}")[2]


def _below(element: Element, *tags: str) -> list[Element]:
    return [one for one in element if _local(one) in tags]


def _text(element: Element, tag: str) -> str:
    return next(((one.text or "").strip() for one in element if _local(one) == tag), "")


class _Products:
    """The structure of a package: references by (file, id), what stands in each, and the shapes they show."""

    def __init__(self, archive: zipfile.ZipFile, path: Path) -> None:
        self.raw, self.losses = RawFile(units="mm"), Losses()
        self._archive, self._path = archive, path
        self._names = {name.lower(): name for name in archive.namelist()}
        self._references: dict[tuple[str, str], Element] = {}
        self._within: dict[tuple[str, str], list[tuple[Element, str]]] = {}
        self._roots: list[tuple[str, str]] = []
        self._pieces: dict[str, list[RawPiece] | None] = {}
        for name in archive.namelist():
            if name.lower().endswith(".3dxml") or (name.lower().endswith(".xml") and name.lower() != "manifest.xml"):
                self._add(name)

    def _add(self, file: str) -> None:
        """One document of the package."""
        root = ElementTree.fromstring(self._archive.read(file))
        for structure in (one for one in root.iter() if _local(one) == "ProductStructure"):
            for one in structure:
                kind, number = _local(one), one.get("id", "")
                if kind in ("Reference3D", "ReferenceRep"):
                    self._references[file, number] = one
                elif kind in ("Instance3D", "InstanceRep"):
                    self._within.setdefault((file, _text(one, "IsAggregatedBy").rpartition(":")[2]), []).append((one, file))
            if structure.get("root"):
                self._roots.append((file, structure.get("root", "")))

    def place_roots(self) -> None:
        """All that stands below the roots; where none is named, below what stands in nothing else."""
        used = {self._target(one, file) for inside in self._within.values() for one, file in inside}
        roots = [key for key in self._roots if key in self._references]
        roots = roots or [key for key, one in self._references.items() if _local(one) == "Reference3D" and key not in used]
        for key in dict.fromkeys(roots):
            self._place(key, _name(self._references[key]), -1, None, 0)

    def _target(self, instance: Element, file: str) -> tuple[str, str]:
        """What an instance is one of: a number, `urn:3DXML:Reference:loc:3`, or `urn:3DXML:other.3dxml#3`."""
        link = _text(instance, "IsInstanceOf")
        other, mark, number = link.removeprefix("urn:3DXML:").rpartition("#")
        return (self._names.get(other.lower(), other), number) if mark else (file, link.rpartition(":")[2])

    def _place(self, key: tuple[str, str], name: str, parent: int, matrix: np.ndarray | None, depth: int) -> None:
        """A reference with its shapes and all that stands in it."""
        if depth > MOST_DEPTH:
            raise CadFileError(f"{self._path.name} nests its products more than {MOST_DEPTH} deep, or within themselves: export it again.")
        if len(self.raw.nodes) >= MOST_PARTS:
            raise CadFileError(f"{self._path.name} places more than {MOST_PARTS:,} parts: split it.")
        index = len(self.raw.nodes)
        self.raw.nodes.append(RawNode(name, parent, self._shape(key, name), matrix))
        for instance, file in self._within.get(key, ()):
            if _local(instance) == "InstanceRep":
                continue
            target, own = self._target(instance, file), instance.get("name")
            if target not in self._references:
                self.losses.add("product{s} that are not in the package", own or target[0])
                continue
            self._place(target, own or _name(self._references[target]), index, _matrix(_text(instance, "RelativeMatrix")), depth + 1)

    def _shape(self, key: tuple[str, str], name: str) -> object | None:
        """The key of the mesh of all shapes of a reference."""
        if key not in self.raw.meshes:
            pieces = []
            for instance, file in self._within.get(key, ()):
                shape = self._references.get(self._target(instance, file))
                if _local(instance) == "InstanceRep" and shape is not None:
                    pieces += self._polygons(shape.get("associatedFile", "").rpartition(":")[2], name)
            if not pieces:
                return None
            self.raw.meshes[key] = (_name(self._references[key]), pieces)
        return key

    def _polygons(self, file: str, owner: str) -> list[RawPiece]:
        """The pieces of a shape's file."""
        if file not in self._pieces:
            inside = self._names.get(file.lower())
            data = b"" if inside is None else self._archive.read(inside)
            is_text = data.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"<")
            self._pieces[file] = _pieces(ElementTree.fromstring(data), self.raw) if is_text else None
        found = self._pieces[file]
        if found is None:
            self.losses.add("shape{s} in a binary form that only Dassault's programs read", owner)
        return found or []


def _name(reference: Element) -> str:
    return _text(reference, "V_Name") or reference.get("name") or f"Reference {reference.get('id', '')}"


def _matrix(text: str) -> np.ndarray | None:
    """Twelve numbers: the images of X, Y and Z, then the place."""
    values = np.array(text.split(), np.float64)
    if values.size != 12:
        return None
    out = np.eye(4)
    out[:3] = values.reshape(4, 3).T
    return out


def _pieces(root: Element, raw: RawFile) -> list[RawPiece]:
    """The finest polygons of every representation in a file, each with the colour of its face, else of what holds it."""
    out: list[RawPiece] = []
    stack: list[tuple[Element, Color | None]] = [(root, None)]
    while stack:
        element, color = stack.pop()
        color = _color(element) or color
        stack += [(one, color) for one in reversed(element) if _local(one) in ("Root", "Rep", "Representation")]
        buffer = next(iter(_below(element, "VertexBuffer")), None)
        levels = [element, *sorted(_below(element, "PolygonalLOD"), key=lambda one: float(one.get("accuracy", "0")))]
        faces = next((_below(level, "Faces") for level in levels if _below(level, "Faces")), [])
        if buffer is not None and faces:
            out += _faces(buffer, faces, color, raw)
    return out


def _faces(buffer: Element, groups: list[Element], color: Color | None, raw: RawFile) -> list[RawPiece]:
    positions = numbers(_text(buffer, "Positions").replace(",", " ").encode(), np.float64)
    positions = positions[: len(positions) // 3 * 3].reshape(-1, 3)
    normals = numbers(_text(buffer, "Normals").replace(",", " ").encode(), np.float64)
    own = normals.reshape(-1, 3) if normals.size == positions.size else None
    by_color: dict[Color | None, list[np.ndarray]] = {}
    for group in groups:
        of_group = _color(group) or color
        for face in _below(group, "Face"):
            by_color.setdefault(_color(face) or of_group, []).append(_triangles(face))
    return [RawPiece(positions, np.concatenate(found), own, _material(of, raw)) for of, found in by_color.items()]


def _triangles(face: Element) -> np.ndarray:
    """(T, 3) of a face's triangles, strips and fans; a comma begins another strip or fan."""
    whole = numbers(re.sub(",", " ", face.get("triangles", "")).encode(), np.int64)
    out = [whole[: len(whole) // 3 * 3].reshape(-1, 3)]
    for kind in ("strips", "fans"):
        for text in face.get(kind, "").split(","):
            index = numbers(text.encode(), np.int64)
            i = np.arange(max(len(index) - 2, 0))
            odd = i % 2
            chosen = [i, i + 1 + odd, i + 2 - odd] if kind == "strips" else [np.zeros_like(i), i + 1, i + 2]
            out.append(index[np.stack(chosen, axis=1)] if len(i) else np.empty((0, 3), np.int64))
    return np.concatenate(out)


def _color(element: Element) -> Color | None:
    """The colour that an element gives what it holds."""
    for attributes in _below(element, "SurfaceAttributes"):
        for color in _below(attributes, "Color"):
            red, green, blue, alpha = (min(max(float(color.get(k, "1")), 0.0), 1.0) for k in ("red", "green", "blue", "alpha"))
            return red, green, blue, alpha
    return None


def _material(color: Color | None, raw: RawFile) -> object | None:
    if color is None:
        return None
    linear = linear_from_srgb(np.array(color[:3]))
    name = "Color " + "".join(f"{round(255 * c):02x}" for c in color[:3])
    raw.materials.setdefault(color, CadMaterial(name, (*(float(c) for c in linear), color[3])))
    return color


def _is_archive(head: bytes, _size: int) -> Likeness:
    return Likeness.BINARY if head.startswith(b"PK\x03\x04") else Likeness.NO


ROW = CadFormat("3DXML", {".3dxml": _is_archive}, read_3dxml, place=110, unit="mm", fixes_unit=True)
