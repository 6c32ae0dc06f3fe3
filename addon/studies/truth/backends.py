"""Two ray tracers behind one face: Blender's BVH (in every Blender) and Embree (batches, for benchmarks). Both watertight, both float32.

Both answer for batches of R rays: `nearest(origins, directions, limits)` → (triangle (R,) int64, −1 = none; distance (R,) float64, inf).
Directions are unit vectors; limits are metres.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ...errors import SettingsError

ROWS_AT_ONCE = 10_000  # some milliseconds


class Backend(Protocol):
    """What `TruthTracer` asks of a ray tracer."""

    def nearest(self, origins: np.ndarray, directions: np.ndarray, limits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First triangle along each ray."""


class BlenderBackend:
    """`mathutils.bvhtree`: a Python call per ray, some microseconds each."""

    def __init__(self, corners: np.ndarray, go_on: Callable[[], None] = lambda: None) -> None:
        import bpy  # noqa: F401  (outside Blender mathutils can only be imported after bpy)
        from mathutils.bvhtree import BVHTree

        self._go_on = go_on
        vertices, faces = listed(corners.reshape(-1, 3), go_on), listed(np.arange(3 * len(corners)).reshape(-1, 3), go_on)
        self._cast = BVHTree.FromPolygons(vertices, faces, all_triangles=True).ray_cast

    def nearest(self, origins: np.ndarray, directions: np.ndarray, limits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First triangle along each ray, and its distance."""
        hits = []
        for start in range(0, len(origins), ROWS_AT_ONCE):
            self._go_on()
            rows = zip(*(array[start : start + ROWS_AT_ONCE].tolist() for array in (origins, directions, limits)), strict=True)
            hits += [self._cast(o, d, limit)[2:] for o, d, limit in rows]
        triangle = np.array([-1 if index is None else index for index, _ in hits], dtype=np.int64)
        return triangle, np.array([np.inf if index is None else distance for index, distance in hits], dtype=np.float64)


def listed(rows: np.ndarray, go_on: Callable[[], None]) -> list[list[float]]:
    """`rows.tolist()` in pieces, between which other threads (the window's) get Python's lock and `go_on` is called."""
    out: list[list[float]] = []
    for start in range(0, len(rows), ROWS_AT_ONCE):
        go_on()
        out += rows[start : start + ROWS_AT_ONCE].tolist()
    return out


class EmbreeBackend:
    """Intel Embree through `embreex`, robust mode."""

    def __init__(self, corners: np.ndarray, go_on: Callable[[], None] = lambda: None) -> None:
        self._go_on = go_on
        try:
            from embreex.mesh_construction import TriangleMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise SettingsError("Embree is not installed: choose the 'blender' ray tracer or `pip install embreex`.") from error
        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, np.ascontiguousarray(corners, dtype=np.float32))

    def nearest(self, origins: np.ndarray, directions: np.ndarray, limits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First triangle along each ray, and its distance."""
        self._go_on()
        rays = (np.ascontiguousarray(a, dtype=np.float32) for a in (origins, directions, limits))
        hit = self._scene.run(*rays, query="INTERSECT", output=1)
        triangle = hit["primID"].astype(np.int64)
        return triangle, np.where(triangle >= 0, hit["tfar"].astype(np.float64), np.inf)


BACKENDS = {"blender": BlenderBackend, "embree": EmbreeBackend}


class ExactForLarge:
    """A ray tracer for most triangles, and float64 for a few: `large` (L,) rows of `corners` (T, 3, 3), which float32 would bend."""

    def __init__(self, corners: np.ndarray, large: np.ndarray, backend: Callable[..., Backend], go_on: Callable[[], None]) -> None:
        self._large, self._large_corners = large, corners[large]
        self._small = np.setdiff1d(np.arange(len(corners)), large)
        self._backend = backend(corners[self._small], go_on) if len(self._small) else None

    def nearest(self, origins: np.ndarray, directions: np.ndarray, limits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First triangle along each ray, and its distance."""
        triangle, distance = np.full(len(origins), -1), np.full(len(origins), np.inf)
        if self._backend is not None:
            found, distance = self._backend.nearest(origins, directions, limits)
            triangle[found >= 0] = self._small[found[found >= 0]]
        for row, (a, b, c) in zip(self._large, self._large_corners, strict=True):
            at = met_at(a, b - a, c - a, origins, directions)
            nearer = (at > 0.0) & (at < distance) & (at <= limits)
            triangle[nearer], distance[nearer] = row, at[nearer]
        return triangle, distance


def met_at(corner: np.ndarray, e1: np.ndarray, e2: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """(R,) where rays meet the triangle of a corner (3,) and the edges from it, in float64 (Möller–Trumbore); inf where they do not."""
    p = np.cross(directions, e2)
    determinant = p @ e1
    hit = determinant != 0.0
    scale = 1.0 / np.where(hit, determinant, 1.0)
    offset = origins - corner
    u = np.einsum("ij,ij->i", offset, p) * scale
    q = np.cross(offset, e1)
    v = np.einsum("ij,ij->i", directions, q) * scale
    hit &= (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    return np.where(hit, (q @ e2) * scale, np.inf)
