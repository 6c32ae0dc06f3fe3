"""The depsgraph's instances as rows: the only Python loop of a snapshot, kept to a handful of attribute reads per instance."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import bpy
import numpy as np

from ...maths.view import Light
from ...scene.records import Mark
from .complaints import complaints
from .light_links import Linked, links_of
from .lights import light_from_object
from .materials import Followed, Paint, paint_of, viewport_paint
from .random_numbers import random_of
from .varied import slot_and_color
from .visibility import any_index, flags_reader

MarkOf = Callable[[bpy.types.DepsgraphObjectInstance], Mark | None]
IGNORED, LIGHT, CAMERA = -1, -2, -3
SEVERAL = object()  # equal to no material
FLAT = 1e-12
_DRAWN_TYPES = ("mesh", "curve", "surf", "font", "meta", "empty", "curves", "hair_curves", "pointcloud", "volume")
_TYPE_SWITCHES = tuple(f"show_object_viewport_{kind}" for kind in _DRAWN_TYPES)


@dataclass(frozen=True, eq=False)
class Kind:
    """What all instances of one mesh with the same materials share: the mesh's number, and a paint for each material slot."""

    number: Hashable
    paints: tuple[Paint, ...]

    def paint(self, slot: int) -> Paint:
        """Slots beyond the last material show the last one, as in Blender; a slot with a colour shows that."""
        number, color = slot_and_color(slot)
        paint = self.paints[min(number, len(self.paints) - 1)]
        return paint if color is None else paint.where(color)


@dataclass(eq=False)
class Rows:
    """What the loop found, world coordinates absolute: row i is an instance of `kinds[kind[i]]` called `names[i]` at `matrices[i]`.

    `marks[i]` is the impostor it belongs to, `flags[i]` what is special about it, `indices[i]` the index its author gave
    it; these lists are empty when nobody asked, or all is usual.
    """

    kinds: list[Kind] = field(default_factory=list)
    kind: list[int] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    marks: list[Mark | None] = field(default_factory=list)
    flags: list[int] = field(default_factory=list)
    indices: list[int] = field(default_factory=list)
    matrices: np.ndarray = field(default_factory=lambda: np.empty((0, 4, 4)))
    lights: list[Light] = field(default_factory=list)
    links: dict[str, tuple[Linked, Linked]] = field(default_factory=dict)
    cameras: list[bpy.types.Object] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    mist: tuple[float, float, str] = (5.0, 25.0, "QUADRATIC")

    def keep(self, usable: np.ndarray) -> list[str]:
        """Drop the rows where `usable` is False; their names."""
        dropped = [self.names[i] for i in np.flatnonzero(~usable)]
        if dropped:
            self.matrices = self.matrices[usable]
            self.kind = [k for k, good in zip(self.kind, usable, strict=True) if good]
            self.names = [n for n, good in zip(self.names, usable, strict=True) if good]
            if self.marks:
                self.marks = [m for m, good in zip(self.marks, usable, strict=True) if good]
            if self.indices:
                self.indices = [n for n, good in zip(self.indices, usable, strict=True) if good]
            if self.flags:
                self.flags = [f for f, good in zip(self.flags, usable, strict=True) if good]
        return dropped


