"""3MF core specification with the materials extension's colours, on the standard library (trimesh's reader needs lxml and networkx, which
Blender lacks). Source: 3MF Core Specification 1.3, Materials and Properties Extension 1.2.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...errors import CadFileError
from ...images.srgb import linear_from_srgb
from ..cad_model import CadMaterial
from ..plain_text import shown_name
from .cad_format import CadFormat, starts
from .losses import Losses
from .raw import RawFile, RawNode, RawPiece

MAX_DEPTH = 64
MAX_PARTS = 100_000  # components stand for components: a kilobyte can name more parts than there are atoms
MAX_MODEL_BYTES = 2 << 30
MAX_MIXTURES = 3  # of mixtures; the specification allows one
MODEL_RELATIONSHIP = "/3dmanufacturing/2013/01/3dmodel"
PALETTES = ("basematerials", "colorgroup", "compositematerials", "multiproperties")
LOST_RESOURCES = {"texture2dgroup": "texture{s}", "slicestack": "stack{s} of slices", "volumetricstack": "stack{s} of volume images"}


@dataclass(frozen=True)
class _Mix:
    """A colour made of others: `parts` (group, index), with `shares` for a composite, None for layers."""

    parts: list[tuple[tuple[str, str], int]]
    shares: list[float] | None


Palette = list[CadMaterial | _Mix]


def read_3mf(path: Path) -> RawFile:
    """A `.3mf` package: objects, components, build items, base materials and colour groups, the model's unit."""
    package = _Package(path)
    raw = RawFile(units=package.unit)
    for item in package.build:
        package.place(raw, item, ())
    raw.warnings[:] = dict.fromkeys([*raw.warnings, *package.losses.lines(path.name)])
    return raw


def _local(tag: str) -> str:
    return tag.rpartition("}")[2]


def _matrix(text: str | None) -> np.ndarray | None:
    """3MF writes a 4×3 row-vector matrix; ours acts on columns."""
    if not text:
        return None
    numbers = np.array(text.split(), dtype=np.float64)
    if numbers.size != 12:
        raise ValueError(f"a transform has {numbers.size} numbers, not 12")
    matrix = np.eye(4)
    matrix[:3, :] = numbers.reshape(4, 3).T
    return matrix


