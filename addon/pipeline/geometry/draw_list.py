"""What to draw of one scene: index ranges with bounds, instanced groups, and the table of instances. Worker thread only."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import moderngl
import numpy as np

from ...maths.spaces import transform
from ...scene.looks import PLAIN_LOOKS
from ...scene.records import Scene
from ..gl.gl_raw import BufferTexture, draw_triangles, write_buffer
from ..gl.programs import SAMPLER_UNITS, set_uniforms
from .clusters import clustered, longest_edge, runs, visible_boxes
from .culling import Culling, back_faces_left_out
from .pools import Pools

ROWS_PER_SLOT = 4
FLAG_SHIFT, LOOK_SHIFT = 1, 8  # as in common_look.glsl
MERGED_GAP = 3072  # hidden indices drawn along rather than paying for another call


Select = Callable[[np.ndarray, np.ndarray], np.ndarray]  # (bounds_ws, longest edge in metres) -> mask


@dataclass(slots=True)
class InstancedGroup:
    """A mesh in object space and the slots it is placed at, with the instance row, the world bounds and the longest edge of each.

    `front`: 1 where the mesh is closed, −1 where it is and its instances are mirrored, 0 where it is not.
    """

    first_index: int
    index_count: int
    slots: np.ndarray
    rows: np.ndarray
    bounds_ws: np.ndarray
    longest_edge_m: np.ndarray
    front: int = 0


@dataclass(slots=True)
class IndexRanges:
    """Baked clusters: index ranges in order, the instance row of each, its world bounds and longest edge, its slot, and the triangle of
    its mesh (in the order of `clustered`) that it begins with; whether that mesh is closed, and the bounds of all of it."""

    first: np.ndarray
    count: np.ndarray
    rows: np.ndarray
    bounds_ws: np.ndarray
    longest_edge_m: np.ndarray
    slots: np.ndarray
    start: np.ndarray
    is_closed: np.ndarray
    wholes_ws: np.ndarray


@dataclass(frozen=True, slots=True)
class Chosen:
    """Part of a draw list: which of its ranges (R,) bool, and which instances of each group."""

    ranges: np.ndarray
    groups: list[np.ndarray]

    def __bool__(self) -> bool:
        return bool(self.ranges.any()) or any(mask.any() for mask in self.groups)


@dataclass(frozen=True, slots=True)
class DrawnPart:
    """Triangles that follow one another: of an instance row, in one slot, from `start` of their mesh's drawing order, `first_triangle` of
    the index pool. `corners_os` (T, 3, 3) float64."""

    row: int
    slot: int
    start: int
    first_triangle: int
    corners_os: np.ndarray


@dataclass
class DrawList:
    """Drawable form of a scene. `table`: four RGBA32F texels a slot (rows of world_from_object, base colour); `info`: RGBA32UI
    (object id + 1, material slot + 1, instance row; bit 0: baked, then the flags and the look's number)."""

    context: moderngl.Context
    pools: Pools
    ranges: IndexRanges
    groups: list[InstancedGroup]
    triangle_count: int
    table_buffer: moderngl.Buffer
    info_buffer: moderngl.Buffer
    visible_buffer: moderngl.Buffer
    table: BufferTexture
    info: BufferTexture
    visible: BufferTexture
    scene: Scene
    rows_of_slot: np.ndarray
    vertex_arrays: dict[tuple[int, bool], moderngl.VertexArray] = field(default_factory=dict)
    on_demand: dict[str, tuple[BufferTexture, moderngl.Buffer]] = field(default_factory=dict)
    _corners: dict[Hashable, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    _boxes: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)

    @classmethod
    def build(
        cls,
        context: moderngl.Context,
        pools: Pools,
        scene: Scene,
        ranges: IndexRanges,
        groups: list[InstancedGroup],
        rows_of_slot: np.ndarray,
        baked_slots: int,
    ) -> DrawList:
        """Upload the instance table of `scene`; `rows_of_slot` (S,) names the instance row of each slot (−1 = unused)."""
        table, info = _table(scene, rows_of_slot, baked_slots)
        slots = sum(len(g.slots) for g in groups)
        buffers = context.buffer(table.tobytes()), context.buffer(info.tobytes()), context.buffer(reserve=max(4, slots * 4))
        textures = (
            BufferTexture(context, buffers[0], "rgba32f"),
            BufferTexture(context, buffers[1], "rgba32ui"),
            BufferTexture(context, buffers[2], "r32ui"),
        )
        return cls(
            context,
            pools,
            ranges,
            groups,
            scene.triangle_count,
            *buffers,
            *textures,
            scene,
            rows_of_slot,
        )

    def draw(
        self,
        baked: moderngl.Program,
        instanced: moderngl.Program,
        planes: np.ndarray,
        *,
        attributes: bool,
        select: Select | None = None,
        rows: np.ndarray | None = None,
        without: Chosen | None = None,
        culling: Culling | None = None,
    ) -> int:
        """Draw all that reaches inside `planes` (and `select` chooses) with the two variants of a program; returns the triangles sent.

        `rows` (I,) bool: only these instance rows of the scene. `without`: what is left out. `culling`: None draws back faces, too.
        `attributes` False binds positions only (depth passes). Programs may use `u_first_triangle` and the instance table.
        """
        self.bind_table()
        chosen = self.chosen(planes, select, rows)
        if without is not None:
            chosen = Chosen(chosen.ranges & ~without.ranges, [a & ~b for a, b in zip(chosen.groups, without.groups, strict=True)])
        barriers = self.barriers if without is None else self.barriers + np.cumsum(without.ranges)
        gap = MERGED_GAP if select is None and rows is None else 0
        culled, sent = self._culled(chosen, culling), 0
        for mask, by in ((culled.ranges, culling), (chosen.ranges & ~culled.ranges, None)):
            with back_faces_left_out(self.context, by):
                sent += self._draw_ranges(baked, attributes, mask, barriers, gap)
        return sent + self._draw_groups(instanced, attributes, chosen.groups, culled.groups, culling)

    def chosen(self, planes: np.ndarray, select: Select | None, rows: np.ndarray | None = None) -> Chosen:
        """What reaches inside `planes` and `select` chooses, of the instance rows `rows` (I,) bool."""
        boxes = self._all
        mask = visible_boxes(boxes.centre, boxes.half, planes)
        if rows is not None:
            mask &= rows[boxes.rows]
        if select is not None:
            mask &= select(boxes.bounds_ws, boxes.longest_edge_m)
        ranges, *groups = np.split(mask, boxes.ends[:-1])
        return Chosen(ranges, groups)

    @cached_property
    def barriers(self) -> np.ndarray:
        """(R,) a number that rises from range to range where an instanced mesh lies between them: nothing is drawn along across it, nor
        across what is left out. All else between ranges is nothing: given back, and zero."""
        return np.searchsorted(np.sort([group.first_index for group in self.groups]), self.ranges.first)

    @cached_property
    def _all(self) -> _BoxTable:
        """Ranges, then the instances of every group, as one list of boxes."""
        things = [self.ranges, *self.groups]
        bounds = np.concatenate([thing.bounds_ws for thing in things])
        return _BoxTable(
            bounds,
            0.5 * (bounds[:, 0] + bounds[:, 1]),
            0.5 * (bounds[:, 1] - bounds[:, 0]),
            np.concatenate([thing.rows for thing in things]),
            np.concatenate([thing.longest_edge_m for thing in things]),
            np.concatenate([self.ranges.wholes_ws, *(group.bounds_ws for group in self.groups)]),
            np.concatenate([self.ranges.is_closed, *(np.full(len(group.rows), group.front != 0) for group in self.groups)]),
            np.cumsum([len(thing.rows) for thing in things]),
        )

    def _culled(self, chosen: Chosen, culling: Culling | None) -> Chosen:
        """What of `chosen` is drawn without its back faces."""
        boxes = self._all
        allowed = np.zeros(len(boxes.rows), bool) if culling is None else boxes.is_closed & culling.allows(boxes.wholes_ws)
        ranges, *groups = np.split(allowed, boxes.ends[:-1])
        return Chosen(chosen.ranges & ranges, [a & b for a, b in zip(chosen.groups, groups, strict=True)])

    def _draw_ranges(self, program: moderngl.Program, attributes: bool, mask: np.ndarray, barriers: np.ndarray | None, gap: int) -> int:
        sent, ranges = 0, self.ranges
        for first, count in runs(mask, ranges.first, ranges.count, barriers, gap):
            set_uniforms(program, u_first_triangle=first // 3)
            draw_triangles(self.context, self._vertex_array(program, attributes), count, first)
            sent += count // 3
        return sent

    @cached_property
    def longest_edge_m(self) -> float:
        """The longest edge of anything in the list, metres; 0 where there is nothing."""
        return float(self._all.longest_edge_m.max(initial=0.0))

    def corners_os(self, row: int) -> np.ndarray:
        """(T, 3, 3) float64 corners in object space of the triangles of an instance row, in the order they are drawn in."""
        return self._drawn(row)[1]

    def parts_of(self, chosen: Chosen) -> Iterator[DrawnPart]:
        """Every cluster and instance chosen."""
        ranges = self.ranges
        for i in np.flatnonzero(chosen.ranges):
            row, start, count = int(ranges.rows[i]), int(ranges.start[i]), int(ranges.count[i]) // 3
            yield DrawnPart(row, int(ranges.slots[i]), start, int(ranges.first[i]) // 3, self.corners_os(row)[start : start + count])
        for group, mask in zip(self.groups, chosen.groups, strict=True):
            for i in np.flatnonzero(mask):
                row = int(group.rows[i])
                yield DrawnPart(row, int(group.slots[i]), 0, group.first_index // 3, self.corners_os(row))

    def normals_os(self, part: DrawnPart) -> np.ndarray:
        """(T, 3, 3) float32 shading normals in object space at the corners of a part's triangles."""
        triangles, _ = self._drawn(part.row)
        normals = self.scene.meshes[int(self.scene.instances.mesh_index[part.row])].normals
        return normals[triangles[part.start : part.start + len(part.corners_os)]]

    def boxes_of(self, part: DrawnPart) -> tuple[np.ndarray, np.ndarray]:
        """World bounds (T, 2, 3) and longest edge (T,) in metres of a part's triangles; kept."""
        key = part.row, part.start
        if key not in self._boxes:
            corners = transform(self.scene.instances.world_from_object[part.row], part.corners_os)[..., :3]
            self._boxes[key] = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1), longest_edge(corners)
        return self._boxes[key]

    def _drawn(self, row: int) -> tuple[np.ndarray, np.ndarray]:
        """The triangles (T, 3) of an instance row's mesh in the order they are drawn in, and their corners (T, 3, 3); kept."""
        mesh = self.scene.meshes[int(self.scene.instances.mesh_index[row])]
        if mesh.key not in self._corners:
            triangles, _ = clustered(mesh.positions, mesh.triangles)
            self._corners[mesh.key] = triangles, mesh.positions.astype(np.float64)[triangles]
        return self._corners[mesh.key]

    def bounds_ws(self) -> np.ndarray:
        """(B, 2, 3) world bounds of all that can be drawn."""
        return self._all.bounds_ws

    def bind_table(self) -> None:
        """Bind the instance table for `common_instance.glsl`."""
        self.table.use(SAMPLER_UNITS["u_table"])
        self.info.use(SAMPLER_UNITS["u_info"])

    def extents(self) -> BufferTexture:
        """`u_extents` (RGBA32F) by slot: half the extents of its object, world axes, metres; made when first asked for."""
        if "u_extents" not in self.on_demand:
            buffer = self.context.buffer(_half_extents(self.scene, self.rows_of_slot).tobytes())
            self.on_demand["u_extents"] = BufferTexture(self.context, buffer, "rgba32f"), buffer
        return self.on_demand["u_extents"][0]

    def looks(self) -> BufferTexture | None:
        """`u_looks` (RGBA32F): four texels for each look of the scene, made when first asked for; None where all is plain."""
        if np.array_equal(self.scene.looks, PLAIN_LOOKS) and not self.scene.instances.flags.any():
            return None
        if "u_looks" not in self.on_demand:
            buffer = self.context.buffer(np.ascontiguousarray(self.scene.looks, np.float32).tobytes())
            self.on_demand["u_looks"] = BufferTexture(self.context, buffer, "rgba32f"), buffer
        return self.on_demand["u_looks"][0]

    def _draw_groups(
        self, program: moderngl.Program, attributes: bool, masks: list[np.ndarray], culled: list[np.ndarray], culling: Culling | None
    ) -> int:
        both = (
            (group, front, mask)
            for group, a, b in zip(self.groups, masks, culled, strict=True)
            for front, mask in ((group.front, b), (0, a & ~b))
        )
        drawn = [(group, front, group.slots[mask]) for group, front, mask in both if mask.any()]
        if not drawn:
            return 0
        write_buffer(self.context, self.visible_buffer, np.concatenate([slots for _, _, slots in drawn]).tobytes())
        self.visible.use(SAMPLER_UNITS["u_visible"])
        array = self._vertex_array(program, attributes)
        firsts = np.cumsum([0, *(len(slots) for _, _, slots in drawn)]).tolist()
        sent = 0
        for front in (1, -1, 0):
            with back_faces_left_out(self.context, culling if front else None, mirrored=front < 0):
                for (group, own, slots), cursor in zip(drawn, firsts, strict=False):
                    if own == front:
                        set_uniforms(program, u_first_triangle=group.first_index // 3, u_first_instance=cursor)
                        draw_triangles(self.context, array, group.index_count, group.first_index, len(slots))
                        sent += group.index_count // 3 * len(slots)
        return sent

    def _vertex_array(self, program: moderngl.Program, attributes: bool) -> moderngl.VertexArray:
        key = (program.glo, attributes)
        if key not in self.vertex_arrays:
            pools = self.pools
            content = [(pools.positions, "3f4", "in_position")]
            if attributes and "in_normal" in program:
                content.append((pools.normals, "1u4", "in_normal"))
            if "in_slot" in program:
                content.append((pools.slots, "1u4", "in_slot"))
            self.vertex_arrays[key] = self.context.vertex_array(program, content, index_buffer=pools.indices, index_element_size=4)
        return self.vertex_arrays[key]

    def release(self) -> None:
        """Free the tables and vertex arrays (the pools belong to the store)."""
        for array in self.vertex_arrays.values():
            array.release()
        self.vertex_arrays.clear()
        for thing in (
            self.table,
            self.info,
            self.visible,
            self.table_buffer,
            self.info_buffer,
            self.visible_buffer,
            *(thing for pair in self.on_demand.values() for thing in pair),
        ):
            thing.release()


@dataclass(frozen=True, slots=True)
class _BoxTable:
    """Boxes (B, 2, 3) with their centres and halves, instance rows and longest edges; the box of the whole mesh that each belongs to, and
    whether that is closed; `ends` of the lists that they come from."""

    bounds_ws: np.ndarray
    centre: np.ndarray
    half: np.ndarray
    rows: np.ndarray
    longest_edge_m: np.ndarray
    wholes_ws: np.ndarray
    is_closed: np.ndarray
    ends: np.ndarray


def _table(scene: Scene, rows_of_slot: np.ndarray, baked_slots: int) -> tuple[np.ndarray, np.ndarray]:
    """(S, 4, 4) float32 and (S, 4) uint32: the instance table; baked slots get the identity, their vertices being placed already."""
    inst = scene.instances
    used = rows_of_slot >= 0
    rows = rows_of_slot[used]
    table = np.zeros((len(rows_of_slot), ROWS_PER_SLOT, 4), np.float32)
    table[:, :3] = np.eye(4, dtype=np.float32)[:3]
    placed = np.flatnonzero(used & (np.arange(len(used)) >= baked_slots))
    table[placed, :3] = inst.world_from_object[rows_of_slot[placed], :3]
    table[used, 3] = inst.base_color[rows]
    info = np.zeros((len(rows_of_slot), 4), np.uint32)
    info[used, 0] = inst.object_id[rows] + 1
    info[used, 1] = inst.material_slot[rows] + 1
    info[used, 2] = rows
    info[used, 3] = (inst.look[rows].astype(np.uint32) << LOOK_SHIFT) | (inst.flags[rows].astype(np.uint32) << FLAG_SHIFT)
    info[:baked_slots, 3] |= 1
    return table, info


def _half_extents(scene: Scene, rows_of_slot: np.ndarray) -> np.ndarray:
    """(S, 4) float32: half the size of the box of all instance rows that share the slot's object; 0 for unused slots."""
    bounds, object_id = scene.instance_bounds_ws(), scene.instances.object_id
    count = int(object_id.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, object_id, bounds[:, 0])
    np.maximum.at(high, object_id, bounds[:, 1])
    out = np.zeros((len(rows_of_slot), 4), np.float32)
    used = rows_of_slot >= 0
    chosen = object_id[rows_of_slot[used]]
    out[used, :3] = (high[chosen] - low[chosen]) / 2.0
    return out
