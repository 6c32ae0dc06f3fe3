"""The scene as one soup of world triangles, with what a ray needs to know about each. No instancing: memory is 100 bytes a triangle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...scene.records import Scene

FLOAT32_EPSILON = float(np.finfo(np.float32).eps)


@dataclass(frozen=True, eq=False)
class WorldTriangles:
    """T triangles, world coordinates relative to the scene's local origin.

    `corners` (T, 3, 3) float64; `normal` (T, 3) unit geometric normal by the winding; `object_id` (T,) int32; `flags` (T,) uint8 of
    `scene.looks`; `noise` (T,) metres: within this distance, measured along the normal, another surface is the same surface. The ray
    tracers hold float32 corners, which are off by half a unit in the last place of the largest coordinate; four such steps of the
    triangle's own corners plus half a step of the farthest corner of the scene (a small plate may lie on a huge floor) cover both
    surfaces and the ray.
    """

    corners: np.ndarray
    normal: np.ndarray
    object_id: np.ndarray
    noise: np.ndarray
    flags: np.ndarray

    @cached_property
    def reach(self) -> float:
        """Metres: an upper bound of the distance between any two points of the scene."""
        return float(np.linalg.norm(np.ptp(self.corners.reshape(-1, 3), axis=0))) if len(self.corners) else 0.0


def world_triangles(scene: Scene) -> WorldTriangles:
    """All triangles of all instances; those without area in world space are left out (no ray can hit them)."""
    scene.bounds_ws()  # raises SceneError when there is nothing
    pieces, ids, flags = [], [], []
    placed = scene.instances
    for index, matrix, object_id, flag in zip(placed.mesh_index, placed.world_from_object, placed.object_id, placed.flags, strict=True):
        mesh = scene.meshes[index]
        positions = mesh.positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        pieces.append(positions[mesh.triangles])
        ids.append(np.full(len(mesh.triangles), object_id, dtype=np.int32))
        flags.append(np.full(len(mesh.triangles), flag, dtype=np.uint8))
    corners, object_id, flags = np.concatenate(pieces), np.concatenate(ids), np.concatenate(flags)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_area = np.sqrt(np.einsum("ij,ij->i", cross, cross))
    keep = doubled_area > 0.0
    corners, object_id, cross, doubled_area, flags = corners[keep], object_id[keep], cross[keep], doubled_area[keep], flags[keep]
    largest = np.abs(corners).max(axis=(1, 2), initial=0.0)
    noise = FLOAT32_EPSILON * (4.0 * largest + 0.5 * largest.max(initial=0.0))
    return WorldTriangles(corners, cross / doubled_area[:, None], object_id, noise, flags)
