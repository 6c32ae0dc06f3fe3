"""`SceneReader`: an evaluated depsgraph to a `Scene`, with what did not change taken from the last read.

It keeps arrays and numbers between calls, never a reference to Blender's data. Two facts carry the cache:
- Blender makes a new evaluated mesh, with a `session_uid` never used before, each time it evaluates a geometry. The number seen at the
  last read proves the mesh unchanged; nothing of it is fetched. (Checked on 4.5 and 5.2. Sculpting and editing may write in place: an
  object in such a mode is always fetched, and so is a mesh that turns out not to be an evaluated copy.)
- The content of a mesh is named by a digest of its arrays, so equal content keeps its `Mesh.key` over re-evaluation, undo and renders.

Blender's part, fetching arrays, can be taken in slices (`collect(seconds=…)`), so that a window waits for none of them; the rest, digests
and normals, is `Collected.scene`, on any thread.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, inf, log2

import bpy
import numpy as np

from ...errors import SceneError
from ...maths.view import Camera, Light
from ...scene.looks import PLAIN, Look
from ...scene.memory import give_back
from ...scene.mesh_pieces import Prepared, RawMesh, prepare_all
from ...scene.mesh_prep import DEFAULT_CREASE_RAD, Defects
from ...scene.records import Instances, Mesh, Scene
from .cameras import camera_from_object
from .instances import InstanceLoop, Rows, listed
from .marks import mark_reader
from .meshes import read_object
from .varied import Source, Sources, slot_and_color, sources_of

ContentKey = tuple[bytes, float]
Number = tuple[int, float, tuple]  # an evaluated mesh's session_uid, the crease angle, and where its materials' varying colours come from
MUCH = 1 << 18  # triangles made drawable after which memory is given back


@dataclass(slots=True)
class ReadCounts:
    """What the last read did: meshes whose arrays were fetched, meshes whose normals were made."""

    fetched: int = 0
    prepared: int = 0


class SceneReader:
    """Reads scenes. One per add-on (viewport, preview, renders may share it); main thread only, like all of bpy."""

    def __init__(self) -> None:
        self.counts = ReadCounts()
        self._content: dict[ContentKey, Prepared] = {}
        self._known: dict[Number, ContentKey | None] = {}
        self._fetched: dict[Number, RawMesh | None] = {}  # of a collection that is not complete yet

    def read(
        self,
        depsgraph: bpy.types.Depsgraph,
        *,
        size: tuple[int, int] = (1280, 720),
        crease_angle_rad: float = DEFAULT_CREASE_RAD,
        use_object_color: bool = False,
        space: bpy.types.SpaceView3D | None = None,
        marked: Sequence[bpy.types.ID] | None = None,
    ) -> Scene:
        """The scene as the depsgraph shows it. Cameras are made for `size` = (width, height) pixels, the active one first.

        `space` restricts it to what that 3D viewport shows (local view, hidden collections). An empty scene is a `Scene` without
        instances; `Scene.bounds_ws` says so. What could not be drawn is named in `warnings`. `marked` are the impostors' objects and
        collections instead of those that the file marks.
        """
        collected = self.collect(
            depsgraph, crease_angle_rad=crease_angle_rad, use_object_color=use_object_color, space=space, marked=marked
        )
        scene = collected.scene()
        self.take(collected)
        cameras, complaints = _cameras(collected.rows, depsgraph, size, scene.origin_ws)
        return replace(scene, cameras=cameras, warnings=(*scene.warnings, *complaints))

    def collect(
        self,
        depsgraph: bpy.types.Depsgraph,
        *,
        crease_angle_rad: float = DEFAULT_CREASE_RAD,
        use_object_color: bool = False,
        space: bpy.types.SpaceView3D | None = None,
        seconds: float = inf,
        marked: Sequence[bpy.types.ID] | None = None,
    ) -> Collected | None:
        """The first half of `read`, all that needs Blender: arrays and numbers, the new meshes as yet without names and normals.

        None when the new meshes take longer than `seconds`: those fetched by then are kept, so calling it again goes on.
        """
        session = _Session(self, crease_angle_rad, time.perf_counter() + seconds)
        try:
            rows = InstanceLoop(depsgraph, session.number_of, use_object_color, space, mark_reader(marked)).run()
        except _TimeIsUp:
            self._fetched = session.fetched
            return None
        self._fetched = {}
        return Collected(session, rows)

    def take(self, collected: Collected) -> None:
        """Keep what a finished `Collected` has made for the reads that follow."""
        session = collected.session
        self._content, self._known, self.counts = session.content, session.known, session.counts

    def clear(self) -> None:
        """Drop the cache."""
        self._content, self._known, self._fetched = {}, {}, {}


@dataclass(eq=False)
class Collected:
    """What Blender had to tell of a scene. `scene` may be called on any thread, once; it takes the time that new meshes need."""

    session: _Session
    rows: Rows

    def scene(self) -> Scene:
        """The scene without cameras, the new meshes made drawable."""
        session, rows = self.session, self.rows
        session.prepare_pending()
        rows.keep(session.is_drawable(rows))
        meshes, instances, looks, materials = _instances(rows, session.content, session.known)
        scene = Scene(meshes, instances, tuple(rows.names), np.zeros(3), looks=looks, materials=materials)
        origin = local_origin(scene.bounds_ws()) if len(instances) else np.zeros(3)
        moved = np.array(instances.world_from_object)
        moved[:, :3, 3] -= origin
        return replace(
            scene,
            instances=replace(instances, world_from_object=moved),
            origin_ws=origin,
            lights=tuple(_moved(light, origin) for light in rows.lights),
            warnings=(*rows.warnings, *session.warnings()),
            marks=tuple(rows.marks),
            object_index=np.array(rows.indices, dtype=np.int32) if rows.indices else None,
            mist=rows.mist,
            links={name: tuple(one.left_out(rows.names) for one in both) for name, both in rows.links.items()},
        )


class _TimeIsUp(Exception):
    """There are more meshes to fetch than the time allows."""


class _Session:
    """One read: meshes fetched or taken from the reader's cache; the new cache holds only what this read used."""

    def __init__(self, reader: SceneReader, crease_angle_rad: float, deadline: float) -> None:
        self.old_content, self.old_known, self.old_fetched = reader._content, reader._known, reader._fetched
        self.crease, self.deadline = float(crease_angle_rad), deadline
        self.content: dict[ContentKey, Prepared] = {}
        self.known: dict[Number, ContentKey | None] = {}
        self.fetched: dict[Number, RawMesh | None] = {}
        self.counts, self.has_fetched = ReadCounts(), False
        self.first_name: dict[Number, str] = {}
        self.name_of: dict[ContentKey, str] = {}
        self.sources: dict[int, Source | None] = {}

    def number_of(self, ob: bpy.types.Object) -> Number | None:
        """The number of an evaluated object's mesh; None if it has no face. Called once for each mesh. Raises `_TimeIsUp`."""
        mesh = ob.data
        sources = sources_of(mesh, self.sources)
        number = (mesh.session_uid, self.crease, tuple((slot, source.key()) for slot, source in sources))
        is_copy = mesh.original is None or mesh.original.as_pointer() == mesh.as_pointer()
        is_steady = is_copy and ob.mode == "OBJECT"
        if is_steady and number in self.old_known:
            self.known[number] = key = self.old_known[number]
            has_faces = key is not None
        else:
            has_faces = self._fetch(ob, number, is_steady, sources) is not None
        if has_faces:
            self.first_name[number] = ob.name
        return number if has_faces else None

    def _fetch(self, ob: bpy.types.Object, number: Number, is_steady: bool, sources: Sources) -> RawMesh | None:
        """The mesh's arrays, as fetched by an earlier slice or now. The first of a slice is fetched even when the time is up."""
        if is_steady and number in self.old_fetched:
            raw = self.old_fetched[number]
        else:
            if is_steady and self.has_fetched and time.perf_counter() > self.deadline:
                self.fetched = {**self.old_fetched, **self.fetched}
                raise _TimeIsUp
            raw = read_object(ob, sources)
            self.has_fetched |= is_steady
        self.fetched[number] = raw
        return raw

    def prepare_pending(self) -> None:
        """Name the meshes fetched by their content, and make all that is new drawable, together."""
        self.known |= {number: raw and (raw.digest(), self.crease) for number, raw in self.fetched.items()}
        pending: dict[ContentKey, RawMesh] = {}
        for number, key in self.known.items():
            if key is None:
                continue
            self.name_of.setdefault(key, self.first_name[number])
            if key in self.old_content:
                self.content[key] = self.old_content[key]
            else:
                pending[key] = self.fetched[number]
        self.counts = ReadCounts(len(self.fetched), len(pending))
        self.content.update(zip(pending, prepare_all(list(pending.values()), list(pending), self.crease), strict=True))
        self.fetched, self.old_fetched = {}, {}
        is_much = sum(len(raw.triangles) for raw in pending.values()) > MUCH
        pending.clear()
        if is_much:
            give_back()

    def is_drawable(self, rows: Rows) -> np.ndarray:
        """(rows,) bool: something of the mesh is left to draw."""
        of_kind = np.array([bool(self.content[self.known[k.number]].meshes) for k in rows.kinds], dtype=bool)
        return of_kind[np.array(rows.kind, dtype=np.int64)]

    def warnings(self) -> list[str]:
        """Defects, by name while they are few; objects with nothing left are named apart."""
        lines = []
        defective = {self.name_of[key]: p.defects for key, p in self.content.items() if p.defects}
        if len(defective) <= 3:
            lines += [defects.sentence(f"'{name}'") for name, defects in defective.items()]
        else:
            lines.append(sum(defective.values(), Defects()).sentence(f"{len(defective)} objects"))
        hopeless = [self.name_of[key] for key, p in self.content.items() if not p.meshes]
        if hopeless:
            lines.append(f"Not drawn, no face of theirs has finite corners and an area: {listed(hopeless)}.")
        return lines


