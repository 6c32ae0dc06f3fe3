"""An evaluated mesh as arrays, in a few `foreach_get` calls.

Attributes are read with their exact type: Blender then copies memory; any other type is converted element by element (100 × slower).
"""

from __future__ import annotations

from math import pi

import bpy
import numpy as np

from ...scene.cad_model import CREASED
from ...scene.mesh_pieces import RawMesh
from .varied import Sources, tinted


def read_object(ob: bpy.types.Object, sources: Sources = ()) -> RawMesh | None:
    """The arrays of an evaluated mesh object; None when it has no face. In edit mode Blender makes them on demand.

    `sources` are the colours of its materials that vary over it."""
    if ob.mode != "EDIT":
        return read_mesh(ob.data, is_creased(ob), sources)
    try:
        return read_mesh(ob.to_mesh(), is_creased(ob), sources)
    finally:
        ob.to_mesh_clear()


def is_creased(ob: bpy.types.Object) -> bool:
    """Whether an object's mesh comes from a CAD file without normals."""
    data = ob.original.data
    return isinstance(data, bpy.types.Mesh) and bool(data.get(CREASED))


def read_mesh(mesh: bpy.types.Mesh, is_creased: bool = False, sources: Sources = ()) -> RawMesh | None:
    """The arrays of an evaluated mesh; None when it has no face.

    It is flat and smooth where its author says so. `is_creased`: it comes from a CAD file that says nothing of it; as long as it is flat
    all over the crease angle decides.
    """
    corners, faces = len(mesh.loops), len(mesh.polygons)
    if not faces or not len(mesh.vertices):
        return None
    positions = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", positions.reshape(-1))
    vertex = np.empty(corners, dtype=np.int32)
    mesh.attributes[".corner_vert"].data.foreach_get("value", vertex)
    loops, face = _triangulation(mesh, corners, faces)
    triangles = vertex.reshape(-1, 3) if loops is None else vertex[loops]
    raw = RawMesh(positions, triangles, _slots(mesh, face), *_shading(mesh, loops, triangles, is_creased))
    return tinted(mesh, sources, raw, vertex, loops) if sources else raw


def _shading(
    mesh: bpy.types.Mesh, loops: np.ndarray | None, triangles: np.ndarray, is_creased: bool
) -> tuple[np.ndarray | None, float | None]:
    """The corner normals (T, 3, 3), if the mesh has such, and its own crease angle."""
    domain = "CORNER" if mesh.has_custom_normals or _has_sharp_edges(mesh) else mesh.normals_domain
    if domain == "FACE":
        return None, None if is_creased else 0.0
    if domain == "POINT":
        normals = np.empty((len(mesh.vertices), 3), dtype=np.float32)
        mesh.vertex_normals.foreach_get("vector", normals.reshape(-1))
        return normals[triangles], pi
    normals = np.empty((len(mesh.loops), 3), dtype=np.float32)
    mesh.corner_normals.foreach_get("vector", normals.reshape(-1))
    return normals.reshape(-1, 3, 3) if loops is None else normals[loops], pi


def _has_sharp_edges(mesh: bpy.types.Mesh) -> bool:
    attribute = mesh.attributes.get("sharp_edge")
    if attribute is None or attribute.domain != "EDGE" or attribute.data_type != "BOOLEAN":
        return False
    sharp = np.empty(len(mesh.edges), dtype=bool)
    attribute.data.foreach_get("value", sharp)
    return bool(sharp.any())


def _triangulation(mesh: bpy.types.Mesh, corners: int, faces: int) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Corners (T, 3) and face (T,) of each triangle; None, None when every face already is a triangle."""
    if corners == 3 * faces:
        return None, None
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    loops, face = np.empty((count, 3), dtype=np.int32), np.empty(count, dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", loops.reshape(-1))
    mesh.loop_triangle_polygons.foreach_get("value", face)
    return loops, face


def _slots(mesh: bpy.types.Mesh, face: np.ndarray | None) -> np.ndarray | None:
    attribute = mesh.attributes.get("material_index")
    if attribute is None or attribute.domain != "FACE" or attribute.data_type != "INT":
        return None
    index = np.empty(len(mesh.polygons), dtype=np.int32)
    attribute.data.foreach_get("value", index)
    return np.maximum(index if face is None else index[face], 0) if index.any() else None
