"""glTF 2.0, read from the document itself: trimesh's loader makes names unique, finds materials by name, and knows neither sparse nor
normalized accessors, strips, fans, instances, lights nor cameras.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...errors import CadFileError
from ..cad_model import CadCamera, CadLight
from ..plain_text import shown_name
from .cad_format import CadFormat, starts, starts_text
from .gltf_document import MESHOPT, Document, picked
from .gltf_look import SPEC_GLOSS, cameras_of, lights_of, materials_of
from .gltf_primitives import DRACO, Primitives
from .losses import Losses
from .raw import RawFile, RawNode

INSTANCING = "EXT_mesh_gpu_instancing"
KNOWN = {
    DRACO, *MESHOPT, INSTANCING, SPEC_GLOSS, "KHR_lights_punctual", "KHR_mesh_quantization", "KHR_node_visibility", "CESIUM_RTC",
    "KHR_animation_pointer", "KHR_xmp_json_ld", "EXT_mesh_features", "EXT_structural_metadata", "FB_ngon_encoding",
    "CESIUM_primitive_outline",
}  # fmt: skip
ABOUT_LOOKS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "EXT_materials_", "ADOBE_materials_")
MOST_PARTS = 1 << 20


def read_gltf(path: Path) -> RawFile:
    """A `.glb` or `.gltf` with the files it refers to."""
    return read_glb_bytes(path.read_bytes(), path)


def read_glb_bytes(data: bytes, path: Path) -> RawFile:
    """A glTF document in memory; what it refers to lies beside `path`, which messages name."""
    document, losses = Document(data, path), Losses()
    _refuse_unknown(document)
    materials, textures = materials_of(document, losses)
    raw = RawFile(materials=dict(enumerate(materials)), warnings=document.warnings)
    _Tree(document, raw, Primitives(document, textures, losses), losses).add_scene()
    for key, kind in (("animations", "animation{s}"), ("skins", "skeleton{s} (meshes stand as they were modelled)")):
        losses.add(kind, "", len(document.entries(key)))
    raw.warnings += losses.lines(path.name)
    if document.entries("meshes") and not raw.meshes and not any(node.mesh is not None for node in raw.nodes):
        raise CadFileError(f"{path.name} holds meshes but places none of them in its scene: export the scene, not only a library of parts.")
    return raw


def _refuse_unknown(document: Document) -> None:
    required = [str(name) for name in document.header.get("extensionsRequired", ())]
    unknown = [name for name in required if name not in KNOWN and not name.startswith(ABOUT_LOOKS)]
    if unknown:
        names = shown_name(", ".join(unknown))
        raise CadFileError(
            f"{document.path.name} requires the glTF extension {names}, which this program does not know: export without it."
        )


class _Tree:
    """Adds the nodes of the scene that the document opens with, parents first, and the meshes they show."""

    def __init__(self, document: Document, raw: RawFile, primitives: Primitives, losses: Losses) -> None:
        self._document, self._raw, self._primitives, self._losses = document, raw, primitives, losses
        self._lights, self._cameras = lights_of(document), cameras_of(document)

    def add_scene(self) -> None:
        """All that is reached from the scene's roots; no node twice."""
        roots, seen = self._roots(), set()
        stack = [(root, -1, False) for root in reversed(roots)]
        while stack:
            number, parent, is_hidden = stack.pop()
            node = self._document.entry("nodes", number)
            if number in seen:
                self._losses.add("node{s} placed twice or within themselves", self._name(node, number))
                continue
            seen.add(number)
            if len(self._raw.nodes) >= MOST_PARTS:
                raise CadFileError(f"{self._document.path.name} places more than {MOST_PARTS:,} parts: split it.")
            is_hidden = is_hidden or node.get("extensions", {}).get("KHR_node_visibility", {}).get("visible", True) is False
            own = self._add(node, number, parent, is_hidden)
            stack += [(child, own, is_hidden) for child in reversed(node.get("children", ()))]

    def _roots(self) -> list[int]:
        """The roots of the scene that is shown first; of a document without scenes, the nodes that are nobody's children."""
        scenes, nodes = self._document.entries("scenes"), self._document.entries("nodes")
        if not scenes:
            children = {child for node in nodes for child in node.get("children", ())}
            return [number for number in range(len(nodes)) if number not in children]
        chosen = self._document.header.get("scene", 0)
        self._losses.add("further scene{s}", "", len(scenes) - 1)
        return list(self._document.entry("scenes", chosen).get("nodes", ()))

    def _name(self, node: dict, number: int) -> str:
        """The node's own name, else its mesh's, light's or camera's."""
        if node.get("name"):
            return str(node["name"])
        named = [self._document.entry("meshes", node["mesh"])] if "mesh" in node else []
        named += [self._document.entry("cameras", node["camera"])] if "camera" in node else []
        return next((str(one["name"]) for one in named if one.get("name")), f"Node {number}")

    def _add(self, node: dict, number: int, parent: int, is_hidden: bool) -> int:
        """The node with what it shows; gives its index."""
        raw, name, matrix = self._raw, self._name(node, number), _matrix(node)
        if parent < 0 and "CESIUM_RTC" in self._document.header.get("extensions", {}):
            matrix = _moved(self._document.header["extensions"]["CESIUM_RTC"]["center"], matrix)
        mesh = self._mesh(node["mesh"], node.get("weights")) if "mesh" in node else None
        instances = node.get("extensions", {}).get(INSTANCING) if mesh is not None else None
        items, index = list(self._items(node)), len(raw.nodes)
        own_item = items.pop(0) if items and mesh is None else None
        raw.nodes.append(RawNode(name, parent, mesh if instances is None else None, matrix, own_item, is_hidden))
        if instances is not None:
            raw.nodes += [RawNode(name, index, mesh, own, None, is_hidden) for own in self._instances(instances)]
        raw.nodes += [RawNode(item.name, index, None, None, item, is_hidden) for item in items]
        return index

    def _items(self, node: dict) -> Iterator[CadLight | CadCamera]:
        """The light and the camera that stand at a node."""
        light = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if light is not None:
            yield picked(self._lights, light, "light")
        if "camera" in node:
            yield picked(self._cameras, node["camera"], "camera")

    def _mesh(self, number: int, weights: list[float] | None) -> object:
        """The key of a mesh with the morph weights of its node, else its own; its pieces are read when it is first used."""
        mesh = self._document.entry("meshes", number)
        own = [float(weight) for weight in mesh.get("weights", ())]
        chosen = own if weights is None else [float(weight) for weight in weights]
        key = number if chosen == own else (number, *chosen)
        if key not in self._raw.meshes:
            name = mesh.get("name") or f"Mesh {number}"
            self._raw.meshes[key] = (name, self._primitives.pieces(mesh, name, chosen))
        return key

    def _instances(self, extension: dict) -> np.ndarray:
        """(N, 4, 4) the placements of EXT_mesh_gpu_instancing."""
        given = {key: self._document.numbers(index) for key, index in extension.get("attributes", {}).items()}
        count = min((len(values) for values in given.values()), default=0)
        if len(self._raw.nodes) + count > MOST_PARTS:
            raise CadFileError(f"{self._document.path.name} places more than {MOST_PARTS:,} parts: split it.")
        unit = (("TRANSLATION", (0.0, 0.0, 0.0)), ("ROTATION", (0.0, 0.0, 0.0, 1.0)), ("SCALE", (1.0, 1.0, 1.0)))
        return placements(*(np.asarray(given.get(key, np.tile(one, (count, 1))), np.float64)[:count] for key, one in unit))


