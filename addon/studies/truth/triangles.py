"""The scene as one soup of world triangles, with what a ray needs to know about each. No instancing: memory is 100 bytes a triangle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...maths.anchored_camera import LARGE
from ...scene.records import Scene

FLOAT32_EPSILON = float(np.finfo(np.float32).eps)
MOST_LARGE = 64
"""How many triangles of a scene are met in float64."""


@dataclass(frozen=True, eq=False)
class WorldTriangles:
    """T triangles, world coordinates relative to the scene's local origin.

    `corners` (T, 3, 3) float64; `normal` (T, 3) unit geometric normal by the winding; `object_id` (T,) int32; `flags` (T,) uint8 of
    `scene.looks`, whole or nothing. `anchor_ws` (3,): the ray tracers hold the corners about it, in float32.
    """

    corners: np.ndarray
    normal: np.ndarray
    object_id: np.ndarray
    flags: np.ndarray
    anchor_ws: np.ndarray

    @cached_property
    def reach(self) -> float:
        """Metres: an upper bound of the distance between any two points of the scene."""
        return float(np.linalg.norm(np.ptp(self.corners.reshape(-1, 3), axis=0))) if len(self.corners) else 0.0

    def large(self) -> np.ndarray:
        """(L,) rows of the triangles whose box reaches more than `LARGE` times as far from the anchor as it is away, the largest first.

        `MOST_LARGE` of them at most.
        """
        away = self.corners - self.anchor_ws
        reach = np.abs(away).max(axis=(1, 2), initial=0.0)
        gap = np.maximum(np.maximum(away.min(axis=1, initial=np.inf), -away.max(axis=1, initial=-np.inf)), 0.0).max(axis=1, initial=0.0)
        rows = np.flatnonzero(reach > LARGE * gap)
        return rows[np.argsort(-reach[rows], kind="stable")][:MOST_LARGE]

    def distance_to_plane(self, triangle: np.ndarray, origins: np.ndarray, directions: np.ndarray, else_m: np.ndarray) -> np.ndarray:
        """(K,) metres along K rays to the planes of K triangles, in float64; `else_m` where a ray lies within 0.001° of the plane.

        There the plane would amplify noise instead of removing it.
        """
        slope = np.einsum("ij,ij->i", self.normal[triangle], directions)
        height = np.einsum("ij,ij->i", self.normal[triangle], self.corners[triangle, 0] - origins)
        steep = np.abs(slope) > 1.7e-5
        return np.where(steep, height / np.where(steep, slope, 1.0), else_m)


def world_triangles(scene: Scene, anchor_ws: np.ndarray | None = None) -> WorldTriangles:
    """All triangles of all instances; those without area in world space are left out (no ray can hit them).

    `anchor_ws` (3,) near what is looked at; None: the scene's local origin.
    """
    scene.bounds_ws()  # raises SceneError when there is nothing
    pieces, ids, flags = [], [], []
    placed, kinds = scene.instances, scene.whole_flags()
    for index, matrix, object_id, flag in zip(placed.mesh_index, placed.world_from_object, placed.object_id, kinds, strict=True):
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
    anchor = np.zeros(3) if anchor_ws is None else np.asarray(anchor_ws, np.float64)
    return WorldTriangles(corners, cross / doubled_area[:, None], object_id, flags, anchor)
