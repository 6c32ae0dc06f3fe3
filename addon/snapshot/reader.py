"""`SceneReader`: an evaluated depsgraph to a `Scene`, with what did not change taken from the last read.

It keeps arrays and numbers between calls, never a reference to Blender's data. Two facts carry the cache:
- Blender makes a new evaluated mesh, with a `session_uid` never used before, each time it evaluates a geometry. The number seen at the
  last read proves the mesh unchanged; nothing of it is fetched. (Checked on 4.5 and 5.2. Sculpting and editing may write in place: an
  object in such a mode is always fetched, and so is a mesh that turns out not to be an evaluated copy.)
- The content of a mesh is named by a digest of its arrays, so equal content keeps its `Mesh.key` over re-evaluation, undo and renders.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, log2

import bpy
import numpy as np

from ..errors import SceneError
from ..maths.view import Camera, Light
from ..pipeline.mesh_pieces import Prepared, RawMesh, prepare_all
from ..pipeline.mesh_prep import DEFAULT_CREASE_RAD, Defects
from ..pipeline.scene import Instances, Mesh, Scene
from .cameras import camera_from_object
from .instances import InstanceLoop, Rows, listed
from .marks import mark_reader
from .meshes import read_object

ContentKey = tuple[bytes, float]


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
        self._known: dict[tuple[int, float], ContentKey | None] = {}

    def read(
        self,
        depsgraph: bpy.types.Depsgraph,
        *,
        size: tuple[int, int] = (1280, 720),
        crease_angle_rad: float = DEFAULT_CREASE_RAD,
        use_object_color: bool = False,
        space: bpy.types.SpaceView3D | None = None,
    ) -> Scene:
        """The scene as the depsgraph shows it. Cameras are made for `size` = (width, height) pixels, the active one first.

        `space` restricts it to what that 3D viewport shows (local view, hidden collections). An empty scene is a `Scene` without
        instances; `Scene.bounds_ws` says so. What could not be drawn is named in `warnings`.
        """
        collected = self.collect(depsgraph, crease_angle_rad=crease_angle_rad, use_object_color=use_object_color, space=space)
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
    ) -> Collected:
        """The first half of `read`, all that needs Blender: arrays and numbers, the new meshes as yet without their normals."""
        session = _Session(self, crease_angle_rad)
        return Collected(session, InstanceLoop(depsgraph, session.content_of, use_object_color, space, mark_reader()).run())

    def take(self, collected: Collected) -> None:
        """Keep what a finished `Collected` has made for the reads that follow."""
        session = collected.session
        self._content, self._known, self.counts = session.content, session.known, session.counts

    def clear(self) -> None:
        """Drop the cache."""
        self._content, self._known = {}, {}


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
        meshes, instances = _instances(rows, session.content)
        scene = Scene(meshes, instances, tuple(rows.names), np.zeros(3))
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
        )


class _Session:
    """One read: meshes prepared or taken from the reader's cache; the new cache holds only what this read used."""

    def __init__(self, reader: SceneReader, crease_angle_rad: float) -> None:
        self.old_content, self.old_known = reader._content, reader._known
        self.crease = float(crease_angle_rad)
        self.content: dict[ContentKey, Prepared] = {}
        self.known: dict[tuple[int, float], ContentKey | None] = {}
        self.counts = ReadCounts()
        self.pending: dict[ContentKey, RawMesh] = {}
        self.name_of: dict[ContentKey, str] = {}

    def content_of(self, ob: bpy.types.Object) -> ContentKey | None:
        """The key of an evaluated object's mesh; None if it has no face. Called once for each mesh."""
        mesh = ob.data
        number = (mesh.session_uid, self.crease)
        is_copy = mesh.original is None or mesh.original.as_pointer() == mesh.as_pointer()
        if number in self.old_known and is_copy and ob.mode == "OBJECT":
            key = self.old_known[number]
        else:
            key = self._fetch(ob)
        self.known[number] = key
        if key is not None:
            self.name_of.setdefault(key, ob.name)
            if key in self.old_content:
                self.content[key] = self.old_content[key]
        return key

    def _fetch(self, ob: bpy.types.Object) -> ContentKey | None:
        self.counts.fetched += 1
        raw = read_object(ob)
        if raw is None:
            return None
        key = (raw.digest(), self.crease)
        if key not in self.old_content:
            self.pending[key] = raw
        return key

    def prepare_pending(self) -> None:
        """Make all new meshes drawable, together."""
        keys = list(self.pending)
        self.counts.prepared = len(keys)
        self.content.update(zip(keys, prepare_all(list(self.pending.values()), keys, self.crease), strict=True))

    def is_drawable(self, rows: Rows) -> np.ndarray:
        """(rows,) bool: something of the mesh is left to draw."""
        of_kind = np.array([bool(self.content[k.content].meshes) for k in rows.kinds], dtype=bool)
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


def _instances(rows: Rows, content: dict[ContentKey, Prepared]) -> tuple[tuple[Mesh, ...], Instances]:
    """Rows times their material slots. Equal content from several datablocks becomes one mesh."""
    meshes: list[Mesh] = []
    first_of: dict[object, int] = {}
    slots, mesh_of, colors, counts, offsets = [], [], [], [], []
    for kind in rows.kinds:
        prepared = content[kind.content]
        counts.append(len(prepared.slots))
        offsets.append(prepared.offset_os)
        first = first_of.setdefault(kind.content, len(meshes))
        if first == len(meshes):
            meshes.extend(prepared.meshes)
        mesh_of.extend(range(first, first + len(prepared.slots)))
        slots.extend(prepared.slots)
        colors.extend(kind.color(slot) for slot in prepared.slots)
    return tuple(meshes), _expanded(
        rows,
        np.array(counts, dtype=np.int64),
        np.array(offsets).reshape(-1, 3),
        np.array(mesh_of, dtype=np.int32),
        np.array(slots, dtype=np.int32),
        np.array(colors, dtype=np.float32).reshape(-1, 4),
    )


def _expanded(rows: Rows, counts: np.ndarray, offsets: np.ndarray, mesh_of: np.ndarray, slots: np.ndarray, colors: np.ndarray) -> Instances:
    kind = np.array(rows.kind, dtype=np.int64)
    per_row = counts[kind]
    object_id = np.repeat(np.arange(len(kind)), per_row)
    first = np.concatenate([[0], np.cumsum(counts)])[:-1][kind] if len(kind) else np.empty(0, dtype=np.int64)
    entry = np.arange(len(object_id)) - np.repeat(np.cumsum(per_row) - per_row, per_row) + np.repeat(first, per_row)
    matrices = rows.matrices.copy()
    matrices[:, :3, 3] += np.einsum("nij,nj->ni", matrices[:, :3, :3], offsets[kind])
    return Instances(mesh_of[entry], matrices[object_id], object_id, slots[entry], colors[entry])


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
