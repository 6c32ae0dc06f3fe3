"""From one format's raw arrays to a `CadModel`: units and axes applied, bad triangles left out, pieces joined into slots."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..cad_model import CadMaterial, CadMesh, CadModel, CadPart
from ..errors import CadFileError
from ..pipeline.mesh_prep import Defects, drawable
from .colors import color_slots
from .raw import RawFile, RawPiece
from .units import FORMAT_DEFAULTS, metres_per_unit, z_up_from


def assemble(raw: RawFile, file: Path, units: str | None, up: str | None) -> CadModel:
    """Claim: the model in metres and Z up; raises `CadFileError` when not one triangle with an area is left."""
    default_unit, default_up, is_fixed = FORMAT_DEFAULTS[file.suffix.lower()]
    warnings = list(raw.warnings)
    unit, scale = metres_per_unit(units or raw.units or default_unit)
    axis = (up or default_up).upper()
    if units is None and raw.units is None and not is_fixed:
        warnings.append(f"{file.name} names no unit: taken as metres. Set the unit if that is wrong.")
    builder = _Builder(raw, scale * z_up_from(axis))
    meshes = {key: builder.mesh(name, pieces) for key, (name, pieces) in raw.meshes.items()}
    kept = {key: i for i, key in enumerate(k for k, m in meshes.items() if m is not None)}
    if not kept:
        detail = f" {builder.defects.sentence()}" if builder.defects else ""
        raise CadFileError(f"{file.name} holds no face to draw: export it with surfaces or a mesh.{detail}")
    if builder.defects:
        warnings.append(builder.defects.sentence(file.name))
    if len(kept) < len(meshes):
        warnings.append(f"{len(meshes) - len(kept)} meshes of {file.name} hold no face and were left out.")
    parts = _parts(raw, kept, scale, z_up_from(axis), warnings)
    if not any(p.mesh >= 0 for p in parts):
        raise CadFileError(f"{file.name} holds meshes but places none of them in its scene: export the scene, not only the library.")
    return CadModel(
        file.stem, tuple(m for m in meshes.values() if m is not None), parts, tuple(builder.materials), unit, scale, axis, tuple(warnings)
    )


def _parts(raw: RawFile, kept: dict[object, int], scale: float, turn: np.ndarray, warnings: list[str]) -> tuple[CadPart, ...]:
    """Nodes as parts. A matrix M becomes C M C⁻¹ with C the turn and the scale, so parts keep unit scale and upright axes."""
    parts, bad = [], 0
    for node in raw.nodes:
        matrix = np.eye(4) if node.matrix is None else np.asarray(node.matrix, dtype=np.float64)
        is_finite = bool(np.isfinite(matrix).all())
        bad += not is_finite
        changed = np.eye(4)
        if is_finite:
            changed[:3, :3] = turn @ matrix[:3, :3] @ turn.T
            changed[:3, 3] = scale * (turn @ matrix[:3, 3])
        parts.append(CadPart(node.name, node.parent, kept.get(node.mesh, -1) if node.mesh is not None and is_finite else -1, changed))
    if bad:
        warnings.append(f"{bad} parts are placed at NaN or infinity and were left out.")
    return tuple(parts)


class _Builder:
    """Makes meshes; gathers the materials they use and the defects they had."""

    def __init__(self, raw: RawFile, metres_from_file: np.ndarray) -> None:
        self.raw, self.metres_from_file = raw, metres_from_file
        self.turn = metres_from_file / np.cbrt(np.linalg.det(metres_from_file))
        self.materials: list[CadMaterial] = []
        self.defects = Defects()
        self._index: dict[object, int] = {}

    def mesh(self, name: str, pieces: list[RawPiece]) -> CadMesh | None:
        """The pieces as one mesh with a slot per material; None when no triangle is left."""
        positions, triangles, normals, slots, used = [], [], [], [], []
        offset = 0
        for piece in pieces:
            clean = self._clean(piece)
            if clean is None:
                continue
            p, t, n, keep = clean
            positions.append(p)
            triangles.append(t + offset)
            normals.append(n)
            slots.append(self._slots(piece, keep, used, len(t)))
            offset += len(p)
        if not positions:
            return None
        all_normals = np.concatenate(normals) if all(n is not None for n in normals) else None
        slot = np.concatenate(slots) if len(used) > 1 else None
        return CadMesh(name, np.concatenate(positions), np.concatenate(triangles), all_normals, tuple(used), slot)

    def _clean(self, piece: RawPiece) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray] | None:
        with np.errstate(over="ignore", invalid="ignore"):
            points = (np.asarray(piece.positions, dtype=np.float64).reshape(-1, 3) @ self.metres_from_file.T).astype(np.float32)
        triangles = np.asarray(piece.triangles).reshape(-1, 3)
        keep, defects = drawable(points, triangles)
        self.defects = self.defects + defects
        if not keep.any():
            return None
        normals = self._normals(piece, len(points))
        if keep.all() and not defects.bad_vertices:
            return points, triangles.astype(np.int32), normals, keep
        triangles = triangles[keep]
        used = np.zeros(len(points), dtype=bool)
        used[triangles] = True
        number = np.cumsum(used, dtype=np.int32) - 1
        return points[used], number[triangles], None if normals is None else normals[used], keep

    def _normals(self, piece: RawPiece, count: int) -> np.ndarray | None:
        """The file's normals, turned and of unit length; None if any is missing, NaN or zero (then the crease angle decides)."""
        if piece.normals is None or len(piece.normals) != count:
            return None
        turned = np.asarray(piece.normals, dtype=np.float64) @ self.turn.T
        length = np.sqrt(np.einsum("ij,ij->i", turned, turned))
        return (turned / length[:, None]).astype(np.float32) if bool((length > 1e-6).all()) else None

    def _slots(self, piece: RawPiece, keep: np.ndarray, used: list[int], count: int) -> np.ndarray:
        """Slot of each kept triangle; adds the materials to `used`, the mesh's slots."""
        if piece.triangle_colors is not None:
            colors, of = color_slots(piece.triangle_colors[keep])
            own = np.array([_slot_of(used, self._color(c)) for c in colors], dtype=np.int32)
            return own[of]
        if piece.material is None:
            return np.full(count, _slot_of(used, self._color(np.array([0.8, 0.8, 0.8, 1.0]))) if used else 0, dtype=np.int32)
        return np.full(count, _slot_of(used, self._material(piece.material, self.raw.materials[piece.material])), dtype=np.int32)

    def _color(self, color: np.ndarray) -> int:
        steps = tuple(int(round(255 * float(c))) for c in color)
        name = "Color " + "".join(f"{s:02x}" for s in steps[:3])
        return self._material(steps, CadMaterial(name, tuple(float(c) for c in color)))

    def _material(self, key: object, material: CadMaterial) -> int:
        if key not in self._index:
            self._index[key] = len(self.materials)
            self.materials.append(material)
        return self._index[key]


def _slot_of(used: list[int], material: int) -> int:
    if material not in used:
        used.append(material)
    return used.index(material)