class InstanceLoop:
    """Walks `depsgraph.object_instances` once. `number_of` names an evaluated object's mesh, None when it has no face.

    Objects other than meshes need no care: the depsgraph yields the mesh of a curve, text, metaball or surface as an instance of its own.
    """

    def __init__(
        self,
        depsgraph: bpy.types.Depsgraph,
        number_of: Callable[[bpy.types.Object], Hashable | None],
        use_object_color: bool = False,
        space: bpy.types.SpaceView3D | None = None,
        mark_of: MarkOf | None = None,
    ) -> None:
        self.depsgraph, self.number_of, self.use_object_color, self.space = depsgraph, number_of, use_object_color, space
        self.mark_of = mark_of
        self.flags_of = flags_reader(depsgraph)
        self.override = depsgraph.view_layer.material_override
        self.rows = Rows()
        self._paints: dict[int, Followed] = {}
        self._slotted: dict[int, object] = {}  # kinds with materials: the one, or SEVERAL
        self._asking: set[int] = set()  # kinds with a material that depends on the object
        self._variants: dict[tuple[int, tuple[Paint, ...]], int] = {}
        self._unfollowed: dict[str, None] = {}
        self._lights: list[bpy.types.Object] = []

    def run(self) -> Rows:
        """The rows; those whose matrix is not finite or squashes the object flat are left out with a warning."""
        index, count = self._walk()
        rows, world = self.rows, self.depsgraph.scene.world
        rows.warnings.extend(complaints(self.depsgraph, self._lights))
        self._lights.clear()
        if world is not None:
            mist = world.mist_settings
            rows.mist = float(mist.start), float(mist.depth), mist.falloff
        rows.matrices = read_matrices(self.depsgraph, count)[index]
        dropped = rows.keep(is_invertible(rows.matrices))
        if dropped:
            rows.warnings.append(f"Left out, scaled to zero or placed at infinity: {listed(dropped)}. Set their scale back to 1.")
        if self._unfollowed:
            rows.warnings.append(
                f"Shown in their viewport colour, because their nodes cannot be followed: {listed(list(self._unfollowed))}."
            )
        return rows

    def _walk(self) -> tuple[list[int], int]:
        """Fill the rows but for their matrices; the number of each row's instance, and how many instances there are.

        Every attribute read counts here, and every pass over the instances, even one to count them: about 1 µs for each instance.
        """
        kind_of_data: dict[bpy.types.ID, int] = {}
        kind_of, names, index, i = self.rows.kind, self.rows.names, [], -1
        use_object_color, slotted, asking, flags_of = self.use_object_color, self._slotted, self._asking, self.flags_of
        has_indices = any_index()
        is_all_shown = self.space is None or shows_everything(self.space)
        for i, instance in enumerate(self.depsgraph.object_instances):
            ob = instance.object
            data = ob.data
            if data is None or not instance.show_self:
                continue
            kind = kind_of_data.get(data)
            if kind is None:
                kind = kind_of_data[data] = self._visit(ob, data)
            if kind >= 0:
                if not (is_all_shown or self._is_shown_in_space(instance)):
                    continue
                if use_object_color or kind in asking or (kind in slotted and ob.active_material != slotted[kind]):
                    kind = self._variant(ob, kind, instance.random_id if instance.is_instance else random_of(ob.name))
                kind_of.append(kind)
                names.append(ob.name)
                index.append(i)
                if self.mark_of is not None:
                    self.rows.marks.append(self.mark_of(instance))
                if has_indices:
                    self.rows.indices.append(ob.pass_index)
                if flags_of is not None:
                    self.rows.flags.append(flags_of(instance))
            elif kind == LIGHT:
                self._add_light(ob, np.array(instance.matrix_world, dtype=np.float64))
            elif kind == CAMERA and not instance.is_instance:
                self.rows.cameras.append(ob.original)
        return index, i + 1

    def _is_shown_in_space(self, instance: bpy.types.DepsgraphObjectInstance) -> bool:
        """Whether the viewport shows it (local view, hidden collections); an instance is shown where what makes it is."""
        ob = instance.parent if instance.is_instance else instance.object
        return ob.original.visible_in_viewport_get(self.space)

    def _visit(self, ob: bpy.types.Object, data: bpy.types.ID) -> int:
        """What the first instance of a datablock is: an index into `kinds`, or one of the negative marks."""
        if ob.type != "MESH":
            return {"LIGHT": LIGHT, "CAMERA": CAMERA}.get(ob.type, IGNORED)
        number = self.number_of(ob)
        if number is None:
            return IGNORED
        kind = len(self.rows.kinds)
        materials = [self.override] if self.override else list(data.materials)
        followed = [self._followed(material) for material in materials]
        self.rows.kinds.append(Kind(number, tuple(one.paint for one in followed) or (paint_of(None).paint,)))
        if any(one.asks for one in followed):
            self._asking.add(kind)
        if materials and not self.override:
            self._slotted[kind] = materials[0] if len(materials) == 1 else SEVERAL
        return kind

    def _variant(self, ob: bpy.types.Object, kind: int, random_id: int) -> int:
        """The kind of an object that differs from what its mesh says: its own colour, materials linked to it or that depend on it."""
        paints = base = self.rows.kinds[kind].paints
        if self.use_object_color:
            paints = (viewport_paint(ob.color),)
        else:
            materials = [self.override] if self.override else [slot.material for slot in ob.material_slots]
            paints = tuple(self._paint_on(material, ob, random_id) for material in materials) or base
        if paints == base:
            return kind
        if (kind, paints) not in self._variants:
            self._variants[kind, paints] = len(self.rows.kinds)
            self.rows.kinds.append(Kind(self.rows.kinds[kind].number, paints))
        return self._variants[kind, paints]

    def _paint_on(self, material: bpy.types.Material | None, ob: bpy.types.Object, random_id: int) -> Paint:
        """The paint of a material on this very object."""
        followed = self._followed(material)
        if followed.asks:
            followed = self._noted(material, paint_of(material, ob, (random_id & 0xFFFFFFFF) / 0xFFFFFFFF))
        return followed.paint

    def _followed(self, material: bpy.types.Material | None) -> Followed:
        """The paint of a material on no object in particular, found once."""
        pointer = material.as_pointer() if material is not None else 0
        if pointer not in self._paints:
            self._paints[pointer] = followed = paint_of(material)
            if not followed.asks:
                self._noted(material, followed)
        return self._paints[pointer]

    def _noted(self, material: bpy.types.Material | None, followed: Followed) -> Followed:
        if not followed.is_followed:
            self._unfollowed[material.name] = None
        return followed

    def _add_light(self, ob: bpy.types.Object, matrix: np.ndarray) -> None:
        self._lights.append(ob.original)
        light, warning = light_from_object(ob, matrix, np.zeros(3))
        if light is not None:
            self.rows.lights.append(light)
            links = links_of(ob)
            if links is not None:
                self.rows.links[light.name] = links
        if warning:
            self.rows.warnings.append(warning)


