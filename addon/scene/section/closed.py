"""Whether a body is closed, so that a section through it has an area. numpy only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh_prep import weld

NEAR = 1e-5  # of the body's size: corners so near to one another are one where the body is open with exact ones


@dataclass(frozen=True, eq=False)
class Solid:
    """The triangles (T, 3) of one body over its points (W, 3) float64. `is_closed`: every edge has two sides, or four, …;
    `is_oriented`: they also run through each edge as often one way as the other, so that inside and outside are known."""

    points: np.ndarray
    triangles: np.ndarray
    is_closed: bool
    is_oriented: bool


def solid_of(positions: np.ndarray, triangles: np.ndarray) -> Solid:
    """The body of `positions` (V, 3) float32 and `triangles` (T, 3): corners at one place are one point.

    Where exact places leave it open, those within `NEAR` of the body's size are taken for one.
    """
    body = _welded(positions, positions, triangles)
    if body.is_closed or not len(positions):
        return body
    step = NEAR * float((positions.max(axis=0) - positions.min(axis=0)).max())
    if not step > 0.0:
        return body
    rounded = np.rint((positions.astype(np.float64) - positions[0]) / step).astype(np.float32)
    coarse = _welded(positions, rounded, triangles)
    return coarse if coarse.is_closed else body


def _welded(positions: np.ndarray, places: np.ndarray, triangles: np.ndarray) -> Solid:
    number, first = weld(places)
    corners = number[triangles].astype(np.int64)
    distinct = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    corners = corners[distinct]
    return Solid(positions[first].astype(np.float64), corners, *_sides(corners, len(first)))


def _sides(triangles: np.ndarray, points: int) -> tuple[bool, bool]:
    """(closed, oriented) of triangles (T, 3) over so many points."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, edge, sides = np.unique(low * points + high, return_inverse=True, return_counts=True)
    is_closed = bool(len(sides)) and not (sides % 2).any()
    balance = np.bincount(edge, np.where(start < end, 1.0, -1.0)) if len(sides) else np.zeros(0)
    return is_closed, is_closed and not balance.any()
