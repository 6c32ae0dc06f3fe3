"""An evaluated mesh as arrays, in a few `foreach_get` calls, and its meshes ready to draw.

Attributes are read with their exact type: Blender then copies memory; any other type is converted element by element (100 × slower).
"""

from __future__ import annotations

import hashlib
from collections.abc import Hashable
from dataclasses import dataclass

import bpy
import numpy as np

from ..pipeline.mesh_prep import Defects, Shaded, drawable, shade_by_corners, shade_by_crease
from ..pipeline.scene import Mesh

FAR = 4.0


@dataclass(frozen=True, eq=False)
class RawMesh:
    """`positions` (V, 3) float32, `triangles` (T, 3) int32, `slots` (T,) int32 or None (all 0), `corner_normals` (T, 3, 3) float32 or None."""

    positions: np.ndarray
    triangles: np.ndarray
    slots: np.ndarray | None
    corner_normals: np.ndarray | None

    def digest(self) -> bytes:
        """16 bytes that name the content."""
        digest = hashlib.blake2b(digest_size=16)
        for array in (self.positions, self.triangles, self.slots, self.corner_normals):
            digest.update(b"-" if array is None else np.ascontiguousarray(array).data)
        return digest.digest()


@dataclass(frozen=True, eq=False)
class Prepared:
    """Drawable meshes, one per material slot used (`slots` says which), relative to `offset_os` (3,) float64; and what was left out."""

    meshes: tuple[Mesh, ...]
    slots: tuple[int, ...]
    offset_os: np.ndarray
    defects: Defects


def read_mesh(mesh: bpy.types.Mesh) -> RawMesh | None:
    """The arrays of an evaluated mesh; None when it has no face.

    Corner normals are read only where they hold something the triangles do not: custom normals, or sharp edges and faces that its author
    marked. Meshes that are smooth or flat all over get the crease angle instead.
    """
    corners, faces = len(mesh.loops), len(mesh.polygons)
    if not faces or not len(mesh.vertices):
        return None
    positions = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", positions.reshape(-1))
    vertex = np.empty(corners, dtype=np.int32)
    mesh.attributes[".corner_vert"].data.foreach_get("value", vertex)
    loops, face = _triangulation(mesh, corners, faces)
    slots = _slots(mesh, face)
    normals = None
    if mesh.has_custom_normals or mesh.normals_domain == "CORNER":
        normals = np.empty((corners, 3), dtype=np.float32)
        mesh.corner_normals.foreach_get("vector", normals.reshape(-1))
        normals = normals.reshape(-1, 3, 3) if loops is None else normals[loops]
    return RawMesh(positions, vertex.reshape(-1, 3) if loops is None else vertex[loops], slots, normals)


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


def prepare(raw: RawMesh, key: Hashable, crease_angle_rad: float) -> Prepared:
    """Claim: bad triangles left out, normals made, one mesh per slot, positions relative to a local offset where the mesh lies far
    from its own origin (more than `FAR` times its size), so that float32 on the GPU keeps all that the file had.
    """
    keep, defects = drawable(raw.positions, raw.triangles)
    if not keep.any():
        return Prepared((), (), np.zeros(3), defects)
    positions, triangles, slots, normals = raw.positions, raw.triangles, raw.slots, raw.corner_normals
    if not keep.all() or defects.bad_vertices:
        positions = np.where(np.isfinite(positions), positions, np.float32(0.0))
        triangles, slots, normals = triangles[keep], _taken(slots, keep), _taken(normals, keep)
    positions, offset = _centred(positions, triangles)
    if normals is None or not _is_unit(normals):
        shaded = shade_by_crease(positions, triangles, crease_angle_rad)
    else:
        shaded = shade_by_corners(positions, triangles, normals)
    present = (0,) if slots is None else tuple(int(s) for s in np.flatnonzero(np.bincount(slots)))
    return Prepared(tuple(_mesh(shaded, slots, slot, len(present), key) for slot in present), present, offset, defects)


def _taken(array: np.ndarray | None, keep: np.ndarray) -> np.ndarray | None:
    return None if array is None else array[keep]


def _is_unit(normals: np.ndarray) -> bool:
    flat = normals.reshape(-1, 3)
    return bool((np.abs(np.einsum("ij,ij->i", flat, flat) - 1.0) < 1e-2).all())


def _centred(positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    used = np.zeros(len(positions), dtype=bool)
    used[triangles.ravel()] = True
    points = positions if used.all() else positions[used]
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    centre = (low + high) / 2
    if np.abs(centre).max() <= FAR * (high - low).max():
        return positions, np.zeros(3)
    return (positions.astype(np.float64) - centre).astype(np.float32), centre


def _mesh(shaded: Shaded, slots: np.ndarray | None, slot: int, slot_count: int, key: Hashable) -> Mesh:
    part = shaded if slot_count == 1 or slots is None else shaded.part(slots == slot)
    return Mesh((key, slot), part.positions, part.normals, part.triangles)
