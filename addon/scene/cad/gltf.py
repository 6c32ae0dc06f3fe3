"""glTF 2.0 through trimesh's loader (its arrays, not its scene: no copy, no cache, no scene graph of Python objects)."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np

from ...errors import CadFileError
from ..cad_model import CadMaterial
from .colors import rgba
from .companions import Buffers
from .raw import RawFile, RawNode, RawPiece

UNREADABLE = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt"}


def read_gltf(path: Path) -> RawFile:
    """A `.glb` or `.gltf` with the files it refers to."""
    from trimesh.exchange.gltf import load_glb, load_gltf

    data = path.read_bytes()
    header = _header(data)
    _refuse_unreadable(path, header)
    load = load_glb if data[:4] == b"glTF" else load_gltf
    return from_trimesh(load(io.BytesIO(data), resolver=Buffers(path, header)), header, path)


def read_glb_bytes(data: bytes, path: Path) -> RawFile:
    """A GLB in memory (what cascadio makes of the STEP file at `path`)."""
    from trimesh.exchange.gltf import load_glb

    return from_trimesh(load_glb(io.BytesIO(data)), _header(data), path)


def _header(data: bytes) -> dict:
    if data[:4] == b"glTF":
        length = int.from_bytes(data[12:16], "little")
        return json.loads(data[20 : 20 + length])
    return json.loads(data)


def _refuse_unreadable(path: Path, header: dict) -> None:
    for name, title in UNREADABLE.items():
        if name in header.get("extensionsRequired", ()):
            raise CadFileError(f"{path.name} is compressed with {title}, which this program cannot read: export it without compression.")


def from_trimesh(loaded: dict, header: dict, path: Path) -> RawFile:
    """Claim: the loader's `geometry` and `graph` as a `RawFile`; the primitives of one glTF mesh become one mesh with several slots."""
    raw = RawFile(units=None)
    geometry = loaded["geometry"]
    factors = [m.get("pbrMetallicRoughness", {}).get("baseColorFactor") for m in header.get("materials", [])]
    exact = {m.get("name"): f for m, f in zip(header.get("materials", []), factors, strict=True)}
    skipped = [name for name, g in geometry.items() if "faces" not in g]
    if skipped:
        raw.warnings.append(f"{len(skipped)} primitives are lines or points: left out.")
    pieces = {name: _piece(g, raw, exact) for name, g in geometry.items() if "faces" in g}
    _add_nodes(raw, loaded, geometry, pieces)
    if pieces and not raw.meshes:
        raise CadFileError(f"{path.name} holds meshes but places none of them in its scene: export the scene, not only a library of parts.")
    return raw


def _piece(g: dict, raw: RawFile, exact: dict) -> RawPiece:
    visual = g.get("visual")
    material = getattr(visual, "material", None)
    if material is not None and id(material) not in raw.materials:
        raw.materials[id(material)] = _material(material, exact)
    triangles = np.asarray(g["faces"])
    colors = g.get("vertex_colors")
    if colors is None and visual is not None:
        colors = visual.vertex_attributes.get("color")
    per_triangle = None if colors is None or not len(triangles) else rgba(colors, is_srgb=False)[triangles[:, 0]]
    if per_triangle is not None and material is not None:
        per_triangle = per_triangle * np.array(raw.materials[id(material)].base_color)
    return RawPiece(g["vertices"], triangles, g.get("vertex_normals"), id(material) if material is not None else None, per_triangle)


def _material(material: object, exact: dict) -> CadMaterial:
    """trimesh keeps 8 bits of the linear colour; the header has it all, found by name."""
    color = exact.get(material.name) if material.name else None
    if color is None:
        stored = material.baseColorFactor
        color = (1.0, 1.0, 1.0, 1.0) if stored is None else np.asarray(stored) / 255.0
    metallic, roughness = material.metallicFactor, material.roughnessFactor
    return CadMaterial(
        material.name or "Material",
        tuple(float(c) for c in color),
        1.0 if metallic is None else float(metallic),
        1.0 if roughness is None else float(roughness),
    )


def _add_nodes(raw: RawFile, loaded: dict, geometry: dict, pieces: dict) -> None:
    """The edge list as nodes, parents first. Children that only carry the primitives of one mesh are merged into their parent."""
    primitives: dict[str, list[str]] = {}
    edges = []
    for edge in loaded["graph"]:
        name = edge.get("geometry")
        if (
            name is not None
            and geometry[name].get("metadata", {}).get("from_gltf_primitive")
            and edge["frame_to"].startswith(edge["frame_from"] + "_")
        ):
            primitives.setdefault(edge["frame_from"], []).append(name)
        else:
            edges.append(edge)
    index: dict[str, int] = {}
    for edge in edges:
        frame = edge["frame_to"]
        own = [edge["geometry"]] if "geometry" in edge else primitives.get(frame, [])
        own = [name for name in own if name in pieces]
        key = tuple(own)
        if own and key not in raw.meshes:
            raw.meshes[key] = (own[0], [pieces[name] for name in own])
        index[frame] = len(raw.nodes)
        raw.nodes.append(RawNode(frame, index.get(edge["frame_from"], -1), key if own else None, edge.get("matrix")))
