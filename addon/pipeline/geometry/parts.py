"""Meshes as they lie in the pools, and which of a scene's are baked or instanced. No GL."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...scene.records import Mesh, Scene
from .draw_list import IndexRanges
from .packing import Packed

BAKE_TRIANGLES = 3000
BATCH = 1 << 17  # triangles made ready at once


@dataclass(slots=True)
class PooledMesh:
    """A mesh in the pools: where it lies, and its clusters (bounds in the space it is stored in)."""

    mesh: Mesh
    first_vertex: int
    vertex_count: int
    first_index: int
    index_count: int
    slot: int
    is_closed: bool
    cluster_starts: np.ndarray | None = None
    bounds: np.ndarray | None = None
    longest_edges: np.ndarray | None = None
    transform: np.ndarray | None = None

    def take(self, batch: Packed, k: int, transform: np.ndarray | None) -> None:
        """Note what mesh k of a batch has come to."""
        rows = slice(batch.cluster_ends[k - 1] if k else 0, batch.cluster_ends[k])
        self.cluster_starts, self.bounds, self.longest_edges = batch.starts[rows], batch.bounds[rows], batch.longest_edges[rows]
        self.transform = transform


def is_same_layout(before: Scene, scene: Scene) -> bool:
    """Whether the same meshes are placed as often, in the same order."""
    if not np.array_equal(before.instances.mesh_index, scene.instances.mesh_index) or len(before.meshes) != len(scene.meshes):
        return False
    return all(a is b or a.key == b.key for a, b in zip(before.meshes, scene.meshes, strict=True))


def plan(scene: Scene) -> tuple[dict[Hashable, int], dict[Hashable, np.ndarray]]:
    """Which instance rows are baked ({key: row}) and which meshes drawn instanced ({key: rows}).

    Keys are ('baked', mesh key, occurrence) and ('instanced', mesh key); a mesh without instances is left out.
    """
    mesh_index = scene.instances.mesh_index
    order = np.argsort(mesh_index, kind="stable")
    starts = np.searchsorted(mesh_index[order], np.arange(len(scene.meshes) + 1))
    baked: dict[Hashable, int] = {}
    instanced: dict[Hashable, np.ndarray] = {}
    for i, mesh in enumerate(scene.meshes):
        rows = order[starts[i] : starts[i + 1]]
        if len(rows) == 1 or len(rows) * len(mesh.triangles) <= BAKE_TRIANGLES:
            baked.update((("baked", mesh.key, j), int(row)) for j, row in enumerate(rows))
        elif len(rows):
            instanced[("instanced", mesh.key)] = rows
    return baked, instanced


def batches(meshes: Sequence[Mesh]) -> Iterator[range]:
    """Indices of meshes that follow one another, together at most `BATCH` triangles unless it is one alone."""
    start, size = 0, 0
    for i, mesh in enumerate(meshes):
        if size and size + len(mesh.triangles) > BATCH:
            yield range(start, i)
            start, size = i, 0
        size += len(mesh.triangles)
    if start < len(meshes):
        yield range(start, len(meshes))


def joined(ranges: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    """Ranges (first, count), sorted, those that touch made one."""
    out: list[tuple[int, int]] = []
    for first, count in sorted(ranges):
        if out and sum(out[-1]) == first:
            out[-1] = out[-1][0], out[-1][1] + count
        else:
            out.append((first, count))
    return out


def ranges_of(placed: list[tuple[PooledMesh, int]]) -> IndexRanges:
    """Every cluster of the parts, in index order, with the instance row that each part belongs to."""
    if not placed:
        none = np.empty(0, np.int64)
        return IndexRanges(none, none, none, np.empty((0, 2, 3)), np.empty(0), none, none, np.empty(0, bool), np.empty((0, 2, 3)))
    parts = [part for part, _ in placed]
    clusters = [len(p.cluster_starts) for p in parts]
    firsts, counts = (np.array([getattr(p, name) for p in parts]) for name in ("first_index", "index_count"))
    starts = np.concatenate([p.cluster_starts for p in parts])
    first = np.repeat(firsts, clusters) + 3 * starts
    ends = np.append(first[1:], 0)
    last = np.cumsum(clusters) - 1
    ends[last] = firsts + counts
    bounds = np.concatenate([p.bounds for p in parts])
    wholes = _wholes(bounds, last + 1 - clusters)
    return IndexRanges(
        first,
        ends - first,
        np.repeat([row for _, row in placed], clusters),
        bounds,
        np.concatenate([p.longest_edges for p in parts]),
        np.repeat([p.slot for p in parts], clusters),
        starts,
        np.repeat([p.is_closed for p in parts], clusters),
        np.repeat(wholes, clusters, axis=0),
    )


def moved_ranges(ranges: IndexRanges, placed: list[tuple[PooledMesh, int]], moved: np.ndarray) -> IndexRanges:
    """`ranges_of(placed)` when those at `moved` stand elsewhere than when `ranges` was made."""
    if not len(moved):
        return ranges
    clusters = np.array([len(part.cluster_starts) for part, _ in placed])
    parts, counts = [placed[i][0] for i in moved.tolist()], clusters[moved]
    begins = np.cumsum(counts) - counts
    own = np.repeat((np.cumsum(clusters) - clusters)[moved] - begins, counts) + np.arange(counts.sum())
    bounds, edges, wholes = ranges.bounds_ws.copy(), ranges.longest_edge_m.copy(), ranges.wholes_ws.copy()
    bounds[own], edges[own] = np.concatenate([p.bounds for p in parts]), np.concatenate([p.longest_edges for p in parts])
    wholes[own] = np.repeat(_wholes(bounds[own], begins), counts, axis=0)
    return replace(ranges, bounds_ws=bounds, longest_edge_m=edges, wholes_ws=wholes)


def _wholes(bounds: np.ndarray, begins: np.ndarray) -> np.ndarray:
    """(P, 2, 3) bounds of the parts whose clusters begin at `begins` in `bounds` (C, 2, 3)."""
    return np.stack([np.minimum.reduceat(bounds[:, 0], begins), np.maximum.reduceat(bounds[:, 1], begins)], axis=1)
