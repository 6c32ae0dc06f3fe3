"""The faces of a scene's mesh objects as places on them, and numbers of faces kept as attributes of their meshes. Main thread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from ..maths.directions import places_on, square_points, triangle_points

PLACES, MOST_A_TRIANGLE = 50_000, 16
SHARED = "'{}' shares its mesh with other objects: make it a single user (Object > Relations) to keep its faces' values."
CHANGED = "'{}' has modifiers that change its faces: apply them to keep its faces' values."
EDITED = "'{}' is being edited: leave Edit Mode to keep its faces' values."


@dataclass(frozen=True, eq=False)
class ObjectFaces:
    """An object by `name` with `count` faces, and places on them in the true world (P, 3): on face `face` (P,), each for `area` m² (P,)."""

    name: str
    count: int
    points: np.ndarray
    normals: np.ndarray
    face: np.ndarray
    area: np.ndarray

    def means(self, values: np.ndarray) -> np.ndarray:
        """(faces,) float32 means over the area of values (P,) at the places; 0 for a face without area."""
        total = np.bincount(self.face, self.area * values, minlength=self.count)
        area = np.bincount(self.face, self.area, minlength=self.count)
        return np.divide(total, area, out=np.zeros(self.count), where=area > 0.0).astype(np.float32)


def faces_of(objects: Sequence[bpy.types.Object], depsgraph: bpy.types.Depsgraph) -> tuple[list[ObjectFaces], list[str]]:
    """The faces of all mesh objects that can keep values, and a line for each that cannot. Hidden ones are passed over."""
    kept, complaints = [], []
    for ob in objects:
        if ob.type != "MESH" or not ob.visible_get() or not len(ob.data.polygons):
            continue
        mesh = ob.evaluated_get(depsgraph).data
        if ob.mode == "EDIT":
            complaints.append(EDITED.format(ob.name))
        elif ob.data.users > 1:
            complaints.append(SHARED.format(ob.name))
        elif len(mesh.polygons) != len(ob.data.polygons):
            complaints.append(CHANGED.format(ob.name))
        else:
            kept.append((ob, mesh))
    read = [_triangles(ob, mesh) for ob, mesh in kept]
    total = sum(float(area.sum()) for _, _, area in read)
    return [_placed(ob.name, len(ob.data.polygons), *one, total) for (ob, _), one in zip(kept, read, strict=True)], complaints


def _triangles(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners (T, 3, 3) in the world, faces (T,) and areas (T,) of the triangles of an evaluated mesh, those without area left out."""
    positions = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", positions.ravel())
    mesh.calc_loop_triangles()
    corners, face = np.empty((len(mesh.loop_triangles), 3), np.int32), np.empty(len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners.ravel())
    mesh.loop_triangles.foreach_get("polygon_index", face)
    matrix = np.array(ob.matrix_world, np.float64)
    world = (positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])[corners]
    area = 0.5 * np.linalg.norm(np.cross(world[:, 1] - world[:, 0], world[:, 2] - world[:, 0]), axis=1)
    real = area > 0.0
    return world[real], face[real], area[real]


def _placed(name: str, count: int, corners: np.ndarray, face: np.ndarray, area: np.ndarray, total: float) -> ObjectFaces:
    """At least one place on every triangle, more on large ones."""
    share = np.ceil(area * (PLACES / total)) if total > 0.0 else np.ones(len(area))
    times = np.clip(share, 1, MOST_A_TRIANGLE).astype(np.int64)
    chosen = np.repeat(np.arange(len(area)), times)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / (2.0 * area[:, None])
    weights = np.where((times == 1)[chosen, None], 1.0 / 3.0, triangle_points(square_points(len(chosen))))
    return ObjectFaces(name, count, places_on(corners[chosen], weights), normals[chosen], face[chosen], (area / times)[chosen])


def keep(faces: ObjectFaces, attribute: str, values: np.ndarray) -> bool:
    """Write numbers (faces,) as the attribute of an object's mesh; False where the object is gone or has other faces by now."""
    ob = bpy.data.objects.get(faces.name)
    if ob is None or ob.type != "MESH" or ob.mode == "EDIT" or len(ob.data.polygons) != faces.count:
        return False
    old = ob.data.attributes.get(attribute)
    if old is not None and (old.domain != "FACE" or old.data_type != "FLOAT"):
        ob.data.attributes.remove(old)
        old = None
    layer = old or ob.data.attributes.new(attribute, "FLOAT", "FACE")
    layer.data.foreach_set("value", values)
    ob.data.update()
    return True