def local_origin(bounds_ws: np.ndarray) -> np.ndarray:
    """(3,) the centre of (2, 3) bounds rounded to a power of two not below their largest side, so that a scene near its origin keeps
    it, and a scene that grows a little keeps the one it had."""
    largest = float((bounds_ws[1] - bounds_ws[0]).max())
    step = 2.0 ** ceil(log2(max(largest, 1e-6)))
    return np.round(bounds_ws.mean(axis=0) / step) * step + 0.0


def _instances(
    rows: Rows, content: dict[ContentKey, Prepared], known: dict[Number, ContentKey | None]
) -> tuple[tuple[Mesh, ...], Instances, np.ndarray, tuple[tuple[str, int], ...]]:
    """Rows times their material slots that are surfaces, the looks and the materials' names.

    Equal content from several datablocks becomes one mesh.
    """
    meshes: list[Mesh] = []
    first_of: dict[object, int] = {}
    slots, mesh_of, colors, counts, offsets, looks, materials = [], [], [], [], [], [], []
    look_of: dict[Look, int] = {}
    material_of: dict[tuple[str, int], int] = {}
    for kind in rows.kinds:
        key = known[kind.number]
        prepared = content[key]
        offsets.append(prepared.offset_os)
        first = first_of.setdefault(key, len(meshes))
        if first == len(meshes):
            meshes.extend(prepared.meshes)
        solid = [i for i, slot in enumerate(prepared.slots) if kind.paint(slot).is_solid]
        counts.append(len(solid))
        mesh_of.extend(first + i for i in solid)
        slots.extend(slot_and_color(prepared.slots[i])[0] for i in solid)
        paints = [kind.paint(prepared.slots[i]) for i in solid]
        colors.extend(paint.color for paint in paints)
        looks.extend(look_of.setdefault(paint.look, len(look_of)) for paint in paints)
        materials.extend(material_of.setdefault((paint.name, paint.index), len(material_of)) for paint in paints)
    of_entry = Entries(
        np.array(mesh_of, dtype=np.int32),
        np.array(slots, dtype=np.int32),
        np.array(colors, dtype=np.float32).reshape(-1, 4),
        np.array(looks, dtype=np.int32),
        np.array(materials, dtype=np.int32),
    )
    numbers = np.array([look.numbers() for look in look_of or (PLAIN,)])
    return (
        tuple(meshes),
        _expanded(rows, np.array(counts, dtype=np.int64), np.array(offsets).reshape(-1, 3), of_entry),
        numbers,
        tuple(material_of) or (("", 0),),
    )


