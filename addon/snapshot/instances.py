"""The depsgraph's instances as rows: the only Python loop of a snapshot, kept to a handful of attribute reads per instance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np

from ..maths.view import Light
from .lights import light_from_object
from .materials import DEFAULT_COLOR, Color, base_color
from .meshes import Prepared

IGNORED, LIGHT, CAMERA = -1, -2, -3
FLAT = 1e-12


@dataclass(frozen=True, eq=False)
class Kind:
    """What all instances of one object with one mesh share: its drawable meshes, and a colour for each of them."""

    prepared: Prepared
    colors: tuple[Color, ...]


@dataclass(eq=False)
class Rows:
    """What the loop found, world coordinates absolute: row i is an instance of `kinds[kind[i]]` called `names[i]` at `matrices[i]`."""

    kinds: list[Kind] = field(default_factory=list)
    kind: list[int] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    matrices: np.ndarray = field(default_factory=lambda: np.empty((0, 4, 4)))
    lights: list[Light] = field(default_factory=list)
    cameras: list[bpy.types.Object] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


class InstanceLoop:
    """Walks `depsgraph.object_instances` once. `prepare` turns an evaluated mesh into its drawable meshes (cached by the caller).

    Objects other than meshes need no care: the depsgraph yields the mesh of a curve, text, metaball or surface as an instance of its own.
    """

    def __init__(self, depsgraph: bpy.types.Depsgraph, prepare: Callable[[bpy.types.Object], Prepared | None],
                 use_object_color: bool = False, space: bpy.types.SpaceView3D | None = None) -> None:
        self.depsgraph, self.prepare, self.use_object_color, self.space = depsgraph, prepare, use_object_color, space
        self.rows = Rows()
        self._colors: dict[int, Color] = {}

    def run(self) -> Rows:
        """The rows; matrices that are not finite or squash an object flat are left out with a warning."""
        matrices = read_matrices(self.depsgraph)
        index = self._walk(matrices)
        rows = self.rows
        rows.matrices = matrices[index]
        usable = is_invertible(rows.matrices)
        if not usable.all():
            bad = [rows.names[i] for i in np.flatnonzero(~usable)]
            rows.warnings.append(f"Left out, scaled to zero or placed at infinity: {listed(bad)}. Set their scale back to 1.")
            rows.matrices = rows.matrices[usable]
            rows.kind = [k for k, good in zip(rows.kind, usable, strict=True) if good]
            rows.names = [n for n, good in zip(rows.names, usable, strict=True) if good]
        return rows

    def _walk(self, matrices: np.ndarray) -> list[int]:
        shown = read_shown(self.depsgraph, len(matrices)).tolist()
        table: dict[tuple[int, str], int] = {}
        kind_of, names, index = self.rows.kind, self.rows.names, []
        for i, instance in enumerate(self.depsgraph.object_instances):
            if not shown[i]:
                continue
            ob = instance.object
            data = ob.data
            if data is None:
                continue
            name = ob.name_full
            key = (data.as_pointer(), name)
            kind = table.get(key)
            if kind is None:
                kind = table[key] = self._visit(ob, data)
            if kind >= 0:
                kind_of.append(kind)
                names.append(name)
                index.append(i)
            elif kind == LIGHT:
                self._add_light(ob, matrices[i])
            elif kind == CAMERA and not instance.is_instance:
                self.rows.cameras.append(ob.original)
        return index

    def _visit(self, ob: bpy.types.Object, data: bpy.types.ID) -> int:
        """What the first instance of its kind is: an index into `kinds`, or one of the negative marks."""
        if ob.type != "MESH":
            return {"LIGHT": LIGHT, "CAMERA": CAMERA}.get(ob.type, IGNORED)
        if self.space is not None and not ob.original.visible_in_viewport_get(self.space):
            return IGNORED
        prepared = self.prepare(ob)
        if prepared is None or not prepared.meshes:
            return IGNORED
        self.rows.kinds.append(Kind(prepared, self._slot_colors(ob, data, prepared.slots)))
        return len(self.rows.kinds) - 1

    def _slot_colors(self, ob: bpy.types.Object, data: bpy.types.Mesh, slots: tuple[int, ...]) -> tuple[Color, ...]:
        if self.use_object_color:
            return (tuple(ob.color),) * len(slots)
        count = max(len(data.materials), 1)
        return tuple(self._color(self._material(ob, data, min(slot, count - 1))) for slot in slots)

    @staticmethod
    def _material(ob: bpy.types.Object, data: bpy.types.Mesh, slot: int) -> bpy.types.Material | None:
        """The object's own material where its slot is linked to the object, else the mesh's."""
        if slot < len(ob.material_slots) and ob.material_slots[slot].link == "OBJECT":
            return ob.material_slots[slot].material
        return data.materials[slot] if slot < len(data.materials) else None

    def _color(self, material: bpy.types.Material | None) -> Color:
        if material is None:
            return DEFAULT_COLOR
        pointer = material.as_pointer()
        if pointer not in self._colors:
            self._colors[pointer] = base_color(material)
        return self._colors[pointer]

    def _add_light(self, ob: bpy.types.Object, matrix: np.ndarray) -> None:
        light, warning = light_from_object(ob, matrix, np.zeros(3))
        if light is not None:
            self.rows.lights.append(light)
        if warning:
            self.rows.warnings.append(warning)


def read_matrices(depsgraph: bpy.types.Depsgraph) -> np.ndarray:
    """(N, 4, 4) float64 world from object of every instance, in the depsgraph's order, in one call."""
    count = len(depsgraph.object_instances)
    flat = np.empty(16 * count, dtype=np.float32)
    depsgraph.object_instances.foreach_get("matrix_world", flat)
    return flat.reshape(count, 4, 4).transpose(0, 2, 1).astype(np.float64)


def read_shown(depsgraph: bpy.types.Depsgraph, count: int) -> np.ndarray:
    """(N,) bool: shown itself, not only its instances."""
    shown = np.empty(count, dtype=bool)
    depsgraph.object_instances.foreach_get("show_self", shown)
    return shown


def is_invertible(matrices: np.ndarray) -> np.ndarray:
    """(N,) bool: finite, and the volume of the unit cube's image is not lost against its longest edge cubed."""
    finite = np.isfinite(matrices).all(axis=(1, 2))
    linear = np.where(finite[:, None, None], matrices, 0.0)[:, :3, :3]
    longest = np.linalg.norm(linear, axis=1).max(axis=1, initial=0.0)
    volume = np.abs(np.einsum("ni,ni->n", linear[:, :, 0], np.cross(linear[:, :, 1], linear[:, :, 2])))
    return finite & (volume > FLAT * longest**3)


def listed(names: list[str], at_most: int = 3) -> str:
    """'A', 'B', 'C' and 4 more."""
    shown = ", ".join(f"'{n}'" for n in names[:at_most])
    return shown if len(names) <= at_most else f"{shown} and {len(names) - at_most} more"
