"""The primitives of glTF meshes as triangles. Source: the Khronos specification, §3.7.2, and the extensions named here."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from . import draco
from .gltf_document import Document, unit_range
from .gltf_look import transformed_uvs
from .losses import Losses
from .raw import RawPiece

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
DRACO = "KHR_draco_mesh_compression"


class Primitives:
    """Makes pieces of primitives, each that is written alike only once; `textures` the base colour's reference of each material."""

    def __init__(self, document: Document, textures: list[dict | None], losses: Losses) -> None:
        self._document, self._textures, self._losses = document, textures, losses
        self._made: dict[tuple, RawPiece | None] = {}

    def pieces(self, mesh: dict, name: str, weights: Sequence[float]) -> list[RawPiece]:
        """The pieces of a mesh that have triangles, with its morph targets by these weights; lines and points are noted as lost."""
        found = (self._piece(primitive, weights, name) for primitive in mesh.get("primitives", ()))
        return [piece for piece in found if piece is not None]

    def _piece(self, primitive: dict, weights: Sequence[float], name: str) -> RawPiece | None:
        mode, attributes = primitive.get("mode", TRIANGLES), primitive.get("attributes", {})
        if mode < TRIANGLES or "POSITION" not in attributes:
            self._losses.add("cloud{s} of points" if mode == POINTS else "set{s} of lines", name)
            return None
        targets = list(zip(weights, primitive.get("targets", []), strict=False)) if any(weights) else []
        packed = primitive.get("extensions", {}).get(DRACO)
        key = (mode, primitive.get("indices"), primitive.get("material"), tuple(sorted(attributes.items())), repr(targets), repr(packed))
        if key not in self._made:
            is_decoded = packed is not None and self._decode(packed, primitive, attributes)
            mode = TRIANGLES if is_decoded else mode
            self._made[key] = self._read(primitive, mode, attributes, targets)
        return self._made[key]

    def _decode(self, packed: dict, primitive: dict, attributes: dict) -> bool:
        """Give the accessors of a primitive what stands in its Draco stream, a list of triangles; whether nothing else has it."""
        if "bufferView" in self._document.entry("accessors", attributes["POSITION"]):
            return False
        data, _ = self._document.view(packed["bufferView"])
        for name, values in draco.decoded(bytes(data), packed["attributes"], self._document.path.name).items():
            accessor = primitive.get("indices") if name == draco.INDICES else attributes.get(name)
            if accessor is not None:
                self._document.provide(accessor, values)
        return True

    def _read(self, primitive: dict, mode: int, attributes: dict, targets: list[tuple[float, dict]]) -> RawPiece:
        numbers = self._document.numbers
        positions = _rows(numbers(attributes["POSITION"]), 3)
        for weight, target in targets:
            if "POSITION" in target and weight:
                positions = positions + np.float32(weight) * _rows(numbers(target["POSITION"]), 3)
        index = numbers(primitive["indices"]) if "indices" in primitive else np.arange(len(positions), dtype=np.uint32)
        triangles = _triangles(index.astype(np.int64), mode)
        normals = _rows(numbers(attributes["NORMAL"]), 3) if "NORMAL" in attributes else None
        inside = np.minimum(triangles, max(len(positions) - 1, 0))
        material = primitive.get("material")
        material = material if material in range(len(self._textures)) else None
        colors = self._colors(attributes, len(positions))
        uvs = self._uvs(attributes, material, len(positions)) if len(positions) else None
        return RawPiece(
            positions,
            triangles,
            normals if normals is not None and len(normals) == len(positions) else None,
            material,
            None if colors is None else colors[inside],
            None if uvs is None else uvs[inside],
        )

    def _colors(self, attributes: dict, count: int) -> np.ndarray | None:
        """(V, 4) linear vertex colours; None where there are none, or all are white."""
        if "COLOR_0" not in attributes:
            return None
        colors = self._document.numbers(attributes["COLOR_0"])
        if colors.ndim != 2 or colors.shape[1] not in (3, 4) or len(colors) != count or not count:
            raise ValueError("the vertex colours do not fit the vertices")
        colors = unit_range(colors) if colors.dtype.kind in "iu" else np.clip(np.nan_to_num(colors), 0.0, 1.0)
        if (colors == 1.0).all():
            return None
        return np.concatenate([colors, np.ones((count, 4 - colors.shape[1]), np.float32)], axis=1)

    def _uvs(self, attributes: dict, material: int | None, count: int) -> np.ndarray | None:
        """(V, 2) the coordinates of the material's picture; None where it has none, or the vertices have none for it."""
        reference = None if material is None else self._textures[material]
        if reference is None:
            return None
        number = reference.get("extensions", {}).get("KHR_texture_transform", {}).get("texCoord", reference.get("texCoord", 0))
        if f"TEXCOORD_{number}" not in attributes:
            self._losses.add("set{s} of texture coordinates that its material asks for and it does not have")
            return None
        uvs = self._document.numbers(attributes[f"TEXCOORD_{number}"])
        if uvs.shape != (count, 2):
            raise ValueError("the texture coordinates do not fit the vertices")
        uvs = unit_range(uvs) if uvs.dtype.kind == "u" and not self._is_plain(attributes[f"TEXCOORD_{number}"]) else uvs
        with np.errstate(all="ignore"):
            return np.nan_to_num(transformed_uvs(uvs.astype(np.float32), reference))

    def _is_plain(self, index: int) -> bool:
        """Whether KHR_mesh_quantization's integers count themselves, not parts of the largest."""
        return not self._document.entry("accessors", index).get("normalized", False)


def _rows(values: np.ndarray, width: int) -> np.ndarray:
    if values.ndim != 2 or values.shape[1] != width:
        raise ValueError(f"an attribute has the shape {values.shape}, not (…, {width})")
    return values


def _triangles(index: np.ndarray, mode: int) -> np.ndarray:
    """(T, 3) of a list, a strip or a fan of triangles (§3.7.2.1)."""
    if mode == TRIANGLES:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    count = max(len(index) - 2, 0)
    i = np.arange(count)
    if mode == FAN:
        return np.stack([index[1 : count + 1], index[2 : count + 2], np.broadcast_to(index[:1], count)], axis=1)
    odd = i % 2
    return np.stack([index[i], index[i + 1 + odd], index[i + 2 - odd]], axis=1)
