"""From raw meshes to drawable ones, one for each material slot, many at a time.

numpy needs some microseconds per call however short the arrays are, and an assembly has thousands of small parts: so meshes are
joined, worked on together (kept apart by a group number), and cut into pieces again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .mesh_prep import Defects, Shaded, drawable, shade_by_corners, shade_by_crease
from .records import Mesh

FAR = 4.0
TRIANGLES_AT_ONCE = 1 << 18


@dataclass(frozen=True, eq=False)
class RawMesh:
    """`positions` (V, 3) float32, `triangles` (T, 3) int32, `slots` (T,) int32 or None = all 0, `corner_normals` (T, 3, 3) float32.

    `crease_rad`: its own crease angle, where it has no usable corner normals; None: whatever is asked for.
    """

    positions: np.ndarray
    triangles: np.ndarray
    slots: np.ndarray | None = None
    corner_normals: np.ndarray | None = None
    crease_rad: float | None = None

    def digest(self) -> bytes:
        """16 bytes that name the content."""
        digest = hashlib.blake2b(b"" if self.crease_rad is None else repr(self.crease_rad).encode(), digest_size=16)
        for array in (self.positions, self.triangles, self.slots, self.corner_normals):
            digest.update(b"-" if array is None else np.ascontiguousarray(array).data)
        return digest.digest()


@dataclass(frozen=True, eq=False)
class Prepared:
    """Drawable meshes, one per material slot used (`slots` says which), relative to `offset_os` (3,) float64; and what was left out."""

    meshes: tuple[Mesh, ...]
    slots: tuple[int, ...]
    offset_os: np.ndarray
    defects: Defects


def prepare_all(raws: Sequence[RawMesh], keys: Sequence[Hashable], crease_angle_rad: float) -> list[Prepared]:
    """Claim: for each mesh its drawable pieces; the same arrays whatever it is prepared together with.

    Bad triangles are left out and counted. The mesh's own corner normals are used where it has them (all of unit length), else its crease
    angle, or the one given, decides. A mesh that lies farther than `FAR` times its size from its own origin is moved there (`offset_os`),
    so that float32 on the GPU keeps all that the file had. `keys[i]` names the content; the piece of slot s gets the key `(keys[i], s)`.
    """
    out: dict[int, Prepared] = {}
    ways: dict[float | None, list[int]] = {}
    for i, raw in enumerate(raws):
        own = crease_angle_rad if raw.crease_rad is None else raw.crease_rad
        ways.setdefault(None if _has_normals(raw) else own, []).append(i)
    for crease, chosen in ways.items():
        for chunk in _chunks(chosen, raws):
            joined = _Joined([raws[i] for i in chunk])
            for i, prepared in zip(chunk, joined.prepare([keys[i] for i in chunk], crease or 0.0), strict=True):
                out[i] = prepared
    return [out[i] for i in range(len(raws))]


def _has_normals(raw: RawMesh) -> bool:
    if raw.corner_normals is None:
        return False
    flat = raw.corner_normals.reshape(-1, 3)
    return bool((np.abs(np.einsum("ij,ij->i", flat, flat) - 1.0) < 1e-2).all())


def _chunks(chosen: list[int], raws: Sequence[RawMesh]) -> Iterator[list[int]]:
    """Runs of meshes of about `TRIANGLES_AT_ONCE` triangles; a larger mesh is a run of its own."""
    chunk: list[int] = []
    total = 0
    for i in chosen:
        size = len(raws[i].triangles)
        if chunk and total + size > TRIANGLES_AT_ONCE:
            yield chunk
            chunk, total = [], 0
        chunk.append(i)
        total += size
    if chunk:
        yield chunk


class _Joined:
    """Several meshes in one pair of arrays; `group` (V,) and `owner` (T,) tell whose each vertex and triangle is."""

    def __init__(self, raws: Sequence[RawMesh]) -> None:
        self.raws = raws
        self.vertex_counts = np.array([len(r.positions) for r in raws])
        self.triangle_counts = np.array([len(r.triangles) for r in raws])
        self.firsts = np.cumsum(self.vertex_counts) - self.vertex_counts
        self.group = np.repeat(np.arange(len(raws), dtype=np.int32), self.vertex_counts)
        self.owner = np.repeat(np.arange(len(raws), dtype=np.int32), self.triangle_counts)
        self.positions = np.concatenate([r.positions for r in raws])
        self.triangles = (
            np.concatenate([r.triangles for r in raws]) + np.repeat(self.firsts, self.triangle_counts).astype(np.int32)[:, None]
        )
        self.slots = self._joined_slots()

    def _joined_slots(self) -> np.ndarray | None:
        if all(r.slots is None for r in self.raws):
            return None
        return np.concatenate([np.zeros(len(r.triangles), dtype=np.int32) if r.slots is None else r.slots for r in self.raws])

    def prepare(self, keys: Sequence[Hashable], crease_angle_rad: float) -> list[Prepared]:
        """The pieces of every mesh, in order."""
        keep, total = drawable(self.positions, self.triangles)
        defects = [drawable(r.positions, r.triangles)[1] for r in self.raws] if total else [total] * len(self.raws)
        normals = (
            None
            if self.raws[0].corner_normals is None or not _has_normals(self.raws[0])
            else np.concatenate([r.corner_normals for r in self.raws])
        )
        if total:
            self.positions = np.where(np.isfinite(self.positions), self.positions, np.float32(0.0))
            self.triangles, self.owner = self.triangles[keep], self.owner[keep]
            self.slots = None if self.slots is None else self.slots[keep]
            normals = None if normals is None else normals[keep]
        offsets = self._moved_to_origin()
        empty: list[Prepared] = [Prepared((), (), np.zeros(3), d) for d in defects]
        if not len(self.triangles):
            return empty
        if normals is None:
            shaded = shade_by_crease(self.positions, self.triangles, crease_angle_rad, self.group if len(self.raws) > 1 else None)
        else:
            shaded = shade_by_corners(self.positions, self.triangles, normals)
        return self._gathered(shaded, keys, offsets, defects)

    def _moved_to_origin(self) -> np.ndarray:
        """(meshes, 3) float64 the centres subtracted from the vertices of meshes that lie far from their origin; else 0."""
        used = np.zeros(len(self.positions), dtype=bool)
        used[self.triangles.ravel()] = True
        low = np.minimum.reduceat(np.where(used[:, None], self.positions, np.float32(np.inf)), self.firsts).astype(np.float64)
        high = np.maximum.reduceat(np.where(used[:, None], self.positions, np.float32(-np.inf)), self.firsts).astype(np.float64)
        present = np.isfinite(low).all(axis=1)
        low[~present] = high[~present] = 0.0
        centre, size = (low + high) / 2, (high - low).max(axis=1)
        centre[np.abs(centre).max(axis=1) <= FAR * size] = 0.0
        if centre.any():
            self.positions = (self.positions.astype(np.float64) - centre[self.group]).astype(np.float32)
        return centre

    def _gathered(self, shaded: Shaded, keys: Sequence[Hashable], offsets: np.ndarray, defects: list[Defects]) -> list[Prepared]:
        width = 1 if self.slots is None else int(self.slots.max()) + 1
        piece_of = self.owner.astype(np.int64) * width + (0 if self.slots is None else self.slots)
        meshes: dict[int, list[Mesh]] = {}
        slots: dict[int, list[int]] = {}
        for piece, positions, normals, triangles in pieces(shaded, piece_of):
            owner, slot = divmod(piece, width)
            meshes.setdefault(owner, []).append(Mesh((keys[owner], slot), positions, normals, triangles))
            slots.setdefault(owner, []).append(slot)
        return [Prepared(tuple(meshes.get(i, ())), tuple(slots.get(i, ())), offsets[i], defects[i]) for i in range(len(keys))]


def pieces(shaded: Shaded, piece_of: np.ndarray) -> Iterator[tuple[int, np.ndarray, np.ndarray, np.ndarray]]:
    """For each number in `piece_of` (T,), ascending: the number, and positions, normals, triangles (from vertex 0) of its triangles."""
    order = np.argsort(piece_of, kind="stable")
    numbers, starts = np.unique(piece_of[order], return_index=True)
    if len(numbers) == 1:
        yield int(numbers[0]), shaded.positions, shaded.normals, shaded.triangles
        return
    triangles = shaded.triangles[order]
    index = np.repeat(np.arange(len(numbers)), np.diff(np.append(starts, len(order))))
    pair = (index[:, None] * len(shaded.positions) + triangles).ravel()
    pairs, new_vertex = np.unique(pair, return_inverse=True)
    vertex = pairs % len(shaded.positions)
    positions, normals = shaded.positions[vertex], shaded.normals[vertex]
    first_vertex = np.searchsorted(pairs, np.arange(len(numbers) + 1) * len(shaded.positions))
    local = new_vertex.reshape(-1, 3).astype(np.int32) - first_vertex[index].astype(np.int32)[:, None]
    ends = np.append(starts[1:], len(order))
    for i, (start, end) in enumerate(zip(starts, ends, strict=True)):
        part = slice(first_vertex[i], first_vertex[i + 1])
        yield int(numbers[i]), positions[part], normals[part], local[start:end]
