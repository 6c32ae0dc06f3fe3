"""IFC, by IfcOpenShell where it is installed (as it is with Bonsai in the same Blender): its shapes, names, spatial tree and colours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import CadFileError
from ..cad_model import CadMaterial
from .cad_format import CadFormat, Likeness, starts_text
from .losses import Losses
from .raw import RawFile, RawNode, RawPiece

NOT_SHOWN = ("IfcOpeningElement",)  # what is cut out of others
HIDDEN = ("IfcSpace", "IfcSpatialZone")
MOST_DEPTH = 64
IS_PART_21 = starts_text(rb"ISO-10303-21;")


def read_ifc(path: Path) -> RawFile:
    """An `.ifc` file in metres. Raises `CadFileError` where IfcOpenShell is not installed."""
    try:
        import ifcopenshell
        import ifcopenshell.geom
    except ImportError as error:
        raise CadFileError(
            f"{path.name} is an IFC file, which takes IfcOpenShell: install the extension Bonsai in Blender, or export it as glTF or STEP."
        ) from error
    model = ifcopenshell.open(str(path))
    raw, losses = RawFile(units="m"), Losses()
    iterator = ifcopenshell.geom.iterator(ifcopenshell.geom.settings(), model, 1, exclude=NOT_SHOWN)
    tree = _SpatialTree(model, raw)
    is_there = iterator.initialize()
    while is_there:
        _add(iterator.get(), tree, raw, losses)
        is_there = iterator.next()
    raw.warnings += losses.lines(path.name, "imported hidden, as rooms are")
    return raw


class _SpatialTree:
    """The nodes of what stands above a product, each made when first asked for."""

    def __init__(self, model: Any, raw: RawFile) -> None:
        self._model, self._raw = model, raw
        self._index: dict[int, int] = {}

    def above(self, number: int, depth: int = 0) -> int:
        """The index of the node of an element by its number; −1 for none."""
        if number <= 0 or depth > MOST_DEPTH:
            return -1
        if number not in self._index:
            element = self._model.by_id(number)
            parent = self.above(_parent_of(element), depth + 1)
            self._index[number] = len(self._raw.nodes)
            self._raw.nodes.append(RawNode(element.Name or element.is_a(), parent))
        return self._index[number]


def _parent_of(element: Any) -> int:
    """The number of what an element is a part of, or stands in; 0 for none."""
    for relation, whole in (("Decomposes", "RelatingObject"), ("ContainedInStructure", "RelatingStructure")):
        for one in getattr(element, relation, None) or ():
            return int(getattr(one, whole).id())
    return 0


def _add(shape: Any, tree: _SpatialTree, raw: RawFile, losses: Losses) -> None:
    """A product with its shape; what is alike is one mesh."""
    geometry, key = shape.geometry, str(shape.geometry.id)
    name = shape.name or shape.type
    if key not in raw.meshes:
        raw.meshes[key] = (name, _pieces(geometry, raw))
    is_room = shape.type in HIDDEN
    if is_room:
        losses.add("room{s}", name)
    matrix = np.asarray(getattr(shape.transformation.matrix, "data", shape.transformation.matrix), np.float64).reshape(4, -1)
    placed = np.eye(4)
    placed[:3] = matrix[:, :3].T
    raw.nodes.append(RawNode(name, tree.above(int(shape.parent_id)), key, placed, is_hidden=is_room))


def _pieces(geometry: Any, raw: RawFile) -> list[RawPiece]:
    """The triangles of a shape, a piece for each of its materials."""
    positions = np.array(geometry.verts, np.float64).reshape(-1, 3)
    triangles = np.array(geometry.faces, np.int64).reshape(-1, 3)
    of_triangle = np.array(geometry.material_ids, np.int64)
    keys = [_material(one, raw) for one in geometry.materials]
    if not keys or len(of_triangle) != len(triangles):
        return [RawPiece(positions, triangles)]
    return [
        RawPiece(positions, triangles[of_triangle == number], None, keys[number] if number >= 0 else None)
        for number in np.unique(of_triangle).tolist()
    ]


def _material(style: Any, raw: RawFile) -> object:
    """The key of a surface style's colour."""
    color, transparency = style.diffuse, style.transparency
    channels = [getattr(color, name) for name in "rgb"] if hasattr(color, "r") else list(color)
    rgb = tuple(min(max(float(one() if callable(one) else one), 0.0), 1.0) for one in channels[:3])
    alpha = 1.0 - float(transparency) if transparency is not None and 0.0 < transparency < 1.0 else 1.0
    key = (style.name, rgb, alpha)
    raw.materials.setdefault(key, CadMaterial(str(style.name), (*rgb, alpha)))
    return key


def likeness(head: bytes, size: int) -> Likeness:
    """A file of ISO 10303-21 like STEP's, whose header names its schema; surer than STEP where it does."""
    is_named = re.search(rb"FILE_SCHEMA\s*\(\s*\(\s*'IFC", head)
    return Likeness.BINARY if is_named else IS_PART_21(head, size)


ROW = CadFormat("IFC", {".ifc": likeness}, read_ifc, place=120, fixes_unit=True)
