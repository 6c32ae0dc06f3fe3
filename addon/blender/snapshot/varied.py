"""Colours that vary over a mesh (colour attributes, pictures), told apart by triangle: each class is drawn as a slot of its own.

A slot with a colour is a number: `slot + SHIFT · (1 + code)`, the code 5 bits of the square root of each linear channel, so that the number
alone says the colour. As many bits count as leave at most `MOST` colours in a mesh.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil, log2
from typing import NamedTuple

import bpy
import numpy as np

from ...scene.mesh_pieces import RawMesh
from .pictures import pixels_of
from .vertex_colors import corner_attribute

SHIFT, BITS, MOST = 1 << 12, 5, 256
MOST_TRIANGLES, MOST_LEVEL, FINE_STEPS = 1 << 15, 6, 16.0
COLOR_NODES = ("VERTEX_COLOR", "ATTRIBUTE")


class Source(NamedTuple):
    """What gives a material its varying colour: an attribute, or an image with the name of its UV map ('' the active one)."""

    attribute: str | None
    image: bpy.types.Image | None
    uv: str

    def key(self) -> tuple:
        """What tells it from another."""
        return self.attribute, self.image and self.image.session_uid, self.uv


Sources = tuple[tuple[int, Source], ...]  # by material slot


def sources_of(mesh: bpy.types.Mesh, known: dict[int, Source | None]) -> Sources:
    """The source of each material of a mesh that has one, a picture before an attribute. `known` keeps what was found of materials."""
    found = []
    for slot, material in enumerate(mesh.materials):
        if material is None or slot >= SHIFT:
            continue
        pointer = material.as_pointer()
        if pointer not in known:
            known[pointer] = None if material.node_tree is None else _source(material.node_tree)
        if known[pointer] is not None:
            found.append((slot, known[pointer]))
    return tuple(found)


def _source(tree: bpy.types.NodeTree) -> Source | None:
    source = None
    for node in tree.nodes:
        if node.mute or not any(out.is_linked for out in node.outputs if out.name in ("Color", "Vector", "Fac")):
            continue
        if node.type == "TEX_IMAGE" and node.image is not None and not node.image.colorspace_settings.is_data:
            uv = _uv_map(node)
            if uv is not None:
                return Source(None, node.image, uv)
        elif node.type in COLOR_NODES and getattr(node, "attribute_type", "GEOMETRY") == "GEOMETRY":
            source = Source(node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name, None, "")
    return source


def _uv_map(node: bpy.types.Node) -> str | None:
    """The UV map that an image is looked up by; None where other coordinates are."""
    vector = node.inputs["Vector"]
    if not vector.is_linked:
        return ""
    before = vector.links[0].from_node
    if before.type == "UVMAP":
        return before.uv_map
    return "" if before.type == "TEX_COORD" and vector.links[0].from_socket.name == "UV" else None


def tinted(mesh: bpy.types.Mesh, sources: Sources, raw: RawMesh, vertex: np.ndarray, loops: np.ndarray | None) -> RawMesh:
    """A mesh's arrays with slots that tell the colours where its materials vary; `vertex` (C,) of each corner, `loops` (T, 3) the corners
    of each triangle, None: in order. Triangles within which a colour varies are cut into smaller ones, as far as `MOST_TRIANGLES` allow."""
    count = len(raw.triangles)
    corners = np.arange(3 * count).reshape(-1, 3) if loops is None else loops
    slots = np.zeros(count, np.int32) if raw.slots is None else raw.slots.copy()
    own = np.minimum(slots, max(len(mesh.materials) - 1, 0))
    whole, pieces = np.ones(count, bool), []
    for slot, source in sources:
        chosen = np.flatnonzero(own == slot)
        values = _values(mesh, source, vertex) if len(chosen) else None
        if values is None:
            continue
        inner = values[corners[chosen]]
        parts = subdivision(_level(source, inner))
        codes = _codes(_colors(source, np.einsum("mc,tck->tmk", parts.mean(axis=1), inner).reshape(-1, inner.shape[2])))
        if not (codes != codes[0]).any():
            continue
        if len(parts) == 1:
            slots[chosen] = slot + SHIFT * (1 + codes)
        else:
            whole[chosen] = False
            pieces.append((chosen, parts, slot + SHIFT * (1 + codes)))
    if pieces:
        return _cut(replace(raw, slots=slots), whole, pieces)
    return replace(raw, slots=slots) if slots.any() else raw


def subdivision(level: int) -> np.ndarray:
    """(4 ** level, 3, 3) float32 the barycentric coordinates of the corners of the triangles that midpoints cut a triangle into."""
    parts = np.eye(3, dtype=np.float32)[None]
    for _ in range(level):
        a, b, c = parts[:, 0], parts[:, 1], parts[:, 2]
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return parts


def _level(source: Source, inner: np.ndarray) -> int:
    """How often to cut triangles with values (T, 3, k) at their corners: until a colour changes by less than a step, or a picture by less
    than a pixel, as long as there are not too many."""
    widest = float(np.abs(inner - np.roll(inner, 1, axis=1)).max())
    if source.image is None:
        wanted = widest * FINE_STEPS
    else:
        wanted = widest * max(pixels_of(source.image).shape[:2])
    most = log2(max(MOST_TRIANGLES / len(inner), 1.0)) / 2.0
    return int(min(ceil(log2(max(wanted, 1.0))), most, MOST_LEVEL))


def _cut(raw: RawMesh, whole: np.ndarray, pieces: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> RawMesh:
    """The arrays with triangles replaced by their parts: (which, barycentric corners of the parts, slots of all parts)."""
    positions, triangles, slots, first = [raw.positions], [raw.triangles[whole]], [raw.slots[whole]], len(raw.positions)
    normals = None if raw.corner_normals is None else [raw.corner_normals[whole]]
    for chosen, parts, own in pieces:
        points = np.einsum("mpc,tck->tmpk", parts, raw.positions[raw.triangles[chosen]]).reshape(-1, 3)
        positions.append(points)
        triangles.append(np.arange(first, first + len(points), dtype=np.int32).reshape(-1, 3))
        first += len(points)
        slots.append(own)
        if normals is not None:
            inner = np.einsum("mpc,tck->tmpk", parts, raw.corner_normals[chosen]).reshape(-1, 3, 3)
            normals.append(inner / np.maximum(np.linalg.norm(inner, axis=2, keepdims=True), np.float32(1e-6)))
    joined = None if normals is None else np.concatenate(normals).astype(np.float32)
    arrays = [np.concatenate(one) for one in (positions, triangles, slots)]
    return replace(
        raw, positions=arrays[0].astype(np.float32), triangles=arrays[1], slots=arrays[2].astype(np.int32), corner_normals=joined
    )


def _values(mesh: bpy.types.Mesh, source: Source, vertex: np.ndarray) -> np.ndarray | None:
    """(C, k) what each corner has: a colour, or the place in the picture; None where it is not there."""
    if source.image is None:
        return corner_attribute(mesh, source.attribute, vertex)
    layer = mesh.uv_layers.get(source.uv) if source.uv else mesh.uv_layers.active
    if pixels_of(source.image) is None or layer is None:
        return None
    flat = np.empty(2 * len(vertex), np.float32)
    layer.data.foreach_get("uv", flat)
    return np.nan_to_num(flat.reshape(-1, 2))


def _colors(source: Source, values: np.ndarray) -> np.ndarray:
    """(N, 3) linear colours of values: themselves, or the picture there, which repeats."""
    if source.image is None:
        return values
    pixels = pixels_of(source.image)
    within = values.astype(np.float64)
    place = ((within - np.floor(within)) * [pixels.shape[1], pixels.shape[0]]).astype(np.int64)
    return pixels[np.minimum(place[:, 1], len(pixels) - 1), np.minimum(place[:, 0], pixels.shape[1] - 1), :3]


def _codes(colors: np.ndarray) -> np.ndarray:
    """(T,) int32 of (T, 3) linear colours: as many bits of each channel as leave at most `MOST` colours."""
    root = np.sqrt(np.clip(colors.astype(np.float64), 0.0, 1.0))
    for bits in range(BITS, 0, -1):
        steps = (1 << bits) - 1
        level = np.rint(np.rint(root * steps) / steps * ((1 << BITS) - 1)).astype(np.int32)
        codes = (level[:, 0] << 2 * BITS) | (level[:, 1] << BITS) | level[:, 2]
        if len(np.unique(codes)) <= MOST:
            break
    return codes


def slot_and_color(slot: int) -> tuple[int, np.ndarray | None]:
    """The material slot that a number stands for, and the linear colour (3,) of its triangles, None where it has none."""
    if slot < SHIFT:
        return slot, None
    code = slot // SHIFT - 1
    level = np.array([code >> 2 * BITS, code >> BITS & 31, code & 31], np.float64) / ((1 << BITS) - 1)
    return slot % SHIFT, level * level
