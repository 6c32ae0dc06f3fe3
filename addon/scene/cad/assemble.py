"""From one format's raw arrays to a `CadModel`: units and axes applied, bad triangles left out, pieces joined into slots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import CadFileError
from ..cad_model import CadMaterial, CadMesh, CadModel, CadPart
from ..plain_text import shown
from .cad_format import CadFormat
from .cleaning import CleanPiece, clean_pieces, own_centre
from .colors import color_slots
from .raw import RawFile, RawPiece
from .units import metres_per_unit, z_up_from

COARSE_PLACE_M = 1e-3
GREY = np.array([0.8, 0.8, 0.8, 1.0])


def assemble(raw: RawFile, file: Path, kind: CadFormat, units: str | None, up: str | None) -> CadModel:
    """Claim: the model in metres and Z up; raises `CadFileError` when not one triangle with an area is left."""
    warnings = list(raw.warnings)
    unit, scale = metres_per_unit(units or raw.units or kind.unit)
    axis = (up or raw.up or kind.up).strip().upper()
    turn = z_up_from(axis)
    if units is None and raw.units is None and not kind.fixes_unit:
        warnings.append(f"{file.name} names no unit: taken as metres. Set the unit if that is wrong.")
    cleaned, defects = clean_pieces([piece for _, pieces in raw.meshes.values() for piece in pieces], scale * turn)
    builder = _Builder(raw, cleaned)
    meshes = {key: builder.mesh(name, pieces, key) for key, (name, pieces) in raw.meshes.items()}
    kept = {key: i for i, key in enumerate(k for k, m in meshes.items() if m is not None)}
    if not kept:
        detail = f" {defects.sentence()}" if defects else ""
        said = "".join(f" {line}" for line in raw.warnings)
        raise CadFileError(f"{file.name} holds no face to draw: export it with surfaces or a mesh.{detail}{said}")
    if defects:
        warnings.append(defects.sentence(file.name))
    if len(kept) < len(meshes):
        warnings.append(f"{len(meshes) - len(kept)} meshes of {file.name} hold no face and were left out.")
    parts = _parts(raw, kept, builder.centres, _matrices(raw, scale, turn), warnings)
    if not any(p.mesh >= 0 for p in parts):
        raise CadFileError(f"{file.name} places all its parts at NaN or infinity: export it again.")
    used = tuple(m for m in meshes.values() if m is not None)
    model = CadModel(_text(file.stem), used, parts, tuple(builder.materials), unit, scale, axis)
    warnings += _far(model, file.name)
    return replace(model, warnings=tuple(map(shown, warnings)))


def _far(model: CadModel, name: str) -> list[str]:
    """A line where parts stand so far away that Blender, which places objects by float32, moves them by more than a millimetre."""
    places = model.world_from_part()[[i for i, part in enumerate(model.parts) if part.mesh >= 0], :3, 3]
    distance = float(np.abs(places).max())
    step = float(np.spacing(np.float32(min(distance, 1e30))))
    if step < COARSE_PLACE_M:
        return []
    return [
        f"{name} lies {distance:,.0f} m from the origin, where Blender places objects in steps of {step:.2g} m only: "
        "parts may stand that much beside their place. Move the model to the origin before export."
    ]


def _matrices(raw: RawFile, scale: float, turn: np.ndarray) -> np.ndarray:
    """(N, 4, 4) of all nodes. A matrix M becomes C M C⁻¹ with C the turn and the scale, so parts keep unit scale and upright axes; lights
    and cameras keep the axes of the file, which they look along: for them the change is the scale alone."""
    identity = np.eye(4)
    file = np.array([identity if node.matrix is None else node.matrix for node in raw.nodes], dtype=np.float64).reshape(-1, 4, 4)
    change = np.tile(identity, (len(raw.nodes) + 1, 1, 1))  # the last is that of the file itself, the parent of the roots
    change[:, :3, :3] = scale * turn
    change[[i for i, node in enumerate(raw.nodes) if node.item is not None], :3, :3] = scale * np.eye(3)
    above = [node.parent for node in raw.nodes]
    with np.errstate(invalid="ignore", over="ignore", under="ignore"):
        return change[above] @ file @ np.linalg.inv(change[:-1])


def _parts(
    raw: RawFile, kept: dict[object, int], centres: dict[object, np.ndarray], matrices: np.ndarray, warnings: list[str]
) -> tuple[CadPart, ...]:
    """Nodes as parts; a mesh that was moved to its own centre is put back by its part's matrix."""
    finite = np.isfinite(matrices).all(axis=(1, 2))
    matrices[~finite] = np.eye(4)
    parts = []
    for node, matrix, is_finite in zip(raw.nodes, matrices, finite.tolist(), strict=True):
        mesh = kept.get(node.mesh, -1) if node.mesh is not None and is_finite else -1
        if mesh >= 0 and node.mesh in centres:
            matrix[:3, 3] += matrix[:3, :3] @ centres[node.mesh]
        parts.append(CadPart(_text(node.name), node.parent, mesh, matrix, node.item, node.is_hidden))
    if not finite.all():
        warnings.append(f"{np.count_nonzero(~finite)} parts are placed at NaN or infinity and were left out.")
    return tuple(parts)


