"""Convex bodies: the view frustum, slabs of it, and what planes leave of them. Exact clipping, no sampling.

A body is kept as its face polygons (Sutherland–Hodgman against each plane, then a cap over the cut), because clipping a mere set of
vertices would need the hull again. Bodies have at most some twenty vertices, so plain floats are faster than arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .view import Camera

# the faces of a hexahedron whose corner index is 4 z + 2 y + x
_QUADS = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
_NDC_XY = np.array([[x, y] for y in (-1.0, 1.0) for x in (-1.0, 1.0)])

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Body:
    """A convex body by its face polygons, in one space. Empty when it has no face. `scale` is the size that rounding is judged against."""

    faces: tuple[tuple[Point, ...], ...]
    scale: float

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) float64, without exact repetitions; (0, 3) when empty."""
        return np.array(sorted({p for face in self.faces for p in face})).reshape(-1, 3)

    def clipped(self, planes: np.ndarray) -> Body:
        """What lies on the inner side (a·x + b·y + c·z + d ≥ 0) of every row of `planes` (P, 4); rows of unit normal."""
        body = self
        for plane in np.asarray(planes, np.float64).reshape(-1, 4).tolist():
            body = body._clipped_once(plane)
        return body

    def _clipped_once(self, plane: list[float]) -> Body:
        """One plane; vertices within 1e-10 of the scale of it count as on it, so flat bodies survive."""
        eps = 1e-10 * self.scale
        faces: list[tuple] = []
        rim: list[tuple[float, float, float]] = []
        for face in self.faces:
            kept = _clip_polygon(face, plane, eps, rim)
            if len(kept) >= 3:
                faces.append(tuple(kept))
        cap = _around_centre(rim, plane[:3])
        if len(cap) >= 3:
            faces.append(cap)
        return Body(tuple(faces), self.scale)


def _clip_polygon(face: tuple[Point, ...], plane: list[float], eps: float, rim: list[Point]) -> list[Point]:
    """Sutherland–Hodgman against one plane; appends to `rim` the points of the result that lie on the plane."""
    a, b, c, d = plane
    heights = [a * x + b * y + c * z + d for x, y, z in face]
    kept: list[Point] = []
    for i, (p, h) in enumerate(zip(face, heights, strict=True)):
        q, g = face[i - 1], heights[i - 1]
        if (g > eps and h < -eps) or (g < -eps and h > eps):
            u = g / (g - h)
            cut = (q[0] + u * (p[0] - q[0]), q[1] + u * (p[1] - q[1]), q[2] + u * (p[2] - q[2]))
            kept.append(cut)
            rim.append(cut)
        if h >= -eps:
            kept.append(p)
            if h <= eps:
                rim.append(p)
    return kept


def _around_centre(points: list[Point], normal: list[float]) -> tuple[Point, ...]:
    """The distinct points of a convex planar rim in order round their centre."""
    rim = np.array(sorted(set(points))).reshape(-1, 3)
    if len(rim) < 3:
        return ()
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    out = rim - rim.mean(axis=0)
    order = np.argsort(np.arctan2(out @ np.cross(normal, u), out @ u))
    return tuple(map(tuple, rim[order].tolist()))


def hexahedron(corners: np.ndarray) -> Body:
    """The body of eight corners (8, 3), corner index = 4 z + 2 y + x of the parameter cube."""
    c = [tuple(row) for row in np.asarray(corners, np.float64).tolist()]
    return Body(tuple(tuple(c[i] for i in quad) for quad in _QUADS), float(np.ptp(corners, axis=0).max()))


def frustum_corners(camera: Camera, near: float, far: float) -> np.ndarray:
    """(8, 3) corners, relative to the eye in world axes, of the view frustum's slab [near, far] (view depths).

    Exact for perspective, orthographic and shifted cameras: along an edge of the frustum the view depth is linear.
    """
    ends = []
    for ndc_depth in (-1.0, 1.0):
        ndc = np.column_stack([_NDC_XY, np.full(4, ndc_depth), np.ones(4)])
        points_h = ndc @ np.linalg.inv(camera.clip_from_view).T
        ends.append(points_h[:, :3] / points_h[:, 3:])
    first, last = ends
    rotation = camera.view_from_world[:3, :3]
    slab = []
    for depth in (near, far):
        u = (-depth - first[:, 2:]) / (last[:, 2:] - first[:, 2:])
        slab.append(first + u * (last - first))
    return np.concatenate(slab) @ rotation


def box_planes(bounds: np.ndarray) -> np.ndarray:
    """(6, 4) inward planes of an axis-aligned box (2, 3)."""
    lower = np.column_stack([np.eye(3), -np.asarray(bounds[0], np.float64)])
    upper = np.column_stack([-np.eye(3), np.asarray(bounds[1], np.float64)])
    return np.concatenate([lower, upper])


def box_corners(bounds: np.ndarray) -> np.ndarray:
    """(…, 8, 3) corners of boxes (…, 2, 3)."""
    pick = np.array([[(i >> axis) & 1 for axis in range(3)] for i in range(8)])
    return np.take_along_axis(np.asarray(bounds, np.float64), np.broadcast_to(pick, (*np.shape(bounds)[:-2], 8, 3)), axis=-2)


def box_distances(bounds: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(B,) from a point (3,) to boxes (B, 2, 3); 0 within."""
    return np.linalg.norm(np.maximum(np.maximum(bounds[:, 0] - point, point - bounds[:, 1]), 0.0), axis=1)
