"""COLLADA (`.dae`, `.zae`), read here: Blender has had no importer for it since version 5.0, and trimesh's needs pycollada and lxml."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from ...errors import CadFileError
from .cad_format import CadFormat, Likeness
from .collada_document import Collada, Element, children, found, local
from .losses import Losses
from .polygons import triangulate
from .raw import RawFile, RawNode, RawPiece
from .text_numbers import numbers
from .units import METRES_PER_UNIT

MOST_BYTES = 2 << 30
MOST_PARTS, MOST_DEPTH = 1 << 18, 256
UPS = {"X_UP": "X", "Y_UP": "Y", "Z_UP": "Z"}
LOST = {"lines": "set{s} of lines", "linestrips": "set{s} of lines", "spline": "spline{s}", "brep": "boundary representation{s}"}
LOST_INSTANCES = {"instance_light": "light{s}", "instance_camera": "camera{s}"}
FACES = ("triangles", "polylist", "polygons", "tristrips", "trifans")


def read_collada(path: Path) -> RawFile:
    """A `.dae` file, or the one in a `.zae` archive: its scene, geometry, materials, unit and axis."""
    document = Collada(_text(path), path)
    raw, losses = RawFile(), Losses()
    asset = found(document.root, "asset")
    unit, axis = found(asset, "unit"), found(asset, "up_axis")
    metres = float(unit.get("meter", "1")) if unit is not None else 1.0
    raw.units = next((name for name, size in METRES_PER_UNIT.items() if abs(size - metres) <= 1e-9 * size), "m")
    raw.up = UPS.get((axis.text or "").strip().upper(), "Y") if axis is not None else "Y"
    _ColladaScene(document, raw, losses, metres / METRES_PER_UNIT[raw.units]).add()
    losses.add("animation{s}", "", len(children(found(document.root, "library_animations"), "animation")))
    raw.warnings += losses.lines(path.name)
    return raw


def _text(path: Path) -> bytes:
    if path.suffix.lower() != ".zae":
        return path.read_bytes()
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if name.lower().endswith(".dae")]
        if not names:
            raise CadFileError(f"{path.name} is a zip without a .dae file inside: export it again.")
        if archive.getinfo(names[0]).file_size > MOST_BYTES:
            raise CadFileError(f"{path.name} unpacks to more than {MOST_BYTES >> 30} GiB: split it.")
        return archive.read(names[0])


class _ColladaScene:
    """Adds the nodes of the scene that the document shows, and the geometry they name; `scale` what no unit's name says."""

    def __init__(self, document: Collada, raw: RawFile, losses: Losses, scale: float) -> None:
        self._document, self._raw, self._losses, self._scale = document, raw, losses, scale

    def add(self) -> None:
        """All nodes below the scene; a document without one shows every geometry once."""
        shown = found(self._document.root, "scene", "instance_visual_scene")
        scene = self._document.target(shown.get("url")) if shown is not None else None
        if scene is None:
            scene = found(self._document.root, "library_visual_scenes", "visual_scene")
        top = np.diag([self._scale] * 3 + [1.0])
        if scene is not None:
            for node in children(scene, "node"):
                self._node(node, -1, top, ())
            return
        for geometry in children(found(self._document.root, "library_geometries"), "geometry"):
            self._show(geometry, {}, geometry.get("name") or geometry.get("id") or "Geometry", -1, top)

    def _node(self, node: Element, parent: int, above: np.ndarray, way: tuple[int, ...]) -> None:
        """A node with all below it; `above` is what its matrix is within, for a root the scale."""
        if len(way) > MOST_DEPTH or id(node) in way:
            raise CadFileError(
                f"{self._document.path.name} nests its nodes more than {MOST_DEPTH} deep, or within themselves: export it again."
            )
        if len(self._raw.nodes) >= MOST_PARTS:
            raise CadFileError(f"{self._document.path.name} places more than {MOST_PARTS:,} parts: split it.")
        name = node.get("name") or node.get("id") or "Node"
        shown = [one for one in map(self._geometry, children(node, "instance_geometry", "instance_controller")) if one is not None]
        single = shown[0] if len(shown) == 1 else None
        index = len(self._raw.nodes)
        self._raw.nodes.append(RawNode(name, parent, None, above @ _matrix(node)))
        if single is not None:
            self._raw.nodes[index].mesh = self._mesh(*single)
        for geometry, bound in shown if single is None else ():
            self._show(geometry, bound, geometry.get("name") or name, index, np.eye(4))
        for kind in children(node, *LOST_INSTANCES):
            self._losses.add(LOST_INSTANCES[local(kind)], name)
        below = [
            (self._document.target(one.get("url")) if local(one) == "instance_node" else one)
            for one in children(node, "node", "instance_node")
        ]
        for child in below:
            if child is None:
                self._losses.add("node{s} of other files", name)
            else:
                self._node(child, index, np.eye(4), (*way, id(node)))

    def _geometry(self, instance: Element) -> tuple[Element, dict[str, str]] | None:
        """The geometry of an instance, a skin's as it was modelled, and its materials by the symbols that primitives use."""
        shown = self._document.target(instance.get("url"))
        if local(instance) == "instance_controller":
            skin = next(iter(children(shown, "skin", "morph")), None)
            shown = self._document.target(skin.get("source")) if skin is not None else None
            self._losses.add("skeleton{s} (meshes stand as they were modelled)")
        if shown is None or found(shown, "mesh") is None:
            self._losses.add("shape{s} that are not in the file", (instance.get("url") or "")[:60])
            return None
        bound = children(found(instance, "bind_material", "technique_common"), "instance_material")
        return shown, {one.get("symbol", ""): one.get("target", "") for one in bound}

    def _show(self, geometry: Element, bound: dict[str, str], name: str, parent: int, matrix: np.ndarray) -> None:
        self._raw.nodes.append(RawNode(name, parent, self._mesh(geometry, bound), matrix))

    def _mesh(self, geometry: Element, bound: dict[str, str]) -> object:
        """The key of a geometry with these materials; its pieces are read when it is first used."""
        key = (geometry.get("id"), tuple(sorted(bound.items())))
        if key not in self._raw.meshes:
            name = geometry.get("name") or geometry.get("id") or "Geometry"
            mesh = found(geometry, "mesh")
            for one in mesh if mesh is not None else ():
                if local(one) in LOST:
                    self._losses.add(LOST[local(one)], name)
            self._raw.meshes[key] = (name, [self._piece(one, bound) for one in children(mesh, *FACES)])
        return key

    def _piece(self, primitive: Element, bound: dict[str, str]) -> RawPiece:
        """The triangles of a primitive on corners of their own."""
        self._losses.add("hole{s} of polygons", "", sum(len(children(ph, "h")) for ph in children(primitive, "ph")))
        inputs = _inputs(self._document, primitive)
        width = max((offset for _, offset, _, _ in inputs), default=0) + 1
        index, sizes = _corners(primitive, width)
        places = {(semantic, number): (offset, url) for semantic, offset, url, number in reversed(inputs)}
        offset, url = next(value for (semantic, _), value in places.items() if semantic == "POSITION")
        table = self._document.numbers_of(url)
        if table.shape[1] < 3:
            raise ValueError("a position has fewer than three numbers")
        vertex = index[:, offset]
        is_there = (vertex >= 0) & (vertex < len(table))
        positions = np.where(is_there[:, None], table[np.where(is_there, vertex, 0), :3] if len(table) else np.nan, np.nan)
        corners, _ = _cut(local(primitive), positions, sizes)
        symbol = primitive.get("material", "")
        material = self._material(bound.get(symbol) or (f"#{symbol}" if symbol else None))
        normals = self._looked_up(places, "NORMAL", index, 3)
        colors = self._looked_up(places, "COLOR", index, None)
        has_image = material is not None and self._raw.materials[material].image is not None
        uvs = self._looked_up(places, "TEXCOORD", index, None) if has_image else None
        triangles = corners
        if normals is None:
            _, first, of_corner = np.unique(vertex, return_index=True, return_inverse=True)
            positions, triangles = positions[first], of_corner.ravel()[corners]
        return RawPiece(positions, triangles, normals, material, _rgba(colors, corners), None if uvs is None else uvs[corners][..., :2])

    def _material(self, url: str | None) -> object | None:
        """The key of a material."""
        if url is not None and url not in self._raw.materials:
            read = self._document.material(url, self._losses)
            if read is None:
                return None
            self._raw.materials[url] = read[0]
        return url

    def _looked_up(self, places: dict, semantic: str, index: np.ndarray, width: int | None) -> np.ndarray | None:
        """(C, k) what corners have of one kind, of its first set; None where some have none."""
        chosen = min(((number, value) for (kind, number), value in places.items() if kind == semantic), default=None)
        if chosen is None:
            return None
        offset, url = chosen[1]
        table, at = self._document.numbers_of(url), index[:, offset]
        if not len(table) or table.shape[1] < (width or 2) or not ((at >= 0) & (at < len(table))).all():
            return None
        return table[at]


