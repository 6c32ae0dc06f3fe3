"""IGES: OpenCASCADE (cascadio) makes triangles of its surfaces, in a GLB that counts millimetres whatever the file's unit."""

from __future__ import annotations

import re
from pathlib import Path

from ...errors import CadFileError
from .cad_format import CadFormat, starts_text
from .cleaning import is_coarse
from .gltf import read_glb_bytes
from .raw import RawFile

LINEAR_MM, ANGULAR_RAD = 0.01, 0.5
NAMELESS = re.compile(r"|=>.*|(COMPOUND|COMPSOLID|SOLID|SHELL|FACE|SHAPE|Node|Mesh)[ _]?\d*")


def read_iges(path: Path) -> RawFile:
    """An `.iges` or `.igs` file: its surfaces, with their names and colours; curves and points are no faces."""
    try:
        import cascadio
    except ImportError as error:
        raise CadFileError(
            f"{path.name} is an IGES file, and its reader (cascadio) is not installed: use the zip for your platform."
        ) from error
    kind = cascadio.FileType.IGES
    glb = cascadio.to_glb_bytes(path.read_bytes(), kind, tol_linear=LINEAR_MM, tol_angular=ANGULAR_RAD, merge_primitives=False)
    if not glb:
        raise CadFileError(f"{path.name} cannot be read as IGES: it may be damaged, or hold no surface. Export it again, or as STEP.")
    raw = read_glb_bytes(glb, path)
    raw.units = "mm"
    for node in raw.nodes:
        node.name = path.stem if NAMELESS.fullmatch(node.name) else node.name
    raw.meshes.update({key: (path.stem if NAMELESS.fullmatch(name) else name, own) for key, (name, own) in raw.meshes.items()})
    far = [name for name, pieces in raw.meshes.values() if any(is_coarse(piece.positions) for piece in pieces)]
    if far:
        raw.warnings.append(f"{path.name}: {len(far)} parts lie so far from their origin that their shape is coarse: export it as STEP.")
    return raw


IS_IGES = starts_text(rb"[^\r\n]{72}S[ 0]{0,6}1\s")
ROW = CadFormat("IGES", {".iges": IS_IGES, ".igs": IS_IGES}, read_iges, place=15, unit="mm", fixes_unit=True)