@dataclass(frozen=True, eq=False)
class Entries:
    """One for each kind and material slot: its mesh, slot, colour, look and material."""

    meshes: np.ndarray
    slots: np.ndarray
    colors: np.ndarray
    looks: np.ndarray
    materials: np.ndarray


def _expanded(rows: Rows, counts: np.ndarray, offsets: np.ndarray, of: Entries) -> Instances:
    kind = np.array(rows.kind, dtype=np.int64)
    per_row = counts[kind]
    object_id = np.repeat(np.arange(len(kind)), per_row)
    first = np.concatenate([[0], np.cumsum(counts)])[:-1][kind] if len(kind) else np.empty(0, dtype=np.int64)
    entry = np.arange(len(object_id)) - np.repeat(np.cumsum(per_row) - per_row, per_row) + np.repeat(first, per_row)
    matrices = rows.matrices.copy()
    matrices[:, :3, 3] += np.einsum("nij,nj->ni", matrices[:, :3, :3], offsets[kind])
    flags = np.array(rows.flags, dtype=np.uint8)[object_id] if rows.flags else np.zeros(len(entry), np.uint8)
    return Instances(
        of.meshes[entry], matrices[object_id], object_id, of.slots[entry], of.colors[entry], of.looks[entry], flags, of.materials[entry]
    )


def _cameras(rows: Rows, depsgraph: bpy.types.Depsgraph, size: tuple[int, int], origin: np.ndarray) -> tuple[tuple[Camera, ...], list[str]]:
    """Every camera that can be used, the scene's active one first; the others' complaints."""
    objects = {ob.name: ob for ob in rows.cameras}
    active = depsgraph.scene.camera
    if active is not None and active.type == "CAMERA":
        objects = {active.name: active.original, **objects}
    cameras, complaints = [], []
    for ob in objects.values():
        try:
            cameras.append(camera_from_object(ob.evaluated_get(depsgraph), depsgraph, size, origin))
        except (SceneError, ValueError) as error:
            complaints.append(str(error))
    return tuple(cameras), complaints


def _moved(light: Light, origin: np.ndarray) -> Light:
    return light if light.position_ws is None else replace(light, position_ws=light.position_ws - origin)
