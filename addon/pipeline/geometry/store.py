"""The scene on the GPU: pooled vertex and index buffers, uploaded once per mesh, drawn in few calls. Worker thread only.

A mesh placed once (or small) is *baked*: its vertices are stored in world space, neighbours lie next to each other, and whole runs of
visible parts are drawn by one call. A mesh placed often is stored once in object space and drawn *instanced*. Large baked meshes are cut
into clusters so that culling works inside them.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import moderngl
import numpy as np

from ...errors import GpuError
from ...scene.records import Mesh, Scene
from ..gl.allocation import allocating, buffer_texture_limit
from .clusters import cluster_bounds, clustered, longest_edges, morton
from .draw_list import DrawList, IndexRanges, InstancedGroup
from .octahedral import packed_octahedral
from .pools import Pools
from .ranges import Ranges
from .surface_links import SurfaceLinks

BAKE_TRIANGLES = 3000
INITIAL_VERTICES, INITIAL_INDICES = 1 << 16, 3 << 16


@dataclass(slots=True)
class _Part:
    """A mesh in the pools: where it lies, and its clusters (bounds in the space it is stored in)."""

    mesh: Mesh
    first_vertex: int
    vertex_count: int
    first_index: int
    index_count: int
    cluster_starts: np.ndarray
    bounds: np.ndarray
    longest_edges: np.ndarray
    slot: int
    transform: np.ndarray | None


class GeometryStore:
    """Uploads what is new, frees what is gone, and gives the `DrawList` of a scene. `state` counts the scenes: equal, nothing changed.

    `pools` counts how often the buffers were made afresh: a driver gives a freed buffer's name to the next one.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._draw_list: DrawList | None = None
        self.uploaded_meshes = 0
        self.state = self.pools = 0
        self._begin()

    def _begin(self) -> None:
        """Empty pools, as long as shaders can read them."""
        self.pools += 1
        texels = buffer_texture_limit(self._context)
        self._vertices, self._indices = Ranges(INITIAL_VERTICES, texels // 3), Ranges(INITIAL_INDICES, texels)
        self._slots = Ranges(1024)
        vertices = self._vertices.capacity
        self.positions, self.normals, self.vertex_slots = (self._context.buffer(reserve=vertices * size) for size in (12, 4, 4))
        self.indices = self._context.buffer(reserve=self._indices.capacity * 4)
        self.links = SurfaceLinks(self._context)
        self._parts: dict[Hashable, _Part] = {}
        self._scene: Scene | None = None

    def sync(self, scene: Scene) -> DrawList:
        """Bring the GPU to `scene` and return what to draw. The same scene costs nothing; unchanged meshes are not uploaded again.

        Raises `GpuError` when it does not fit; then nothing is kept.
        """
        if scene is self._scene and self._draw_list is not None:
            return self._draw_list
        self._scene, self.state = None, self.state + 1
        try:
            with allocating(self._context, "the meshes of this scene", "hide or simplify parts of it"):
                return self._synced(scene)
        except GpuError:
            self.release()
            self._begin()
            raise

    def _synced(self, scene: Scene) -> DrawList:
        baked, instanced = _plan(scene)
        self._free_missing(set(baked) | set(instanced))
        self._upload_baked(scene, {k: r for k, r in baked.items() if k not in self._parts})
        self._move_baked(scene, baked)
        for key in instanced:
            if key not in self._parts:
                self._parts[key] = self._upload(scene.meshes[int(scene.instances.mesh_index[instanced[key][0]])], None)
        self._replace_draw_list(self._make_draw_list(scene, baked, instanced))
        self._scene = scene
        return self._draw_list

    def _free_missing(self, wanted: set[Hashable]) -> None:
        for key in [k for k in self._parts if k not in wanted]:
            part = self._parts.pop(key)
            self._vertices.free(part.first_vertex, part.vertex_count)
            self._indices.free(part.first_index, part.index_count)
            self._slots.free(part.slot, 1)

    def _upload_baked(self, scene: Scene, missing: dict[Hashable, int]) -> None:
        if not missing:
            return
        keys = list(missing)
        rows = np.fromiter(missing.values(), dtype=np.int64, count=len(missing))
        order = np.argsort(morton(scene.instances.world_from_object[rows, :3, 3] + _local_centres(scene, rows)), kind="stable")
        for i in order:
            row = int(rows[i])
            mesh = scene.meshes[int(scene.instances.mesh_index[row])]
            self._parts[keys[i]] = self._upload(mesh, scene.instances.world_from_object[row])

    def _upload(self, mesh: Mesh, transform: np.ndarray | None) -> _Part:
        triangles, starts = clustered(mesh.positions, mesh.triangles)
        vertex_count, index_count = len(mesh.positions), triangles.size
        first_vertex, first_index = self._reserve_vertices(vertex_count), self._reserve_indices(index_count)
        slot = self._reserve_slot()
        part = _Part(mesh, first_vertex, vertex_count, first_index, index_count, starts, np.empty(0), np.empty(0), slot, None)
        self.indices.write((triangles.astype(np.uint32) + np.uint32(first_vertex)).tobytes(), offset=first_index * 4)
        self.vertex_slots.write(np.full(vertex_count, slot, np.uint32).tobytes(), offset=first_vertex * 4)
        self._place(part, transform, triangles)
        self.uploaded_meshes += 1
        return part

    def _place(self, part: _Part, transform: np.ndarray | None, triangles: np.ndarray | None = None) -> None:
        """Write the vertices of a part as placed by `transform` (None: in object space) and its cluster bounds."""
        positions, normals = part.mesh.positions, part.mesh.normals
        if transform is not None:
            positions = (positions.astype(np.float64) @ transform[:3, :3].T + transform[:3, 3]).astype(np.float32)
            normals = turned(normals, transform)
        if triangles is None:
            triangles, _ = clustered(part.mesh.positions, part.mesh.triangles)
        part.transform = None if transform is None else transform.copy()
        part.bounds = cluster_bounds(positions, triangles, part.cluster_starts).astype(np.float64)
        part.longest_edges = longest_edges(positions, triangles, part.cluster_starts).astype(np.float64)
        self.positions.write(positions.tobytes(), offset=part.first_vertex * 12)
        self.normals.write(packed_octahedral(normals).tobytes(), offset=part.first_vertex * 4)

    def _move_baked(self, scene: Scene, baked: dict[Hashable, int]) -> None:
        for key, row in baked.items():
            part, transform = self._parts[key], scene.instances.world_from_object[row]
            if not np.array_equal(part.transform, transform):
                self._place(part, transform)

    def _make_draw_list(self, scene: Scene, baked: dict[Hashable, int], instanced: dict[Hashable, np.ndarray]) -> DrawList:
        parts = sorted(((self._parts[k], row) for k, row in baked.items()), key=lambda item: item[0].first_index)
        base = self._slots.capacity
        total = sum(len(rows) for rows in instanced.values())
        rows_of_slot = np.full(base + total, -1, np.int64)
        if parts:
            slots_used = [p.slot for p, _ in parts]
            rows_of_slot[slots_used] = [row for _, row in parts]
        bounds_ws = scene.instance_bounds_ws() if instanced else None
        groups, cursor = [], base
        for key, rows in instanced.items():
            part = self._parts[key]
            rows_of_slot[cursor : cursor + len(rows)] = rows
            slots = np.arange(cursor, cursor + len(rows), dtype=np.uint32)
            stretch = np.linalg.norm(scene.instances.world_from_object[rows, :3, :3], axis=(1, 2))
            groups.append(
                InstancedGroup(part.first_index, part.index_count, slots, rows, bounds_ws[rows], stretch * part.longest_edges.max())
            )
            cursor += len(rows)
        pools = Pools(self.positions, self.normals, self.vertex_slots, self.indices)
        return DrawList.build(self._context, pools, scene, _ranges_of(parts), groups, rows_of_slot, base)

    def _replace_draw_list(self, draw_list: DrawList) -> None:
        if self._draw_list is not None:
            self._draw_list.release()
        self._draw_list = draw_list

    def _reserve_vertices(self, count: int) -> int:
        start = self._vertices.allocate(count)
        if start is None:
            self._vertices.grow(count)
            self.positions = self._grown(self.positions, self._vertices.capacity * 12)
            self.normals = self._grown(self.normals, self._vertices.capacity * 4)
            self.vertex_slots = self._grown(self.vertex_slots, self._vertices.capacity * 4)
            start = self._vertices.allocate(count)
        return start

    def _reserve_indices(self, count: int) -> int:
        start = self._indices.allocate(count)
        if start is None:
            self._indices.grow(count)
            self.indices = self._grown(self.indices, self._indices.capacity * 4)
            start = self._indices.allocate(count)
        return start

    def _reserve_slot(self) -> int:
        slot = self._slots.allocate(1)
        if slot is None:
            self._slots.grow(1)
            slot = self._slots.allocate(1)
        return slot

    def _grown(self, old: moderngl.Buffer, size: int) -> moderngl.Buffer:
        new = self._context.buffer(reserve=size)
        self._context.copy_buffer(new, old, old.size)
        old.release()
        return new

    def linked(self) -> moderngl.Buffer:
        """The pool of links across edges, brought up to the scene of the last `sync`."""
        parts = ((p.mesh, p.mesh.positions, p.first_vertex, p.first_index, p.index_count) for p in self._parts.values())
        self.links.update(self.indices, parts)
        return self.links.buffer

    def release(self) -> None:
        """Free every buffer."""
        self.links.release()
        if self._draw_list is not None:
            self._draw_list.release()
            self._draw_list = None
        for buffer in (self.positions, self.normals, self.vertex_slots, self.indices):
            buffer.release()
        self._parts.clear()
        self._scene = None


def _plan(scene: Scene) -> tuple[dict[Hashable, int], dict[Hashable, np.ndarray]]:
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


def _local_centres(scene: Scene, rows: np.ndarray) -> np.ndarray:
    """(R, 3) offset, in world axes, from each instance's origin to the centre of its mesh."""
    index = scene.instances.mesh_index[rows]
    centres = np.zeros((len(scene.meshes), 3))
    for i in np.unique(index):
        centres[i] = scene.meshes[i].bounds_os.mean(axis=0)
    return np.einsum("rab,rb->ra", scene.instances.world_from_object[rows, :3, :3], centres[index])


def turned(normals: np.ndarray, transform: np.ndarray) -> np.ndarray:
    """Unit normals under an affine map: the cofactor matrix, right for mirrored and unevenly scaled objects."""
    a = transform[:3, :3]
    cofactor = np.stack([np.cross(a[1], a[2]), np.cross(a[2], a[0]), np.cross(a[0], a[1])])
    out = normals.astype(np.float64) @ (cofactor * np.sign(np.linalg.det(a))).T
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return (out / np.where(length > 0.0, length, 1.0)).astype(np.float32)


def _ranges_of(placed: list[tuple[_Part, int]]) -> IndexRanges:
    """Every cluster of the parts, in index order, with the instance row that each part belongs to."""
    if not placed:
        none = np.empty(0, np.int64)
        return IndexRanges(none, none, none, np.empty((0, 2, 3)), np.empty(0), none, none)
    parts = [part for part, _ in placed]
    rows = np.repeat([row for _, row in placed], [len(p.cluster_starts) for p in parts])
    first = np.concatenate([p.first_index + 3 * p.cluster_starts for p in parts])
    ends = np.concatenate([np.append(p.first_index + 3 * p.cluster_starts[1:], p.first_index + p.index_count) for p in parts])
    return IndexRanges(
        first,
        ends - first,
        rows,
        np.concatenate([p.bounds for p in parts]),
        np.concatenate([p.longest_edges for p in parts]),
        np.repeat([p.slot for p in parts], [len(p.cluster_starts) for p in parts]),
        np.concatenate([p.cluster_starts for p in parts]),
    )