class _Builder:
    """Makes meshes of cleaned pieces (handed over in order); gathers the materials they use and the centres they were moved from."""

    def __init__(self, raw: RawFile, cleaned: Sequence[CleanPiece | None]) -> None:
        self.raw, self.cleaned = raw, iter(cleaned)
        self.materials: list[CadMaterial] = []
        self.centres: dict[object, np.ndarray] = {}
        self.with_children = {raw.nodes[node.parent].mesh for node in raw.nodes if node.parent >= 0}
        self._index: dict[object, int] = {}

    def mesh(self, name: str, pieces: list[RawPiece], key: object) -> CadMesh | None:
        """The pieces as one mesh with a slot per material; None when no triangle is left."""
        present = [(piece, clean) for piece, clean in [(piece, next(self.cleaned)) for piece in pieces] if clean is not None]
        if not present:
            return None
        used: list[int] = []
        slots, colors = self._looks(present, used)
        clean = [c for _, c in present]
        firsts = np.cumsum([0] + [len(c.positions) for c in clean])
        positions = clean[0].positions if len(clean) == 1 else np.concatenate([c.positions for c in clean])
        triangles = np.concatenate([c.triangles + f for c, f in zip(clean, firsts, strict=False)])
        normals = None if any(c.normals is None for c in clean) else np.concatenate([c.normals for c in clean])
        uvs = _joined([(piece.corner_uvs, clean) for piece, clean in present], np.zeros(2, np.float32))
        if key not in self.with_children:
            centre = own_centre(positions)
            if centre.any():
                self.centres[key], positions = centre, positions - centre
        with np.errstate(under="ignore"):
            return CadMesh(_text(name), positions, triangles, normals, tuple(used), slots if len(used) > 1 else None, colors, uvs)

    def _looks(self, present: list[tuple[RawPiece, CleanPiece]], used: list[int]) -> tuple[np.ndarray | None, np.ndarray | None]:
        """The slot of each kept triangle and the colours of its corners, None where all are alike; adds the materials to `used`."""
        if all(piece.material is None and piece.corner_colors is None for piece, _ in present):
            return None, None
        faces = [None if p.corner_colors is None else _face_slots(p, c, self.raw.materials.get(p.material)) for p, c in present]
        slots = [self._slots(piece, clean, own, used) for (piece, clean), own in zip(present, faces, strict=True)]
        varied = [(p.corner_colors if own is None else None, c) for (p, c), own in zip(present, faces, strict=True)]
        return np.concatenate(slots), _joined(varied, np.ones(4, np.float32))

    def _slots(self, piece: RawPiece, clean: CleanPiece, faces: tuple[np.ndarray, np.ndarray] | None, used: list[int]) -> np.ndarray:
        """Slot of each kept triangle; adds the materials to `used`, the mesh's slots."""
        own = None if piece.material is None else self.raw.materials[piece.material]
        if faces is not None:
            keeps_name = len(faces[0]) == 1
            return np.array([_slot_of(used, self._color(c, piece.material, own, keeps_name)) for c in faces[0]], dtype=np.int32)[faces[1]]
        if piece.corner_colors is not None:
            plain = own or CadMaterial("Vertex Colors", (1.0, 1.0, 1.0, 1.0))
            material = self._material(("varied", piece.material), replace(plain, has_vertex_colors=True))
        else:
            material = self._color(GREY, None, None) if own is None else self._material(piece.material, own)
        return np.full(len(clean.triangles), _slot_of(used, material), dtype=np.int32)

    def _color(self, color: np.ndarray, key: object, of: CadMaterial | None, keeps_name: bool = False) -> int:
        """The material of one colour, which multiplies that of a material where there is one, under its name or that and the colour's."""
        steps = tuple(int(round(255 * float(c))) for c in color)
        name = "Color " + "".join(f"{s:02x}" for s in steps[:3])
        if of is None:
            return self._material(steps, CadMaterial(name, tuple(float(c) for c in color)))
        tinted = tuple(float(c * own) for c, own in zip(color, of.base_color, strict=True))
        return self._material((key, steps), replace(of, name=of.name if keeps_name else f"{of.name} {name}", base_color=tinted))

    def _material(self, key: object, material: CadMaterial) -> int:
        if key not in self._index:
            self._index[key] = len(self.materials)
            self.materials.append(replace(material, name=_text(material.name)))
        return self._index[key]


def _face_slots(piece: RawPiece, clean: CleanPiece, material: CadMaterial | None) -> tuple[np.ndarray, np.ndarray] | None:
    """The few colours of a piece whose triangles are of one colour each, and that of each kept triangle; None of any other piece."""
    if piece.corner_colors is None or (material is not None and material.image is not None):
        return None
    return color_slots(piece.corner_colors[clean.kept])


def _joined(pieces: list[tuple[np.ndarray | None, CleanPiece]], default: np.ndarray) -> np.ndarray | None:
    """(T, 3, k) what the corners of the kept triangles of all pieces have, the default where one has nothing; None if none has any."""
    if all(own is None for own, _ in pieces):
        return None
    return np.concatenate([np.tile(default, (len(c.triangles), 3, 1)) if own is None else own[c.kept] for own, c in pieces])


def _text(name: object) -> str:
    """A name as Blender takes it: whole characters, none of them zero."""
    return str(name).encode("utf-8", "replace").decode().replace("\0", "")


def _slot_of(used: list[int], material: int) -> int:
    if material not in used:
        used.append(material)
    return used.index(material)
