"""Wavefront OBJ through trimesh, with the parts kept.

trimesh merges the `o` groups unless asked not to, and then joins the names of part and material with an underscore, which cannot be
taken apart again. So materials are renamed before parsing: a control character in front makes the seam plain.
"""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from ..cad_model import CadMaterial
from .colors import rgba
from .raw import RawFile, RawNode, RawPiece

MARK = "\x02"


def read_obj(path: Path) -> RawFile:
    """An `.obj` file with its `.mtl`; parts are the `o` groups, or the `g` groups of a file without any `o`."""
    from trimesh.exchange.obj import load_obj

    data = path.read_bytes().replace(b"\r\n", b"\n")
    data = re.sub(rb"(?m)^usemtl[ \t]+", b"usemtl " + MARK.encode(), data)
    has_o = re.search(rb"(?m)^o ", data) is not None
    resolver = _MarkedMaterials(path)
    loaded = load_obj(io.BytesIO(data), resolver=resolver, split_objects=has_o, split_groups=not has_o)
    raw = RawFile()
    if resolver.missing:
        raw.warnings.append(f"The material file {resolver.missing} is missing: parts are grey. Put it beside {path.name}.")
    for name, g in loaded.get("geometry", {}).items():
        if g.get("faces") is not None:
            _add_piece(raw, name, g, path.stem)
    return raw


class _MarkedMaterials:
    """A trimesh resolver that gives the material file with every name marked, and nothing else (textures are not read)."""

    def __init__(self, path: Path) -> None:
        self.path, self.missing = path, ""
        self.file_name = path.stem

    def __getitem__(self, name: str) -> bytes:
        file = self.path.parent / name.strip().strip('"')
        if file.suffix.lower() != ".mtl":
            raise OSError(f"{name} is not read")
        try:
            text = file.read_bytes()
        except OSError:
            self.missing = file.name
            raise
        return re.sub(rb"(?m)^(\s*newmtl[ \t]+)", rb"\1" + MARK.encode(), text)

    get = __getitem__


def _add_piece(raw: RawFile, name: str, g: dict, stem: str) -> None:
    part = name.split("_" + MARK)[0]
    if part.startswith(MARK):
        part = stem
    if part not in raw.meshes:
        raw.meshes[part] = (part, [])
        raw.nodes.append(RawNode(part, mesh=part))
    material = getattr(g.get("visual"), "material", None)
    key = getattr(material, "name", None)
    if key is not None and key not in raw.materials:
        raw.materials[key] = _material(material)
    triangles = np.asarray(g["faces"]).reshape(-1, 3)
    colors = g.get("vertex_colors")
    per_triangle = rgba(colors, is_srgb=True)[triangles].mean(axis=1) if colors is not None and key is None and len(triangles) else None
    raw.meshes[part][1].append(RawPiece(g["vertices"], triangles, g.get("vertex_normals"), key, per_triangle))


def _material(material: object) -> CadMaterial:
    """`Kd` is taken as linear, as Blender takes it."""
    diffuse = np.asarray(material.diffuse, dtype=np.float64) / 255.0
    return CadMaterial(material.name.lstrip(MARK), tuple(float(c) for c in diffuse))
