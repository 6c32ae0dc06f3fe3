"""3MF core specification with its colours, on the standard library (trimesh's reader needs lxml and networkx, which Blender lacks)."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...errors import CadFileError
from ...images.srgb import linear_from_srgb
from ..cad_model import CadMaterial
from ..plain_text import shown_name
from .cad_format import CadFormat, starts
from .colors import of_faces
from .raw import RawFile, RawNode, RawPiece

MAX_DEPTH = 64
MAX_PARTS = 100_000  # components stand for components: a kilobyte can name more parts than there are atoms
MAX_MODEL_BYTES = 2 << 30


def read_3mf(path: Path) -> RawFile:
    """A `.3mf` package: objects, components, build items, base materials and colour groups, the model's unit."""
    package = _Package(path)
    raw = RawFile(units=package.unit)
    for item in package.build:
        package.place(raw, item, ())
    raw.warnings[:] = dict.fromkeys(raw.warnings)
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
        self.name = path.name
        self.objects: dict[tuple[str, str], ElementTree.Element] = {}
        self.palettes: dict[tuple[str, str], list[CadMaterial]] = {}
        self.build: list[tuple[tuple[str, str], np.ndarray | None, str | None]] = []
        self.unit = "millimeter"
        with zipfile.ZipFile(path) as archive:
            names = [n for n in archive.namelist() if n.lower().endswith(".model")]
            root = next((n for n in names if n.lower().lstrip("/") == "3d/3dmodel.model"), names[0] if names else None)
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
            elif tag in ("basematerials", "colorgroup"):
                self.palettes[name, element.get("id", "")] = [_palette_entry(e) for e in element]
            elif tag == "item" and is_root:
                self.build.append(
                    ((_file_of(element, name), element.get("objectid", "")), _matrix(element.get("transform")), element.get("partnumber"))
                )

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
        chosen = [(t.get("pid", default[0]), t.get("p1", default[1])) for t in faces]
        if len(set(chosen)) <= 1:
            return RawPiece(positions, triangles, None, self._material(raw, file, chosen[0] if chosen else default))
        colors = np.array([self._color(file, c) for c in chosen])
        return RawPiece(positions, triangles, None, None, of_faces(colors))

    def _entry(self, file: str, chosen: tuple[str | None, str]) -> CadMaterial | None:
        palette = self.palettes.get((file, chosen[0] or ""), [])
        index = int(chosen[1])
        return palette[index] if 0 <= index < len(palette) else None

    def _material(self, raw: RawFile, file: str, chosen: tuple[str | None, str]) -> object | None:
        entry = self._entry(file, chosen)
        if entry is None:
            return None
        raw.materials.setdefault((file, chosen), entry)
        return (file, chosen)

    def _color(self, file: str, chosen: tuple[str | None, str]) -> tuple[float, float, float, float]:
        entry = self._entry(file, chosen)
        return entry.base_color if entry is not None else (0.8, 0.8, 0.8, 1.0)


def _file_of(element: ElementTree.Element, default: str) -> str:
    """The production extension's `path` attribute, else the file the element stands in."""
    return next((v.lstrip("/") for k, v in element.attrib.items() if _local(k) == "path"), default)


def _palette_entry(element: ElementTree.Element) -> CadMaterial:
    text = (element.get("displaycolor") or element.get("color") or "#CCCCCCFF").lstrip("#")
    channels = bytes.fromhex(text if len(text) == 8 else text[:6] + "FF")
    color = linear_from_srgb(np.frombuffer(channels, dtype=np.uint8) / 255.0)
    return CadMaterial(element.get("name") or f"Color {text[:6].lower()}", tuple(float(c) for c in color))


ROW = CadFormat("3MF", {".3mf": starts(b"PK\x03\x04")}, read_3mf, place=60, unit="mm", fixes_unit=True)