def _rgba(colors: np.ndarray | None, corners: np.ndarray) -> np.ndarray | None:
    """(T, 3, 4) vertex colours of triangles; None where all are white."""
    if colors is None or colors.shape[1] < 3:
        return None
    full = np.ones((len(colors), 4))
    full[:, : min(colors.shape[1], 4)] = np.clip(np.nan_to_num(colors[:, :4]), 0.0, 1.0)
    return None if (full == 1.0).all() else full[corners]


def _inputs(document: Collada, primitive: Element) -> list[tuple[str, int, str, int]]:
    """(semantic, offset, source, set) of a primitive; what stands for its vertices is what their own inputs name."""
    out = []
    for one in children(primitive, "input"):
        offset, number = int(one.get("offset", "0")), int(one.get("set", "0"))
        if one.get("semantic") != "VERTEX":
            out.append((one.get("semantic", ""), offset, one.get("source", ""), number))
            continue
        for own in children(document.target(one.get("source")), "input"):
            out.append((own.get("semantic", ""), offset, own.get("source", ""), 0))
    if not any(semantic == "POSITION" and offset >= 0 for semantic, offset, _, _ in out):
        raise ValueError("a primitive has no positions")
    return out


def _corners(primitive: Element, width: int) -> tuple[np.ndarray, np.ndarray]:
    """(C, width) indices of all corners, and (P,) how many each polygon, strip or fan has."""
    kind, lists = local(primitive), [numbers((p.text or "").encode(), np.int64) for p in children(primitive, "p")]
    lists += [numbers((p.text or "").encode(), np.int64) for ph in children(primitive, "ph") for p in children(ph, "p")]
    lists = [one[: len(one) // width * width].reshape(-1, width) for one in lists]
    index = np.concatenate(lists) if lists else np.empty((0, width), np.int64)
    if kind == "triangles":
        return index[: len(index) // 3 * 3], np.full(len(index) // 3, 3)
    if kind == "polylist":
        counts = found(primitive, "vcount")
        sizes = numbers((counts.text or "").encode() if counts is not None else b"", np.int64)
        if (sizes < 0).any() or sizes.sum() > len(index):
            raise ValueError(f"polygons of {int(sizes.sum()):,} corners are announced, {len(index):,} are there")
        return index[: int(sizes.sum())], sizes
    return index, np.array([len(one) for one in lists], np.int64)


def _cut(kind: str, positions: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(T, 3) corner numbers of the triangles of polygons, strips or fans."""
    if kind not in ("tristrips", "trifans"):
        return triangulate(positions, sizes)
    out, first = [np.empty((0, 3), np.int64)], 0
    for size in sizes.tolist():
        i = first + np.arange(max(size - 2, 0))
        odd = (i - first) % 2
        fan = [np.full_like(i, first), i + 1, i + 2]
        out.append(np.stack(fan if kind == "trifans" else [i, i + 1 + odd, i + 2 - odd], axis=1))
        first += size
    return np.concatenate(out), np.empty(0)


def _matrix(node: Element) -> np.ndarray:
    """(4, 4) the product of a node's transformations, in their order."""
    out = np.eye(4)
    for one in node:
        kind = local(one)
        if kind in ("matrix", "translate", "rotate", "scale"):
            out = out @ _TRANSFORMS[kind](np.array((one.text or "").split(), np.float64))
    return out


def _translated(values: np.ndarray) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = values[:3]
    return out


def _rotated(values: np.ndarray) -> np.ndarray:
    """Rodrigues' formula: an axis and degrees."""
    length = np.linalg.norm(values[:3])
    x, y, z = values[:3] / (length or 1.0)
    cross, angle = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]), np.radians(values[3])
    out = np.eye(4)
    out[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return out


_TRANSFORMS = {
    "matrix": lambda values: values[:16].reshape(4, 4),
    "translate": _translated,
    "rotate": _rotated,
    "scale": lambda values: np.diag([*values[:3], 1.0]),
}


def likeness(head: bytes, _size: int) -> Likeness:
    """The root element's name."""
    return Likeness.TEXT if b"<COLLADA" in head else Likeness.NO


def _is_archive(head: bytes, _size: int) -> Likeness:
    return Likeness.BINARY if head.startswith(b"PK\x03\x04") else Likeness.NO


ROW = CadFormat("COLLADA", {".dae": likeness, ".zae": _is_archive}, read_collada, place=100, up="Y", fixes_unit=True)
