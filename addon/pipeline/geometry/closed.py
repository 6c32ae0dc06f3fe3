"""Which meshes are closed solids, so that a ray from outside never meets a back face first. Numpy only.

A mesh is closed and evenly wound exactly when every edge is run through as often one way as the other: its boundary is zero. Corners are
points: where positions are equal, vertices are the same. The boundary is summed as a random number per directed edge, opposite ways
cancelling (64 bits: a mistake has a chance of 2⁻⁶⁴), and is zero in between wherever a shell ends, as shells are stored one by one.
Every shell must be wound outwards, so that it encloses a positive volume, or be a sheet with two sides as CAD writes them: flat, or with
every triangle there a second time wound the other way. A mesh with a cavity, whose shell is wound inwards, counts as open.
"""

from __future__ import annotations

from collections.abc import Sequence

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
    firsts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])[:-1]
    ends = np.cumsum([len(mesh.triangles) for mesh in meshes])
    positions = np.concatenate([mesh.positions for mesh in meshes])
    triangles = np.concatenate([mesh.triangles + first for mesh, first in zip(meshes, firsts, strict=True)])
    numbers = _numbers(positions)
    boundary = np.concatenate([[np.uint64(0)], np.cumsum(_boundaries(numbers, triangles))])
    begins = np.concatenate([[0], ends[:-1]])
    closed = (ends > begins) & (boundary[ends] == boundary[begins])
    if closed.any():
        mesh_of = np.repeat(np.arange(len(meshes)), ends - begins)
        kept = np.flatnonzero(closed[mesh_of])
        mesh_of = mesh_of[kept]
        last = np.flatnonzero(boundary[kept + 1] == boundary[begins[mesh_of]])  # triangle of each shell
        centred = positions - np.repeat(centres_os(meshes), [len(mesh.positions) for mesh in meshes], axis=0)
        volume, total = _volumes(centred, triangles[kept], last + 1)
        outwards = volume > LEAST_SHARE * total
        if not outwards.all():
            sides = np.cumsum(_sides(numbers, triangles[kept]))[last]
            outwards |= np.diff(sides, prepend=np.uint64(0)) == 0
        if not outwards.all():
            outwards |= (np.abs(volume) <= LEAST_SHARE * total) & _are_flat(centred, triangles[kept], last + 1)
        closed[mesh_of[last[~outwards]]] = False
    return closed


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
    bits = np.ascontiguousarray(positions + np.float32(0.0), np.float32).view(np.uint32).astype(np.uint64)
    return _mixed(bits[:, 0] * _ODD[0] + bits[:, 1] * _ODD[1] + bits[:, 2] * _ODD[2])


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


def _sides(numbers: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(T,) uint64 a random number for the three corners of a triangle, negative where they are wound the other way round; wraps round."""
    a, b, c = (numbers[triangles[:, k]] for k in range(3))
    backwards = np.negative(((a < b).view(np.uint8) + (b < c) + (c < a) == 1).astype(np.uint64))
    return (_mixed(a + b + c) ^ backwards) - backwards


@np.errstate(under="ignore")
def _volumes(positions: np.ndarray, triangles: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(S,) six times what each shell encloses, and the sum of what its triangles add or take; shells end before triangles `ends`."""
    volume, columns = np.empty(len(triangles)), [positions[:, i].astype(np.float64) for i in range(3)]
    for at in range(0, len(triangles), AT_ONCE):
        corners = [np.ascontiguousarray(triangles[at : at + AT_ONCE, k]) for k in range(3)]
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = ([column[corner] for column in columns] for corner in corners)
        volume[at : at + AT_ONCE] = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    begins = np.concatenate([[0], ends[:-1]])
    return np.add.reduceat(volume, begins), np.add.reduceat(np.abs(volume), begins)


@np.errstate(under="ignore")
def _are_flat(positions: np.ndarray, triangles: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(S,) bool: all triangles of a shell lie in the plane of its first, within `LEAST_SHARE` of their areas."""
    begins = np.concatenate([[0], ends[:-1]])
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    first = np.repeat(normals[begins] / np.maximum(areas[begins], 1e-300)[:, None], ends - begins, axis=0)
    out_of_plane = areas - np.abs(np.einsum("tc,tc->t", normals, first))
    return np.add.reduceat(out_of_plane, begins) <= LEAST_SHARE * np.add.reduceat(areas, begins)
