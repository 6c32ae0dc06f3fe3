"""One mesh made coarser by fast-simplification (quadric edge collapses, Garland and Heckbert 1997), with the error measured. No bpy, no GL.

The library collapses an edge as soon as its quadric is below a threshold that grows from pass to pass by (pass + 3)^aggressiveness, in the
mesh's own unit: the mesh is scaled so that the last pass allows the tolerance. What comes out is kept only where nothing opens and no
body, however thin, loses a tenth of its area or volume: a wire collapsed to a line would be near enough, and cast no shadow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...scene.mesh_prep import weld
from ..geometry.clusters import morton
from .bodies import Bodies
from .distance import Surface, hausdorff, sources

TOLERANCES = tuple(2.0 ** (-k / 2.0) for k in range(24, 13, -1))  # of the mesh's diagonal, finest first
LEAST_SAVED = 0.15  # of the triangles of the next finer one, else it is left out
LAST_ALLOWED = (1e-9 * 102) ** 0.5  # by the last of the library's hundred passes, at an aggressiveness of 1


@dataclass(frozen=True, eq=False)
class Coarse:
    """`positions` (V, 3) float32, `triangles` (T, 3) int32 in spatial order, `source` (T,) int32 a triangle of the original mesh that lies
    at each, and `error`, in the mesh's unit: Hausdorff's distance from the original."""

    positions: np.ndarray
    triangles: np.ndarray
    source: np.ndarray
    error: float


def coarser(positions: np.ndarray, triangles: np.ndarray) -> list[Coarse]:
    """The mesh at some tolerances, finest first; each has clearly fewer triangles than the one before. Borders stay as they are."""
    number, first = weld(positions)
    points, own = positions[first].astype(np.float64), np.ascontiguousarray(number[triangles], np.int32)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    points -= middle
    size, bodies = float(np.linalg.norm(np.ptp(points, axis=0))), Bodies(points, own)
    out: list[Coarse] = []
    for tolerance in TOLERANCES:
        most = (1.0 - LEAST_SAVED) * (len(out[-1].triangles) if out else len(own))
        made = _collapsed(points, own, bodies, tolerance * size, most)
        if made is not None:
            out.append(_in_order(Coarse((made.positions + middle).astype(np.float32), made.triangles, made.source, made.error)))
    return out


def _in_order(coarse: Coarse) -> Coarse:
    """With its triangles in the order that large meshes are drawn in."""
    order = np.argsort(morton(coarse.positions[coarse.triangles[:, 0]]), kind="stable")
    return replace(coarse, triangles=coarse.triangles[order], source=coarse.source[order])


def _collapsed(points: np.ndarray, triangles: np.ndarray, bodies: Bodies, tolerance: float, most: float) -> Coarse | None:
    """One level, around the origin; None where it keeps more than `most` triangles, or is not the same bodies."""
    from fast_simplification import replay_simplification, simplify

    scale = LAST_ALLOWED / tolerance
    _, fewer, collapses = simplify(points * scale, triangles, target_count=1, agg=1.0, return_collapses=True, preserve_border=True)
    if not 0 < len(fewer) <= most:
        return None
    placed, fewer, corner_of = replay_simplification(points * scale, triangles, collapses)
    placed = (placed / scale).astype(np.float32).astype(np.float64)
    corner_of, fewer = corner_of.astype(np.int64), fewer.astype(np.int64)
    if not bodies.are_kept(placed, fewer, corner_of):
        return None
    fine, made = Surface(points, triangles, corner_of[triangles]), Surface(placed, fewer, fewer)
    source = sources(made, fine)
    if (source < 0).any():
        return None
    return Coarse(placed, fewer.astype(np.int32), source.astype(np.int32), hausdorff(fine, made))
