"""Coarser casters on the GPU: their own pools and draw list, and which of them a map is drawn with. Worker thread only.

A coarse triangle stands for a triangle of the original mesh that lies at it, and the map stores that one's number: the exact test follows
the original surface from there and meets the original triangle. The map only has to name something near the ray.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from ...maths.shadow.projection import ShadowProjection
from ...scene.records import Mesh, Scene
from ..geometry.draw_list import DrawList
from ..geometry.store import GeometryStore
from ..gl.gl_raw import BufferTexture
from ..gl.programs import SAMPLER_UNITS
from .choice import coarsest, texels_per_metre
from .collapse import Coarse
from .making import Levels


@dataclass(frozen=True, eq=False)
class ChosenLevels:
    """For one map: the coarse rows drawn (L,) bool, the instance rows of the scene that they stand for (I,) bool, and the largest of their
    errors, texels."""

    coarse: np.ndarray
    replaced: np.ndarray
    error_texels: float


class CoarseCasters:
    """The coarser meshes of one scene, an instance row for every level of every instance that has any, finest first."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context, self._store = context, GeometryStore(context)
        self.holds: Hashable = None
        self._meshes: dict[Hashable, tuple[Mesh, ...]] = {}
        self._tables: list[tuple[BufferTexture, moderngl.Buffer]] = []
        self.draw_list: DrawList | None = None

    def update(self, scene: Scene, draw_list: DrawList, levels: Levels, wanted: Hashable) -> bool:
        """Bring the GPU to the levels of the scene; `wanted` names both. False where there are none."""
        if wanted != self.holds:
            self.holds = None
            self._forget()
            counts = np.array([len(levels.get(mesh.key, ())) for mesh in scene.meshes], np.int64)
            if counts.any():
                self._build(scene, draw_list, levels, counts)
            self.holds = wanted
        return self.draw_list is not None

    def _build(self, scene: Scene, draw_list: DrawList, levels: Levels, counts: np.ndarray) -> None:
        own = [levels.get(mesh.key, ()) for mesh in scene.meshes]
        self._meshes = {
            mesh.key: self._meshes.get(mesh.key) or _meshes(mesh, coarse) for mesh, coarse in zip(scene.meshes, own, strict=True)
        }
        inst = scene.instances
        self._counts = counts[inst.mesh_index]
        self._begins = np.cumsum(self._counts) - self._counts
        rows = np.repeat(np.arange(len(inst)), self._counts)
        mesh_index = (np.cumsum(counts) - counts)[inst.mesh_index][rows] + np.arange(len(rows)) - self._begins[rows]
        columns = {name: getattr(inst, name)[rows] for name in inst.__dataclass_fields__ if name != "mesh_index"}
        coarse = [one for some in own for one in some]
        stretch = np.linalg.norm(inst.world_from_object[:, :3, :3], ord=2, axis=(1, 2))
        self._errors_m = np.array([level.error for level in coarse])[mesh_index] * stretch[rows]
        self._rows, self._bounds_ws = rows, scene.instance_bounds_ws()
        made = replace(
            scene,
            meshes=tuple(mesh for one in scene.meshes for mesh in self._meshes[one.key]),
            instances=replace(inst, mesh_index=mesh_index, **columns),
            links={},
            ground=None,
        )
        self.draw_list = self._store.sync(made)
        self._tables = [
            _table(self._context, _places(draw_list, len(inst), self.draw_list, rows), "rg32ui"),
            _table(self._context, _sources(self.draw_list, coarse, mesh_index), "r32ui"),
        ]

    def choose(self, projection: ShadowProjection, size: int, is_sun: bool, most_texels: float) -> ChosenLevels | None:
        """What a map of `size` texels may be drawn with, so that no error is larger than `most_texels`; None where nothing may."""
        density = texels_per_metre(projection, size, self._bounds_ws, is_sun)
        level = coarsest(self._errors_m, self._begins, self._counts, most_texels / density)
        replaced = level >= 0
        if not replaced.any():
            return None
        coarse = np.zeros(len(self._rows), bool)
        coarse[level[replaced]] = True
        return ChosenLevels(coarse, replaced, float((self._errors_m[coarse] * density[replaced]).max()))

    def casting(self, chosen: ChosenLevels, rows: np.ndarray | None) -> np.ndarray:
        """(L,) bool: the coarse rows drawn when only the instance rows `rows` (I,) bool cast shadows."""
        return chosen.coarse if rows is None else chosen.coarse & rows[self._rows]

    def bind(self) -> None:
        """Bind what `common_shadow_ids.glsl` reads of coarse triangles."""
        for name, (texture, _) in zip(("u_coarse_places", "u_coarse_sources"), self._tables, strict=True):
            texture.use(SAMPLER_UNITS[name])

    def _forget(self) -> None:
        for table in self._tables:
            for thing in table:
                thing.release()
        self._tables, self.draw_list = [], None

    def release(self) -> None:
        """Free everything."""
        self._forget()
        self._store.release()


def _meshes(mesh: Mesh, levels: tuple[Coarse, ...]) -> tuple[Mesh, ...]:
    return tuple(
        Mesh(("coarse", mesh.key, k), level.positions, np.broadcast_to(np.float32([0, 0, 1]), level.positions.shape), level.triangles)
        for k, level in enumerate(levels)
    )


def _table(context: moderngl.Context, content: np.ndarray, kind: str) -> tuple[BufferTexture, moderngl.Buffer]:
    buffer = context.buffer(np.ascontiguousarray(content, np.uint32).tobytes())
    return BufferTexture(context, buffer, kind), buffer


def first_triangles(draw_list: DrawList, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """(rows,) the slot of each instance row and where its triangles begin in the index pool; −1 where it is not drawn."""
    slot, first = np.full(rows, -1, np.int64), np.full(rows, -1, np.int64)
    begins = draw_list.ranges.start == 0
    slot[draw_list.ranges.rows] = draw_list.ranges.slots
    first[draw_list.ranges.rows[begins]] = draw_list.ranges.first[begins] // 3
    for group in draw_list.groups:
        slot[group.rows], first[group.rows] = group.slots, group.first_index // 3
    return slot, first


def _places(fine: DrawList, instances: int, coarse: DrawList, rows: np.ndarray) -> np.ndarray:
    """(S, 2) by the coarse list's slots: the slot that the original has, and where its triangles begin."""
    slot, first = first_triangles(fine, instances)
    used = coarse.rows_of_slot >= 0
    own = rows[coarse.rows_of_slot[used]]
    out = np.zeros((len(used), 2), np.int64)
    out[used, 0], out[used, 1] = slot[own], first[own]
    return out


def _sources(coarse: DrawList, levels: list[Coarse], mesh_index: np.ndarray) -> np.ndarray:
    """(T,) by the coarse index pool's triangles: the triangle of the original, counted from its first."""
    _, first = first_triangles(coarse, len(mesh_index))
    out = np.zeros(coarse.pools.indices.size // 12, np.int64)
    for row in np.flatnonzero(first >= 0).tolist():
        source = levels[mesh_index[row]].source
        out[first[row] : first[row] + len(source)] = source
    return out
