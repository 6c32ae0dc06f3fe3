"""Meshes made ready for the pools, many at once: placed, packed, bounded. Numpy only.

A call per mesh costs more than the numbers of a small one; here numpy is called once for all of a batch. Vertices are worked on as columns
and in blocks, so that a mesh of millions takes little more memory than its result.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...scene.records import Mesh
from .clusters import clustered
from .octahedral import packed_octahedral

AT_ONCE = 1 << 13  # rows whose columns stay in the processor's cache
CLUSTERS_AT_ONCE = 1 << 16  # triangles of clusters looked at together


@dataclass(frozen=True, eq=False)
class Packed:
    """A batch of meshes one after the other. `positions` (V, 3) float32 and `normals` (V,) uint32 as placed; `triangles` (T, 3) int32 of
    the batch's vertices, in drawing order, wound as the mesh is also where it is placed mirrored.

    `vertex_ends`, `index_ends` (M,); clusters: `cluster_ends` (M,), and of each `starts` (C,) its first triangle within its mesh, `bounds`
    (C, 2, 3) and `longest_edges` (C,).
    """

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    vertex_ends: np.ndarray
    index_ends: np.ndarray
    cluster_ends: np.ndarray
    starts: np.ndarray
    bounds: np.ndarray
    longest_edges: np.ndarray


def packed(meshes: Sequence[Mesh], world_from_object: np.ndarray | None) -> Packed:
    """The meshes placed by `world_from_object` (M, 4, 4), or as they are."""
    drawn = [clustered(mesh.positions, mesh.triangles) for mesh in meshes]
    vertices, counts = (np.array([len(a) for a in arrays]) for arrays in ([m.positions for m in meshes], [t for t, _ in drawn]))
    firsts, begins = np.cumsum(vertices) - vertices, np.cumsum(counts) - counts
    triangles = np.concatenate([t + first for (t, _), first in zip(drawn, firsts.tolist(), strict=True)])
    clusters = np.array([len(starts) for _, starts in drawn])
    starts = np.concatenate([starts for _, starts in drawn])
    positions, normals = np.concatenate([m.positions for m in meshes]), np.concatenate([m.normals for m in meshes])
    if world_from_object is None:
        codes = np.concatenate([packed_octahedral(normals[rows]) for rows in _blocks(len(normals))])
    else:
        positions, codes = _placed(positions, normals, world_from_object, vertices)
        mirrored = np.repeat(is_mirrored(world_from_object), counts)
        triangles[mirrored] = triangles[mirrored][:, [0, 2, 1]]
    bounds, edges = bounds_and_edges(positions, triangles, starts + np.repeat(begins, clusters))
    return Packed(positions, codes, triangles, np.cumsum(vertices), 3 * np.cumsum(counts), np.cumsum(clusters), starts, bounds, edges)


def is_mirrored(world_from_object: np.ndarray) -> np.ndarray:
    """(M,) bool: the winding of triangles turns over."""
    return np.linalg.det(world_from_object[:, :3, :3]) < 0.0


def _blocks(count: int) -> Iterator[slice]:
    return (slice(at, at + AT_ONCE) for at in range(0, count, AT_ONCE))


def _placed(positions: np.ndarray, normals: np.ndarray, matrices: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World positions (V, 3) float32 and packed normals (V,) of meshes of `counts` vertices, each with its matrix; in float64 between."""
    placed, codes = np.empty_like(positions), np.empty(len(normals), np.uint32)
    turning, mesh_of = cofactors(matrices), np.repeat(np.arange(len(counts)), counts)
    for rows in _blocks(len(positions)):
        own = mesh_of[rows]
        own = own[:1] if own[0] == own[-1] else own
        x, y, z = (positions[rows, k].astype(np.float64) for k in range(3))
        u, v, w = (normals[rows, k].astype(np.float64) for k in range(3))
        turned = np.empty((len(x), 3))
        for k in range(3):
            m, n = matrices[:, k], turning[:, k]
            placed[rows, k] = x * m[own, 0] + y * m[own, 1] + z * m[own, 2] + m[own, 3]
            turned[:, k] = u * n[own, 0] + v * n[own, 1] + w * n[own, 2]
        length = np.sqrt(turned[:, 0] ** 2 + turned[:, 1] ** 2 + turned[:, 2] ** 2)
        codes[rows] = packed_octahedral(turned / np.where(length > 0.0, length, 1.0)[:, None])
    return placed, codes


def cofactors(matrices: np.ndarray) -> np.ndarray:
    """(M, 3, 3) what turns normals under affine maps (M, 4, 4): the cofactor matrices, right for mirrored and unevenly scaled objects."""
    a, b, c = (matrices[:, k, :3] for k in range(3))
    turning = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    return turning * np.sign(np.linalg.det(matrices[:, :3, :3]))[:, None, None]


def bounds_and_edges(positions: np.ndarray, triangles: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(C, 2, 3) bounds and (C,) length of the longest edge, float64, of the clusters of triangles that begin at `starts` (C,)."""
    bounds, longest = np.empty((len(starts), 2, 3)), np.empty(len(starts))
    columns = [np.ascontiguousarray(positions[:, axis]) for axis in range(3)]
    ends = np.append(starts[1:], len(triangles))
    first = 0
    while first < len(starts):
        last = max(first + 1, int(np.searchsorted(ends, starts[first] + CLUSTERS_AT_ONCE, side="right")))
        own = triangles[starts[first] : ends[last - 1]]
        begins, squares = starts[first:last] - starts[first], [np.zeros(len(own), np.float32) for _ in range(3)]
        for axis, column in enumerate(columns):
            a, b, c = (column[own[:, k]] for k in range(3))
            bounds[first:last, 0, axis] = np.minimum.reduceat(np.minimum(np.minimum(a, b), c), begins)
            bounds[first:last, 1, axis] = np.maximum.reduceat(np.maximum(np.maximum(a, b), c), begins)
            for square, edge in zip(squares, (a - b, b - c, c - a), strict=True):
                square += edge * edge
        longest[first:last] = np.sqrt(np.maximum.reduceat(np.maximum.reduce(squares), begins))
        first = last
    return bounds, longest