class _Package:
    """The parsed parts of one package; objects are keyed by (file inside the package, id)."""

    def __init__(self, path: Path) -> None:
        self.name, self.losses = path.name, Losses()
        self.objects: dict[tuple[str, str], ElementTree.Element] = {}
        self.palettes: dict[tuple[str, str], Palette] = {}
        self.build: list[tuple[tuple[str, str], np.ndarray | None, str | None]] = []
        self.unit = "millimeter"
        with zipfile.ZipFile(path) as archive:
            names = [n for n in archive.namelist() if n.lower().endswith(".model")]
            root = _root(archive, names)
            if root is None:
                raise CadFileError(f"{path.name} is a zip without a 3D model inside: it is no 3MF file. Export it again.")
            if sum(archive.getinfo(n).file_size for n in names) > MAX_MODEL_BYTES:
                raise CadFileError(f"{path.name} unpacks to more than {MAX_MODEL_BYTES >> 30} GiB: split it.")
            for name in names:
                self._parse(name.lstrip("/"), archive.read(name), name == root)

    def _parse(self, name: str, data: bytes, is_root: bool) -> None:
        model = ElementTree.fromstring(data)
        if is_root:
            self.unit = model.get("unit", "millimeter")
        for element in model.iter():
            tag = _local(element.tag)
            if tag == "object":
                self.objects[name, element.get("id", "")] = element
            elif tag in PALETTES:
                self.palettes[name, element.get("id", "")] = self._palette(name, tag, element)
            elif tag in LOST_RESOURCES:
                self.losses.add(LOST_RESOURCES[tag])
            elif tag == "item" and is_root:
                self.build.append(
                    ((_file_of(element, name), element.get("objectid", "")), _matrix(element.get("transform")), element.get("partnumber"))
                )

    def _palette(self, file: str, tag: str, element: ElementTree.Element) -> Palette:
        """The colours of a group; those that are mixed of others found when they are asked for."""
        if tag in ("basematerials", "colorgroup"):
            return [_palette_entry(e) for e in element]
        if tag == "compositematerials":
            of = (file, element.get("matid", ""))
            return [_Mix([(of, int(i)) for i in element.get("matindices", "").split()], _floats(e.get("values"))) for e in element]
        groups = [(file, key) for key in element.get("pids", "").split()]
        return [_Mix(list(zip(groups, map(int, e.get("pindices", "").split()), strict=False)), None) for e in element]

    def place(self, raw: RawFile, item: tuple, above: tuple[tuple[tuple[str, str], int], ...]) -> None:
        """Add one build item or component and all below it; `above` the objects that it is a component of, with their nodes."""
        key, matrix, number = item
        if key not in self.objects or len(above) > MAX_DEPTH or any(key == other for other, _ in above):
            raw.warnings.append(f"Object {shown_name(key[1])} is missing or contains itself: left out.")
            return
        if len(raw.nodes) == MAX_PARTS:
            raise CadFileError(f"{self.name} places more than {MAX_PARTS:,} parts: split it.")
        element = self.objects[key]
        name = element.get("name") or number or element.get("partnumber") or f"Object {key[1]}"
        mesh = next((e for e in element if _local(e.tag) == "mesh"), None)
        if mesh is not None and self._lost_of_mesh(mesh, name):
            mesh = None
        index = len(raw.nodes)
        raw.nodes.append(RawNode(name, above[-1][1] if above else -1, key if mesh is not None else None, matrix))
        if mesh is not None and key not in raw.meshes:
            raw.meshes[key] = (name, [self._piece(raw, key[0], element, mesh)])
        for component in (c for e in element if _local(e.tag) == "components" for c in e):
            below = ((_file_of(component, key[0]), component.get("objectid", "")), _matrix(component.get("transform")), None)
            self.place(raw, below, (*above, (key, index)))

    def _piece(self, raw: RawFile, file: str, element: ElementTree.Element, mesh: ElementTree.Element) -> RawPiece:
        vertices = [(v.get("x"), v.get("y"), v.get("z")) for e in mesh if _local(e.tag) == "vertices" for v in e]
        faces = [e for group in mesh if _local(group.tag) == "triangles" for e in group]
        positions = np.array(vertices, dtype=np.float64).reshape(-1, 3)
        triangles = np.array([(t.get("v1"), t.get("v2"), t.get("v3")) for t in faces], dtype=np.int64).reshape(-1, 3)
        default = (element.get("pid"), element.get("pindex", "0"))
        chosen = [_chosen(t, default) for t in faces]
        alike = {one for one in chosen if len(set(one)) == 1}
        if len(set(chosen)) <= 1 and len(alike) == len(set(chosen)):
            return RawPiece(positions, triangles, None, self._material(raw, file, chosen[0][0] if chosen else default))
        colors = {one: self._color(file, one) for one in {corner for own in chosen for corner in own}}
        return RawPiece(positions, triangles, None, None, np.array([[colors[corner] for corner in own] for own in chosen]))

    def _lost_of_mesh(self, mesh: ElementTree.Element, name: str) -> bool:
        """Note what a mesh has that is not drawn; whether nothing else is left of it."""
        lost = ["beam lattice{s}" for e in mesh if _local(e.tag) == "beamlattice"]
        for kind in lost:
            self.losses.add(kind, name)
        return bool(lost) and not any(len(e) for e in mesh if _local(e.tag) == "triangles")

    def _entry(self, file: str, chosen: tuple[str | None, str], depth: int = 0) -> CadMaterial | None:
        palette = self.palettes.get((file, chosen[0] or ""), [])
        index = int(chosen[1])
        entry = palette[index] if 0 <= index < len(palette) else None
        return self._mixed(entry, depth) if isinstance(entry, _Mix) else entry

    def _mixed(self, mix: _Mix, depth: int) -> CadMaterial | None:
        """A composite as the mean of its parts by their shares, layers of properties one over the other by their opacity."""
        found = [self._entry(key[0], (key[1], str(index)), depth + 1) for key, index in mix.parts] if depth < MAX_MIXTURES else []
        colors = [np.array(one.base_color) for one in found if one is not None]
        if not colors:
            return None
        if mix.shares is not None and len(mix.shares) == len(colors) == len(found) and sum(mix.shares) > 0.0:
            color = np.average(colors, axis=0, weights=mix.shares)
        else:
            color = colors[0]
            for upper in colors[1:]:
                color = np.append(color[:3] + (upper[:3] - color[:3]) * upper[3], max(color[3], upper[3]))
        return CadMaterial("Mixture", tuple(float(c) for c in color))

    def _material(self, raw: RawFile, file: str, chosen: tuple[str | None, str]) -> object | None:
        entry = self._entry(file, chosen)
        if entry is None:
            return None
        raw.materials.setdefault((file, chosen), entry)
        return (file, chosen)

    def _color(self, file: str, chosen: tuple[str | None, str]) -> tuple[float, ...]:
        entry = self._entry(file, chosen)
        return entry.base_color if entry is not None else (0.8, 0.8, 0.8, 1.0)


def _file_of(element: ElementTree.Element, default: str) -> str:
    """The production extension's `path` attribute, else the file the element stands in."""
    return next((v.lstrip("/") for k, v in element.attrib.items() if _local(k) == "path"), default)


def _chosen(triangle: ElementTree.Element, default: tuple[str | None, str]) -> tuple[tuple[str | None, str], ...]:
    """The group and the index in it of each of a triangle's corners: `p2` and `p3` are `p1` where they are left out."""
    group, first = triangle.get("pid", default[0]), triangle.get("p1", default[1])
    return tuple((group, triangle.get(name, first)) for name in ("p1", "p2", "p3"))


def _floats(text: str | None) -> list[float]:
    return [float(word) for word in (text or "").split()]


def _root(archive: zipfile.ZipFile, names: list[str]) -> str | None:
    """The part that the package begins with: by its relationship, else by its usual name, else the first."""
    by_path = {name.lower().lstrip("/"): name for name in names}
    try:
        relations = ElementTree.fromstring(archive.read("_rels/.rels"))
        targets = [e.get("Target", "") for e in relations if e.get("Type", "").endswith(MODEL_RELATIONSHIP)]
    except (KeyError, ElementTree.ParseError):
        targets = []
    wanted = [target.lower().lstrip("/") for target in targets] + ["3d/3dmodel.model"]
    return next((by_path[one] for one in wanted if one in by_path), names[0] if names else None)


def _palette_entry(element: ElementTree.Element) -> CadMaterial:
    text = (element.get("displaycolor") or element.get("color") or "#CCCCCCFF").lstrip("#")
    channels = bytes.fromhex(text if len(text) == 8 else text[:6] + "FF")
    color = linear_from_srgb(np.frombuffer(channels, dtype=np.uint8) / 255.0)
    return CadMaterial(element.get("name") or f"Color {text[:6].lower()}", tuple(float(c) for c in color))


ROW = CadFormat("3MF", {".3mf": starts(b"PK\x03\x04")}, read_3mf, place=60, unit="mm", fixes_unit=True)