def placements(moves: np.ndarray, turns: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """(N, 4, 4) T R S of (N, 3) translations, (N, 4) quaternions x y z w, (N, 3) scales; a quaternion of zero length turns nothing."""
    length = np.linalg.norm(turns, axis=1, keepdims=True)
    x, y, z, w = np.where(length > 0.0, turns / np.where(length > 0.0, length, 1.0), [0.0, 0.0, 0.0, 1.0]).T
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    out = np.tile(np.eye(4), (len(moves), 1, 1))
    out[:, :3, :3], out[:, :3, 3] = rotation * scales[:, None, :], moves
    return out


def _matrix(node: dict) -> np.ndarray | None:
    """(4, 4) of a node; None for one that stands where its parent does."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    if not any(key in node for key in ("translation", "rotation", "scale")):
        return None
    unit = (("translation", (0.0, 0.0, 0.0)), ("rotation", (0.0, 0.0, 0.0, 1.0)), ("scale", (1.0, 1.0, 1.0)))
    with np.errstate(all="ignore"):
        return placements(*(np.array([node.get(key, one)], np.float64) for key, one in unit))[0]


def _moved(center: list[float], matrix: np.ndarray | None) -> np.ndarray:
    """A root moved by CESIUM_RTC's centre, which float32 positions are relative to."""
    out = np.eye(4) if matrix is None else matrix.copy()
    out[:3, 3] += np.asarray(center, np.float64)
    return out


ROW = CadFormat("glTF", {".glb": starts(b"glTF"), ".gltf": starts_text(rb"\{")}, read_gltf, place=70, up="Y", fixes_unit=True)
