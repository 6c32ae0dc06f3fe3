"""Places on the surfaces of a scene, object by object, evenly over their area. numpy only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..maths.directions import places_on, square_points, triangle_points
from ..scene.looks import GROUND, HIDDEN
from ..scene.records import Scene
from .truth.triangles import WorldTriangles, world_triangles

LEAST, TOTAL = 64, 100_000


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """S places: `points_ws`, `normals_ws` (S, 3) float64, of the side that the winding names; `object_id` (S,), ascending.

    `areas` (objects,) m² by object id, 0 of those without a place. All places of one object stand for equal areas.
    """

    points_ws: np.ndarray
    normals_ws: np.ndarray
    object_id: np.ndarray
    areas: np.ndarray


def surface_samples(scene: Scene, least: int = LEAST, total: int = TOTAL) -> SurfaceSamples:
    """At least `least` places on every object that is seen, about `total` in all, by area; of the ground under the model none.

    Systematic sampling: place k of n lies where (k + 1/2) / n of the object's area is passed, triangle after triangle.
    """
    triangles = world_triangles(scene)
    double = np.linalg.norm(
        np.cross(triangles.corners[:, 1] - triangles.corners[:, 0], triangles.corners[:, 2] - triangles.corners[:, 0]), axis=1
    )
    seen = (triangles.flags & (HIDDEN | GROUND)) == 0
    areas = np.bincount(triangles.object_id[seen], 0.5 * double[seen], minlength=len(scene.object_names))
    order = np.flatnonzero(seen)[np.argsort(triangles.object_id[seen], kind="stable")]
    passed, ends = np.cumsum(0.5 * double[order]), np.cumsum(areas)
    counts = np.where(areas > 0.0, np.maximum(least, np.ceil(total * areas / max(float(areas.sum()), 1e-300))), 0).astype(np.int64)
    of_object = np.repeat(np.arange(len(areas)), counts)
    k = np.arange(len(of_object)) - np.repeat(np.cumsum(counts) - counts, counts)
    at = (ends - areas)[of_object] + areas[of_object] * (k + 0.5) / np.maximum(counts, 1)[of_object]
    chosen = order[np.minimum(np.searchsorted(passed, at), len(order) - 1)] if len(order) else order
    return SurfaceSamples(_places(triangles, chosen), triangles.normal[chosen], triangles.object_id[chosen], areas)


def _places(triangles: WorldTriangles, chosen: np.ndarray) -> np.ndarray:
    """(S, 3) a place on each of the triangles chosen, from one to the next elsewhere."""
    return places_on(triangles.corners[chosen], triangle_points(square_points(len(chosen))))
