"""The scene on the GPU: pooled vertex and index buffers, uploaded once per mesh, drawn in few calls. Worker thread only.

A mesh placed once (or small) is *baked*: its vertices are stored in world space, neighbours lie next to each other, and whole runs of
visible parts are drawn by one call. A mesh placed often is stored once in object space and drawn *instanced*. Large baked meshes are cut
into clusters so that culling works inside them.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator

import moderngl
import numpy as np

from ...errors import GpuError
from ...scene.records import Mesh, Scene
from ..gl.allocation import allocating, buffer_texture_limit
from .closed import centres_os, closed_meshes
from .clusters import morton
from .draw_list import DrawList, IndexRanges, InstancedGroup
from .packing import Packed, cofactors, is_mirrored, packed
from .parts import PooledMesh, batches, is_same_layout, joined, moved_ranges, plan, ranges_of
from .pools import Pools
from .ranges import Ranges
from .surface_links import SurfaceLinks

INITIAL_VERTICES, INITIAL_INDICES = 1 << 16, 3 << 16


class GeometryStore:
    """Uploads what is new, frees what is gone, and gives the `DrawList` of a scene.

    `state` counts changes of what stands where, `colors` those of the instance table alone: equal, nothing changed. `pools` counts how
    often the buffers were made afresh: a driver gives a freed buffer's name to the next one.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._draw_list: DrawList | None = None
        self.uploaded_meshes = 0
        self.state = self.colors = self.pools = 0
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
        self._parts: dict[Hashable, PooledMesh] = {}
        self._closed: dict[Hashable, bool] = {}
        self._scene: Scene | None = None
        self._placed: list[tuple[PooledMesh, int]] = []
        self._instanced: dict[Hashable, np.ndarray] = {}

    def sync(self, scene: Scene) -> DrawList:
        """Bring the GPU to `scene` and return what to draw. The same scene costs nothing; unchanged meshes are not uploaded again.

        Raises `GpuError` when it does not fit; then nothing is kept.
        """
        if scene is self._scene and self._draw_list is not None:
            return self._draw_list
        before, self._scene = self._scene, None
        try:
            with allocating(self._context, "the meshes of this scene", "hide or simplify parts of it"):
                if before is not None and is_same_layout(before, scene):
                    self._update(before, scene)
                else:
                    self._rebuild(scene)
        except GpuError:
            self.release()
            self._begin()
            raise
        self._scene = scene
        return self._draw_list

    def _update(self, before: Scene, scene: Scene) -> None:
        """The same meshes and instances: what moved is placed anew, the rest stays as it is."""
        old, new = before.instances, scene.instances
        moved = np.flatnonzero((old.world_from_object != new.world_from_object).any(axis=(1, 2)))
        if len(moved) or not all(
            np.array_equal(getattr(old, name), getattr(new, name)) for name in ("object_id", "material_slot", "flags")
        ):
            self.state += 1
        self.colors += 1
        ranges, groups = self._draw_list.ranges, self._draw_list.groups
        if len(moved):
            rows = np.fromiter((row for _, row in self._placed), np.int64, len(self._placed))
            chosen = np.flatnonzero(np.isin(rows, moved))
            chosen = chosen[np.argsort([self._placed[i][0].first_vertex for i in chosen], kind="stable")]
            self._place([self._placed[i][0] for i in chosen], new.world_from_object[rows[chosen]])
            ranges = moved_ranges(ranges, self._placed, chosen)
            if len(chosen) < len(moved):
                groups = self._groups(scene)
        self._replace_draw_list(self._listed(scene, ranges, groups))

    def _rebuild(self, scene: Scene) -> None:
        self.state += 1
        baked, instanced = plan(scene)
        self._free_missing({*baked, *instanced})
        self._learn_closed(scene)
        self._upload_baked(scene, {key: row for key, row in baked.items() if key not in self._parts})
        self._move_baked(scene, baked)
        missing = [key for key in instanced if key not in self._parts]
        self._upload(missing, [scene.meshes[int(scene.instances.mesh_index[instanced[key][0]])] for key in missing], None)
        self._placed = sorted(((self._parts[key], row) for key, row in baked.items()), key=lambda item: item[0].first_index)
        self._instanced = instanced
        self._replace_draw_list(self._listed(scene, ranges_of(self._placed), self._groups(scene)))

    def _free_missing(self, wanted: set[Hashable]) -> None:
        gone = [self._parts.pop(key) for key in [key for key in self._parts if key not in wanted]]
        for part in gone:
            self._vertices.free(part.first_vertex, part.vertex_count)
            self._indices.free(part.first_index, part.index_count)
            self._slots.free(part.slot, 1)
        for first, count in joined([(part.first_index, part.index_count) for part in gone]):
            self.indices.write(bytes(4 * count), offset=4 * first)  # no triangles: can be drawn along

    def _learn_closed(self, scene: Scene) -> None:
        """Which meshes of the scene are closed; known ones are not looked at again."""
        new = [mesh for mesh in scene.meshes if mesh.key not in self._closed]
        known = {mesh.key: self._closed[mesh.key] for mesh in scene.meshes if mesh.key in self._closed}
        for some in batches(new):
            known.update(zip((new[i].key for i in some), closed_meshes([new[i] for i in some]).tolist(), strict=True))
        self._closed = known

    def _upload_baked(self, scene: Scene, missing: dict[Hashable, int]) -> None:
        """Upload what is missing, closed meshes first, neighbours next to each other."""
        if not missing:
            return
        keys, rows = list(missing), np.fromiter(missing.values(), dtype=np.int64, count=len(missing))
        matrices = scene.instances.world_from_object[rows]
        meshes = [scene.meshes[i] for i in scene.instances.mesh_index[rows].tolist()]
        centres = centres_os(meshes)
        code = morton(matrices[:, :3, 3] + np.einsum("rab,rb->ra", matrices[:, :3, :3], centres))
        order = np.lexsort([code, [not self._closed[mesh.key] for mesh in meshes]])
        self._upload([keys[i] for i in order], [meshes[i] for i in order], matrices[order])

    def _upload(self, keys: list[Hashable], meshes: list[Mesh], matrices: np.ndarray | None) -> None:
        """Upload meshes as they are placed by `matrices` (M, 4, 4), or in object space, one after the other in the pools."""
        for some in batches(meshes):
            chosen = meshes[some[0] : some[-1] + 1]
            batch = packed(chosen, None if matrices is None else matrices[some[0] : some[-1] + 1])
            first_vertex, first_index = self._reserve_vertices(int(batch.vertex_ends[-1])), self._reserve_indices(int(batch.index_ends[-1]))
            slots = self._reserve_slots(len(chosen))
            self.indices.write(np.add(batch.triangles, first_vertex, dtype=np.uint32, casting="unsafe"), offset=first_index * 4)
            counts = np.diff(batch.vertex_ends, prepend=0)
            self.vertex_slots.write(np.repeat(np.arange(slots, slots + len(chosen), dtype=np.uint32), counts), offset=first_vertex * 4)
            self._write_vertices(batch, slice(None), first_vertex)
            for k, (i, mesh) in enumerate(zip(some, chosen, strict=True)):
                part = PooledMesh(
                    mesh, first_vertex, len(mesh.positions), first_index, mesh.triangles.size, slots + k, self._closed[mesh.key]
                )
                part.take(batch, k, None if matrices is None else matrices[i])
                self._parts[keys[i]] = part
                first_vertex += part.vertex_count
                first_index += part.index_count
            self.uploaded_meshes += len(chosen)

    def _write_vertices(self, batch: Packed, rows: slice, first_vertex: int) -> None:
        self.positions.write(np.ascontiguousarray(batch.positions[rows]), offset=first_vertex * 12)
        self.normals.write(np.ascontiguousarray(batch.normals[rows]), offset=first_vertex * 4)

    def _move_baked(self, scene: Scene, baked: dict[Hashable, int]) -> None:
        """Place anew what stands elsewhere than before."""
        if not baked:
            return
        parts = [self._parts[key] for key in baked]
        matrices = scene.instances.world_from_object[list(baked.values())]
        moved = np.flatnonzero((np.stack([part.transform for part in parts]) != matrices).any(axis=(1, 2)))
        moved = moved[np.argsort([parts[i].first_vertex for i in moved], kind="stable")]
        self._place([parts[i] for i in moved], matrices[moved])

    def _place(self, parts: list[PooledMesh], matrices: np.ndarray) -> None:
        """Write the vertices of parts, in the order of the pool, as placed by `matrices` (P, 4, 4), and note their bounds."""
        for some in batches([part.mesh for part in parts]):
            chosen = parts[some[0] : some[-1] + 1]
            placed = matrices[some[0] : some[-1] + 1]
            batch = packed([part.mesh for part in chosen], placed)
            turns_over = is_mirrored(np.stack([part.transform for part in chosen])) != is_mirrored(placed)
            for k, part in enumerate(chosen):
                if turns_over[k]:
                    rows = slice((batch.index_ends[k] - part.index_count) // 3, batch.index_ends[k] // 3)
                    own = batch.triangles[rows] - (batch.vertex_ends[k] - part.vertex_count) + part.first_vertex
                    self.indices.write(own.astype(np.uint32), offset=part.first_index * 4)
                    self.links.drop(part.first_index)
                part.take(batch, k, placed[k])
            at = 0
            for first, count in joined([(part.first_vertex, part.vertex_count) for part in chosen]):
                self._write_vertices(batch, slice(at, at + count), first)
                at += count

    def _listed(self, scene: Scene, ranges: IndexRanges, groups: list[InstancedGroup]) -> DrawList:
        """The draw list of these, with the table of `scene`."""
        base = self._slots.capacity
        rows_of_slot = np.full(base + sum(len(group.slots) for group in groups), -1, np.int64)
        rows_of_slot[ranges.slots] = ranges.rows
        for group in groups:
            rows_of_slot[group.slots] = group.rows
        pools = Pools(self.positions, self.normals, self.vertex_slots, self.indices)
        return DrawList.build(self._context, pools, scene, ranges, groups, rows_of_slot, base)

    def _groups(self, scene: Scene) -> list[InstancedGroup]:
        """The instanced meshes, their slots behind those of the baked ones."""
        bounds_ws = scene.instance_bounds_ws() if self._instanced else None
        groups, cursor = [], self._slots.capacity
        for part, rows, front in self._group_parts(scene):
            slots = np.arange(cursor, cursor + len(rows), dtype=np.uint32)
            stretch = np.linalg.norm(scene.instances.world_from_object[rows, :3, :3], axis=(1, 2))
            edges = stretch * part.longest_edges.max()
            groups.append(InstancedGroup(part.first_index, part.index_count, slots, rows, bounds_ws[rows], edges, front))
            cursor += len(rows)
        return groups

    def _group_parts(self, scene: Scene) -> Iterator[tuple[PooledMesh, np.ndarray, int]]:
        """The part, rows and `front` of every group: of a closed mesh, mirrored instances are a group of their own."""
        for key, rows in self._instanced.items():
            part = self._parts[key]
            mirrored = is_mirrored(scene.instances.world_from_object[rows]) & part.is_closed
            for front, own in ((part.is_closed * 1, rows[~mirrored]), (-1, rows[mirrored])):
                if len(own):
                    yield part, own, front

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

    def _reserve_slots(self, count: int) -> int:
        start = self._slots.allocate(count)
        if start is None:
            self._slots.grow(count)
            start = self._slots.allocate(count)
        return start

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
        self._placed, self._instanced, self._scene = [], {}, None


def turned(normals: np.ndarray, transform: np.ndarray) -> np.ndarray:
    """Unit normals under an affine map, right for mirrored and unevenly scaled objects."""
    out = normals.astype(np.float64) @ cofactors(transform[None])[0].T
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return (out / np.where(length > 0.0, length, 1.0)).astype(np.float32)
