"""The scene as frozen arrays: what `blender/snapshot` and `cad` make and the renderer draws. No bpy, no GL."""

from __future__ import annotations

import hashlib
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import DTypeLike

from ..errors import SceneError
from ..maths.view import Camera, Light
from .looks import BEHIND, CAP, CATCHER, GROUND, HIDDEN, HOLDOUT, LIGHT_BEHIND, NO_SHADOW, PLAIN_LOOKS, UNLIT


def frozen(array: np.ndarray, dtype: DTypeLike) -> np.ndarray:
    """A C-contiguous array of that dtype that nobody can write to."""
    out = np.ascontiguousarray(array, dtype=dtype)
    if out is array and array.flags.writeable:
        out = array.view()
    out.setflags(write=False)
    return out


@dataclass(frozen=True, eq=False)
class Mesh:
    """One unique piece of geometry: the triangles of one material slot of one mesh, in object space.

    `key` names the content: two meshes with equal keys hold equal arrays, so a key already on the GPU is not uploaded again.
    `positions` (V, 3) float32, `normals` (V, 3) float32 unit shading normals (vertices are duplicated where the surface is creased),
    `triangles` (T, 3) int32. All finite; no zero-area triangle.
    """

    key: Hashable
    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", frozen(self.positions, np.float32))
        object.__setattr__(self, "normals", frozen(self.normals, np.float32))
        object.__setattr__(self, "triangles", frozen(self.triangles, np.int32))

    @cached_property
    def bounds_os(self) -> np.ndarray:
        """(2, 3) smallest and largest corner in object space."""
        return np.stack([self.positions.min(axis=0), self.positions.max(axis=0)])


@dataclass(frozen=True, eq=False)
class Instances:
    """I placed meshes, as arrays. Row i draws `meshes[mesh_index[i]]`.

    `world_from_object` (I, 4, 4) float64, world relative to `Scene.origin_ws`; `object_id` (I,) int32 ≥ 0, index into `Scene.object_names`
    (rows of one object with several material slots share it); `material_slot` (I,) int32; `base_color` (I, 4) float32 linear RGBA;
    `look` (I,) int32, index into `Scene.looks`; `flags` (I,) uint8 of `scene.looks`: what is special about it; `material` (I,) int32,
    index into `Scene.materials`. Those three may be left out.
    """

    mesh_index: np.ndarray
    world_from_object: np.ndarray
    object_id: np.ndarray
    material_slot: np.ndarray
    base_color: np.ndarray
    look: np.ndarray = None  # type: ignore[assignment]  # none given: zeros
    flags: np.ndarray = None  # type: ignore[assignment]
    material: np.ndarray = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        count = len(self.mesh_index)
        for name in ("look", "flags", "material"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.zeros(count, np.uint8))
        for name, dtype, shape in (
            ("mesh_index", np.int32, ()),
            ("world_from_object", np.float64, (4, 4)),
            ("object_id", np.int32, ()),
            ("material_slot", np.int32, ()),
            ("base_color", np.float32, (4,)),
            ("look", np.int32, ()),
            ("flags", np.uint8, ()),
            ("material", np.int32, ()),
        ):
            array = frozen(getattr(self, name), dtype)
            if array.shape != (count, *shape):
                raise SceneError(f"Instances.{name} has shape {array.shape}, expected {(count, *shape)}.")
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.mesh_index)

    def without(self, flag: int) -> np.ndarray | None:
        """(I,) bool: the rows that do not have a flag of `scene.looks`; None: all of them."""
        kept = (self.flags & flag) == 0
        return None if kept.all() else kept


@dataclass(frozen=True, slots=True)
class Mark:
    """What the user marked as an impostor: an 'object' or a 'collection', by the number it keeps when renamed, undone or moved.

    `place` tells apart the copies that instancers make of it. `name` is what it is called now; marks are equal whatever their names.
    """

    kind: str
    uid: int
    place: tuple[int, ...] = ()
    name: str = field(default="", compare=False)