def shows_everything(space: bpy.types.SpaceView3D) -> bool:
    """True when the viewport hides nothing that the scene shows: no local view, no hidden collections or types of its own."""
    if space.local_view is not None or space.use_local_collections:
        return False
    return all(getattr(space, name) for name in _TYPE_SWITCHES if hasattr(space, name))


def read_matrices(depsgraph: bpy.types.Depsgraph, count: int) -> np.ndarray:
    """(count, 4, 4) float64 world from object of every instance, in the depsgraph's order, in one call."""
    flat = np.empty(16 * count, dtype=np.float32)
    depsgraph.object_instances.foreach_get("matrix_world", flat)
    return flat.reshape(count, 4, 4).transpose(0, 2, 1).astype(np.float64)


def is_invertible(matrices: np.ndarray) -> np.ndarray:
    """(N,) bool: finite, and the volume of the unit cube's image is not lost against its longest edge cubed."""
    finite = np.True_ if np.isfinite(matrices).all() else np.isfinite(matrices).all(axis=(1, 2))
    linear = matrices[:, :3, :3] if finite.ndim == 0 else np.where(finite[:, None, None], matrices, 0.0)[:, :3, :3]
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = linear.transpose(2, 1, 0)  # the edges; far quicker than numpy over axes of length 3
    volume = np.abs(ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx))
    squared = np.maximum(np.maximum(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz), cx * cx + cy * cy + cz * cz)
    return finite & (volume > FLAT * squared * np.sqrt(squared))


def listed(names: list[str], at_most: int = 3) -> str:
    """'A', 'B', 'C' and 4 more."""
    shown = ", ".join(f"'{n}'" for n in names[:at_most])
    return shown if len(names) <= at_most else f"{shown} and {len(names) - at_most} more"
