"""The raw pieces of a file cleaned, all together: numpy costs microseconds per call, and an assembly has thousands of small pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..mesh_prep import Defects, drawable
from .raw import RawPiece

COARSE = 1e-4


@dataclass(frozen=True, eq=False)
class CleanPiece:
    """What is left of a piece: `positions` (V, 3) float64 metres, Z up; `triangles` (T, 3); `normals` (V, 3) float32 or None;
    `kept` (all triangles,) bool tells which of the file's triangles these are."""

    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None
    kept: np.ndarray


def clean_pieces(pieces: Sequence[RawPiece], metres_from_file: np.ndarray) -> tuple[list[CleanPiece | None], Defects]:
    """Claim: each piece in metres and Z up without its bad vertices and triangles (None when no triangle is left), and their count.

    `metres_from_file` (3, 3) is a rotation times a scale. A vertex that float32 cannot hold counts as infinite.
    """
    counts = np.array([len(p.positions) for p in pieces])
    sizes = np.array([len(p.triangles) for p in pieces])
    if not sizes.sum():
        return [None] * len(pieces), Defects()
    raw = np.concatenate([np.asarray(p.positions, dtype=np.float64).reshape(-1, 3) for p in pieces])
    raw[np.abs(raw) > np.finfo(np.float32).max] = np.inf
    with np.errstate(invalid="ignore", under="ignore"):
        points = raw @ metres_from_file.T
    triangles = _joined_triangles(pieces, counts, sizes)
    with np.errstate(under="ignore"):
        keep, defects = drawable(points, triangles)
    turn = metres_from_file / np.cbrt(np.linalg.det(metres_from_file))
    first_point, first_triangle = np.cumsum(counts) - counts, np.cumsum(sizes) - sizes
    is_whole = _all_of(keep, sizes) & _all_of(np.isfinite(points).all(axis=1), counts)
    cleaned: list[CleanPiece | None] = []
    for i, piece in enumerate(pieces):
        own = slice(first_triangle[i], first_triangle[i] + sizes[i])
        position = points[first_point[i] : first_point[i] + counts[i]]
        whole = CleanPiece(position, triangles[own] - first_point[i], _turned(piece, turn), keep[own])
        cleaned.append(whole if is_whole[i] and sizes[i] else _rest(whole))
    return cleaned, defects


def _joined_triangles(pieces: Sequence[RawPiece], counts: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """All triangles with the numbers of the joined vertices; those that point outside their own piece get −1."""
    triangles = np.concatenate([np.asarray(p.triangles, dtype=np.int64).reshape(-1, 3) for p in pieces])
    own_count = np.repeat(counts, sizes)[:, None]
    outside = (triangles < 0) | (triangles >= own_count)
    triangles += np.repeat(np.cumsum(counts) - counts, sizes)[:, None]
    triangles[outside.any(axis=1)] = -1
    return triangles


def _all_of(mask: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """(N,) bool: whether each run of `mask` of the given lengths is all true."""
    bad = np.concatenate([[0], np.cumsum(~mask)])
    ends = np.cumsum(lengths)
    return bad[ends] == bad[ends - lengths]


def _rest(piece: CleanPiece) -> CleanPiece | None:
    if not piece.kept.any():
        return None
    triangles = piece.triangles[piece.kept]
    used = np.zeros(len(piece.positions), dtype=bool)
    used[triangles.ravel()] = True
    number = np.cumsum(used) - 1
    return CleanPiece(piece.positions[used], number[triangles], None if piece.normals is None else piece.normals[used], piece.kept)


def _turned(piece: RawPiece, turn: np.ndarray) -> np.ndarray | None:
    """The file's normals, turned and of unit length; None if any is missing, NaN or zero (then the crease angle decides)."""
    if piece.normals is None or len(piece.normals) != len(piece.positions):
        return None
    turned = np.asarray(piece.normals, dtype=np.float64) @ turn.T
    length = np.sqrt(np.einsum("ij,ij->i", turned, turned))
    return (turned / length[:, None]).astype(np.float32) if bool((length > 1e-6).all()) else None


def own_centre(positions: np.ndarray) -> np.ndarray:
    """(3,) float64 what to subtract from (V, 3) float64 positions before they become float32: 0, or their centre when they lie so far
    from the origin that float32's step there is more than `COARSE` of the mesh's size."""
    return (positions.min(axis=0) + positions.max(axis=0)) / 2 if is_coarse(positions) else np.zeros(3)


def is_coarse(positions: np.ndarray) -> bool:
    """Whether (V, 3) positions lie so far from the origin that float32's step there is more than `COARSE` of their size."""
    if not len(positions):
        return False
    low, high = positions.min(axis=0).astype(np.float64), positions.max(axis=0).astype(np.float64)
    return float(np.abs([low, high]).max()) * float(np.finfo(np.float32).eps) > COARSE * float((high - low).max())
