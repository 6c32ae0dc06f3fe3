"""Which meshes are closed solids, so that a ray from outside never meets a back face first. Numpy only.

A mesh is closed and evenly wound exactly when every edge is run through as often one way as the other: its boundary is zero. Corners are
points: where positions are equal, vertices are the same. The boundary is summed as a random number per directed edge, opposite ways
cancelling (64 bits: a mistake has a chance of 2⁻⁶⁴), and is zero in between wherever a shell ends, as shells are stored one by one.
Every shell must be wound outwards, so that it encloses a positive volume, or be a sheet with two sides as CAD writes them: flat, or with
every triangle there a second time wound the other way. A mesh with a cavity, whose shell is wound inwards, counts as open.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...scene.records import Mesh

AT_ONCE = 1 << 13  # triangles whose columns stay in the processor's cache
LEAST_SHARE = 1e-6  # of the volumes summed without their signs: below, a shell is as good as flat
_ODD = tuple(np.uint64(k) for k in (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x27D4EB2F165667C5))
_MIX = ((np.uint64(30), np.uint64(0xBF58476D1CE4E5B9)), (np.uint64(27), np.uint64(0x94D049BB133111EB)))


def closed_meshes(meshes: Sequence[Mesh]) -> np.ndarray:
    """(M,) bool: closed, evenly wound, and every shell outwards or a sheet with two sides."""
    if not meshes:
        return np.zeros(0, bool)
    counts = np.array([len(mesh.triangles) for mesh in meshes])
    positions, triangles = joined(meshes)
    numbers = _numbers(positions)
    boundary = _boundaries(numbers, triangles)
    np.cumsum(boundary, out=boundary)
    ends = np.cumsum(counts)
    whole = np.concatenate([[np.uint64(0)], boundary[np.maximum(ends - 1, 0)]])
    closed = (counts > 0) & (whole[1:] == whole[:-1])
    if closed.any():
        mesh_of = np.repeat(np.arange(len(meshes), dtype=np.int32), counts)
        last = np.flatnonzero((boundary == whole[:-1].take(mesh_of)) & closed.take(mesh_of))  # triangle of each shell
        del boundary
        begins = np.maximum(np.concatenate([[0], last[:-1] + 1]), (ends - counts)[mesh_of[last]])
        shells = _Shells(positions, triangles, begins, last + 1, centres_os(meshes)[mesh_of[last]])
        closed[mesh_of[last[~_outwards(shells, numbers)]]] = False
    return closed


def joined(meshes: Sequence[Mesh]) -> tuple[np.ndarray, np.ndarray]:
    """Positions (V, 3) float32 and triangles (T, 3) int32 of all, one after the other; of one mesh, its own."""
    if len(meshes) == 1:
        return meshes[0].positions, meshes[0].triangles
    counts = np.array([len(mesh.positions) for mesh in meshes])
    firsts = (np.cumsum(counts) - counts).tolist()
    triangles = np.concatenate([mesh.triangles + first for mesh, first in zip(meshes, firsts, strict=True)])
    return np.concatenate([mesh.positions for mesh in meshes]), triangles


def centres_os(meshes: Sequence[Mesh]) -> np.ndarray:
    """(M, 3) the middles of the meshes' boxes."""
    return np.concatenate([mesh.bounds_os for mesh in meshes]).reshape(-1, 2, 3).mean(axis=1)


def _mixed(x: np.ndarray) -> np.ndarray:
    """Steele and others' SplitMix64: as good as a random number for each."""
    for shift, odd in _MIX:
        x = (x ^ (x >> shift)) * odd
    return x ^ (x >> np.uint64(31))


def _numbers(positions: np.ndarray) -> np.ndarray:
    """(V,) uint64 the same random number for equal points (−0.0 = 0.0)."""
    key = np.zeros(len(positions), np.uint64)
    for axis in range(3):
        key += (positions[:, axis] + np.float32(0.0)).view(np.uint32).astype(np.uint64) * _ODD[axis]
    return _mixed(key)