@dataclass(frozen=True, slots=True)
class Ground:
    """Where shadows on the ground fade out: from the middle of the model's footprint, `half` its extents, to `reach` metres beside it."""

    centre: tuple[float, float]
    half: tuple[float, float]
    reach: float

    def moved_by(self, offset: Sequence[float] | np.ndarray) -> Ground:
        """The same in a world whose origin lies at `offset` (3,)."""
        return replace(self, centre=(self.centre[0] - float(offset[0]), self.centre[1] - float(offset[1])))


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything one picture needs, read once. `origin_ws` (3,) float64 is the local origin that all other positions are relative to.

    `marks` one per object, parallel to `object_names`: the impostor it belongs to, None for none. Empty when nothing is marked.
    `looks` (L, 16) float32: the numbers of `looks.Look`s. `links` by the light's name, of lights that do not concern all objects:
    (objects,) bool those they do not light, (objects,) bool those that do not stand in their way. `object_index` (objects,) int32 and
    `materials` (name, index): what their author calls them; `mist` (begin, depth in metres, falloff).
    `ground` where one of the instances is the ground.
    """

    meshes: tuple[Mesh, ...]
    instances: Instances
    object_names: tuple[str, ...]
    origin_ws: np.ndarray
    lights: tuple[Light, ...] = ()
    cameras: tuple[Camera, ...] = ()
    warnings: tuple[str, ...] = field(default=())
    marks: tuple[Mark | None, ...] = ()
    looks: np.ndarray = field(default_factory=lambda: PLAIN_LOOKS)
    links: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    object_index: np.ndarray = None  # type: ignore[assignment]  # none given: zeros
    materials: tuple[tuple[str, int], ...] = (("", 0),)
    mist: tuple[float, float, str] = (5.0, 25.0, "QUADRATIC")
    ground: Ground | None = None

    def __post_init__(self) -> None:
        if self.object_index is None:
            object.__setattr__(self, "object_index", np.zeros(max(len(self.object_names), 1), np.int32))

    @property
    def triangle_count(self) -> int:
        """Triangles drawn: every instance counted."""
        per_mesh = np.array([len(m.triangles) for m in self.meshes], dtype=np.int64)
        return int(per_mesh[self.instances.mesh_index].sum()) if len(self.instances) else 0

    @cached_property
    def fingerprint(self) -> bytes:
        """16 bytes that name what the scene looks like and which lights it has: equal ones give equal pictures.

        An address in memory names nothing: that of a scene that is gone is soon another's. Cameras and object names do not count.
        """
        digest = hashlib.blake2b(digest_size=16)
        lights = [(light.name, light.key) for light in self.lights]
        digest.update(repr(([mesh.key for mesh in self.meshes], self.origin_ws.tolist(), lights, self.marks)).encode())
        digest.update(self.looks.tobytes())
        digest.update(repr([(name, *(mask.tobytes() for mask in masks)) for name, masks in self.links.items()]).encode())
        for column in fields(self.instances):
            digest.update(getattr(self.instances, column.name).data)
        return digest.digest()

    def lit_by(self, light: Light) -> Scene:
        """The scene as this light sees it: what it is not linked to has the flags that say so; the last one is kept."""
        if light.name not in self.links:
            return self
        if light.name not in self._lit:
            unlit, unblocking = (mask[self.instances.object_id] for mask in self.links[light.name])
            flags = self.instances.flags | np.where(unlit, UNLIT, 0).astype(np.uint8) | np.where(unblocking, NO_SHADOW, 0).astype(np.uint8)
            self._lit.clear()
            self._lit[light.name] = replace(self, instances=replace(self.instances, flags=flags))
        return self._lit[light.name]

    @cached_property
    def _lit(self) -> dict[str, Scene]:
        return {}

    def moved_by(self, offset: np.ndarray) -> Scene:
        """The same scene with its local origin `offset` (3,) metres away; the one moved last is kept."""
        key = tuple(np.asarray(offset, np.float64).tolist())
        if key not in self._moved:
            matrices = np.array(self.instances.world_from_object)
            matrices[:, :3, 3] -= key
            self._moved.clear()
            self._moved[key] = replace(
                self,
                instances=replace(self.instances, world_from_object=matrices),
                origin_ws=self.origin_ws + key,
                lights=tuple(light.moved_by(key) for light in self.lights),
                cameras=tuple(camera.moved_by(key) for camera in self.cameras),
                ground=self.ground and self.ground.moved_by(np.array(key)),
            )
        return self._moved[key]

    @cached_property
    def _moved(self) -> dict[tuple[float, ...], Scene]:
        return {}

    def instance_bounds_ws(self) -> np.ndarray:
        """(I, 2, 3) float64 axis-aligned world bounds of every instance (bounds of the eight transformed corners); computed once."""
        return self._instance_bounds_ws

    @cached_property
    def _instance_bounds_ws(self) -> np.ndarray:
        corners = [m.bounds_os for m in self.meshes] or [np.empty((0, 3))]
        boxes = np.concatenate(corners).reshape(-1, 2, 3)[self.instances.mesh_index].astype(np.float64)
        centre, half = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2
        m = self.instances.world_from_object
        c = np.einsum("iab,ib->ia", m[:, :3, :3], centre) + m[:, :3, 3]
        h = np.einsum("iab,ib->ia", np.abs(m[:, :3, :3]), half)
        return np.stack([c - h, c + h], axis=1)

    @cached_property
    def see_through(self) -> np.ndarray | None:
        """(I,) bool: the rows through which one sees what lies behind; None where there are none."""
        return self._passing(BEHIND)

    @cached_property
    def shines_through(self) -> np.ndarray | None:
        """(I,) bool: the rows that let some of the light through; None where there are none."""
        return self._passing(LIGHT_BEHIND)

    @cached_property
    def thin(self) -> np.ndarray | None:
        """(I,) bool: the see-through rows of which less than half is there: depths, numbers and normals are of what lies behind; None: none
        (Blender's Alpha Threshold of new layers)."""
        if self.see_through is None:
            return None
        thin = self.see_through & (self.looks[self.instances.look][:, BEHIND].mean(axis=1) > 0.5)
        return thin if thin.any() else None

    def whole_flags(self) -> np.ndarray:
        """(I,) uint8 flags where all or nothing is asked: what is thin is hidden, what does not block light casts no shadow."""
        thin, blocking = self.thin, self.blocking()
        flags = self.instances.flags if thin is None else self.instances.flags | np.where(thin, HIDDEN, 0).astype(np.uint8)
        return flags if blocking is None else flags | np.where(blocking, 0, NO_SHADOW).astype(np.uint8)

    def blocking(self) -> np.ndarray | None:
        """(I,) bool: the rows that stop light, where all or nothing is asked: those that let through less than half of it; None: all."""
        casting = self.instances.without(NO_SHADOW)
        if self.shines_through is None:
            return casting
        stops = ~self.shines_through | (self.looks[self.instances.look][:, LIGHT_BEHIND].mean(axis=1) < 0.5)
        return stops if casting is None else stops & casting

    def _passing(self, columns: slice) -> np.ndarray | None:
        """Rows whose look lets something through; holdouts, catchers, caps and the ground are whole, whatever their material."""
        if not self.looks[:, columns].any():
            return None
        whole = (self.instances.flags & (HOLDOUT | CATCHER | GROUND | CAP)) != 0
        passing = self.looks[self.instances.look][:, columns].any(axis=1) & ~whole
        return passing if passing.any() else None

    def caster_bounds_ws(self) -> np.ndarray:
        """(C, 2, 3) bounds of the instances that cast shadows; of all where none does."""
        casting = self.instances.without(NO_SHADOW)
        return self._instance_bounds_ws if casting is None or not casting.any() else self._instance_bounds_ws[casting]

    def bounds_ws(self) -> np.ndarray:
        """(2, 3) float64 bounds of everything; raises `SceneError` when there is nothing."""
        if not len(self.instances):
            raise SceneError(
                "There is nothing to draw: the scene holds no visible mesh. Add one, or make a hidden one visible to the render."
            )
        b = self.instance_bounds_ws()
        return np.stack([b[:, 0].min(axis=0), b[:, 1].max(axis=0)])
