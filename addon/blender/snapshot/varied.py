"""Colours that vary over a mesh (colour attributes, pictures), told apart by triangle: each class is drawn as a slot of its own.

A slot with a colour is a number: `slot + SHIFT · (1 + code)`, the code 5 bits of the square root of each linear channel, so that the number
alone says the colour. As many bits count as leave at most `MOST` colours in a mesh.
"""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from .pictures import pixels_of
from .vertex_colors import corner_attribute

SHIFT, BITS, MOST = 1 << 12, 5, 96
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


def with_colors(
    mesh: bpy.types.Mesh, sources: Sources, vertex: np.ndarray, loops: np.ndarray | None, slots: np.ndarray | None
) -> np.ndarray | None:
    """(T,) the slots, with a colour where their material varies. `vertex` (C,) of each corner, `loops` (T, 3) corners or None: in order."""
    count = len(vertex) // 3 if loops is None else len(loops)
    corners = np.arange(3 * count).reshape(-1, 3) if loops is None else loops
    out = np.zeros(count, np.int32) if slots is None else slots.copy()
    own = np.minimum(out, max(len(mesh.materials) - 1, 0))
    for slot, source in sources:
        chosen = np.flatnonzero(own == slot)
        colors = _colors(mesh, source, vertex, corners[chosen]) if len(chosen) else None
        if colors is not None:
            codes = _codes(colors)
            if (codes != codes[0]).any():
                out[chosen] = slot + SHIFT * (1 + codes)
    return out if slots is not None or out.any() else None


def _colors(mesh: bpy.types.Mesh, source: Source, vertex: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
    """(T, 3) linear colour of each triangle: the mean of its corners, or the picture at its middle."""
    if source.image is None:
        values = corner_attribute(mesh, source.attribute, vertex)
        return None if values is None else values[corners].mean(axis=1)
    pixels = pixels_of(source.image)
    layer = mesh.uv_layers.get(source.uv) if source.uv else mesh.uv_layers.active
    if pixels is None or layer is None:
        return None
    flat = np.empty(2 * len(vertex), np.float32)
    layer.data.foreach_get("uv", flat)
    middle = np.nan_to_num(flat.reshape(-1, 2))[corners].mean(axis=1, dtype=np.float64)
    place = ((middle - np.floor(middle)) * [pixels.shape[1], pixels.shape[0]]).astype(np.int64)
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