def _boundaries(numbers: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(T,) uint64 the sum over a triangle's edges of a random number, negative for the other way; wraps round."""
    out = np.empty(len(triangles), np.uint64)
    for at in range(0, len(triangles), AT_ONCE):
        corners = [numbers[np.ascontiguousarray(triangles[at : at + AT_ONCE, k])] for k in range(3)]
        total = np.zeros(len(corners[0]), np.uint64)
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            edge = _mixed(np.minimum(a, b) + np.maximum(a, b) * _ODD[3])
            edge *= a != b
            backwards = np.negative((a > b).astype(np.uint64))  # all bits or none: x ^ all - all = −x
            total += (edge ^ backwards) - backwards
        out[at : at + AT_ONCE] = total
    return out


@dataclass(frozen=True, slots=True)
class _Shells:
    """Triangles `begins` … `ends` (S,) of some meshes, and a place near each shell (S, 3) to count from."""

    positions: np.ndarray
    triangles: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    centres: np.ndarray

    def blocks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Triangles (T, 3) of the shells, some at once, and the shell (T,) of each."""
        counts = self.ends - self.begins
        bounds = np.concatenate([[0], np.cumsum(counts)])
        for at in range(0, int(bounds[-1]), AT_ONCE):
            place = np.arange(at, min(at + AT_ONCE, int(bounds[-1])))
            shell = np.searchsorted(bounds, place, side="right") - 1
            yield self.triangles[self.begins[shell] + place - bounds[shell]], shell

    def corners(self, own: np.ndarray, shell: np.ndarray) -> list[list[np.ndarray]]:
        """Float64 columns x, y, z of the three corners of triangles, counted from their shells' places."""
        return [list((self.positions[own[:, k]].astype(np.float64) - self.centres[shell]).T) for k in range(3)]


def _outwards(shells: _Shells, numbers: np.ndarray) -> np.ndarray:
    """(S,) bool: the shell encloses a positive volume, or is a sheet with two sides."""
    volume, total = _volumes(shells)
    out = volume > LEAST_SHARE * total
    if not out.all():
        out |= _sides(shells, numbers) == 0
    if not out.all():
        out |= (np.abs(volume) <= LEAST_SHARE * total) & _are_flat(shells)
    return out


@np.errstate(under="ignore")
def _volumes(shells: _Shells) -> tuple[np.ndarray, np.ndarray]:
    """(S,) six times what each shell encloses, and the sum of what its triangles add or take."""
    sums = np.zeros((2, len(shells.begins)))
    for own, shell in shells.blocks():
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = shells.corners(own, shell)
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        _add(sums, shell, volume, np.abs(volume))
    return sums[0], sums[1]


def _add(sums: np.ndarray, shell: np.ndarray, *values: np.ndarray) -> None:
    """Add values (T,) to the sums (K, S) of their shells, which follow one another."""
    first, count = int(shell[0]), int(shell[-1] - shell[0]) + 1
    for row, own in zip(sums, values, strict=True):
        row[first : first + count] += np.bincount(shell - first, own, count)


def _sides(shells: _Shells, numbers: np.ndarray) -> np.ndarray:
    """(S,) uint64 the sum of a random number for the three corners of each triangle, negative where they are wound the other way; it wraps
    round, and is zero where every triangle is there a second time the other way."""
    out = np.zeros(len(shells.begins), np.uint64)
    for own, shell in shells.blocks():
        a, b, c = (numbers[own[:, k]] for k in range(3))
        backwards = np.negative(((a < b).view(np.uint8) + (b < c) + (c < a) == 1).astype(np.uint64))
        sides = (_mixed(a + b + c) ^ backwards) - backwards
        begins = np.flatnonzero(np.diff(shell, prepend=-1))
        out[shell[begins]] += np.add.reduceat(sides, begins)
    return out


@np.errstate(under="ignore")
def _are_flat(shells: _Shells) -> np.ndarray:
    """(S,) bool: all triangles of a shell lie in the plane of its first, within `LEAST_SHARE` of their areas."""
    sums, first = np.zeros((2, len(shells.begins))), _normals(shells, shells.triangles[shells.begins], np.arange(len(shells.begins)))
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    for own, shell in shells.blocks():
        normals = _normals(shells, own, shell)
        areas = np.linalg.norm(normals, axis=1)
        _add(sums, shell, areas - np.abs(np.einsum("tc,tc->t", normals, first[shell])), areas)
    return sums[0] <= LEAST_SHARE * sums[1]


def _normals(shells: _Shells, own: np.ndarray, shell: np.ndarray) -> np.ndarray:
    a, b, c = (np.stack(corner, axis=1) for corner in shells.corners(own, shell))
    return np.cross(b - a, c - a)
