"""Triangles made fit to draw: bad ones left out, corners given the normals a machined part wants. numpy only.

What it is not: a repair of topology. Nothing is moved, no hole is closed, no winding is turned (everything is drawn two-sided).
The crease rule is VRML97's `creaseAngle` read per corner: faces that meet at a point share a normal there when their own normals
differ by at most the angle. It needs no edge adjacency, so it holds on T-junctions, non-manifold edges and doubled faces.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

import numpy as np

DEFAULT_CREASE_RAD = pi / 6
PAIRS_AT_ONCE = 1 << 20
MAX_VALENCE = 512
FLATNESS = 1e-9


@dataclass(frozen=True, slots=True)
class Defects:
    """How much of a mesh was left out: vertices that are not finite, triangles that use one, triangles without area."""

    bad_vertices: int = 0
    bad_faces: int = 0
    zero_area_faces: int = 0

    def __add__(self, other: Defects) -> Defects:
        return Defects(self.bad_vertices + other.bad_vertices, self.bad_faces + other.bad_faces, self.zero_area_faces + other.zero_area_faces)

    def __bool__(self) -> bool:
        return bool(self.bad_vertices or self.bad_faces or self.zero_area_faces)

    def sentence(self, of: str = "") -> str:
        """One line for a report's warnings; `of` names the mesh."""
        parts = [(self.bad_vertices, "vertices that are NaN or infinite"), (self.bad_faces, "faces that use them"),
                 (self.zero_area_faces, "faces without area")]
        found = ", ".join(f"{count} {what}" for count, what in parts if count)
        return f"Left out{f' of {of}' if of else ''}: {found}."


def drawable(positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, Defects]:
    """Claim: (T,) bool, true where all three corners exist, are finite, and span an area; and the count of what is not so.

    `positions` (V, 3) float, `triangles` (T, 3) int. A triangle has no area when its height over the longest edge is below
    `FLATNESS` times that edge: in float32 no such triangle can be told from a line. Scale-free: 1 µm and 1 km parts are treated alike.
    """
    finite = np.isfinite(positions).all(axis=1)
    bad_vertices = int(len(finite) - np.count_nonzero(finite))
    inside = ((triangles >= 0) & (triangles < len(positions))).all(axis=1)
    if bad_vertices or not inside.all():
        usable = inside.copy()
        usable[inside] = finite[triangles[inside]].all(axis=1)
    else:
        usable = inside
    keep = usable.copy()
    keep[usable] = _has_area(positions, triangles if usable.all() else triangles[usable])
    used = int(np.count_nonzero(usable))
    return keep, Defects(bad_vertices, len(triangles) - used, used - int(np.count_nonzero(keep)))


def _edges(positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The three edges (T, 3) float64 of each triangle, in order: corner 0 → 1, 1 → 2, 2 → 0."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    return b - a, c - b, a - c


def _row_dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rowwise cross product; twice as fast as `np.cross`."""
    out = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, i] = a[:, j] * b[:, k] - a[:, k] * b[:, j]
    return out


def _has_area(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    edges = _edges(positions, triangles)
    longest = np.maximum.reduce([_row_dot(e, e) for e in edges])
    cross = _cross(edges[0], edges[1])
    return _row_dot(cross, cross) > (FLATNESS * longest) ** 2


def weld(positions: np.ndarray) -> np.ndarray:
    """Claim: (V,) int32; equal numbers exactly where positions are equal (−0.0 = 0.0), numbers 0…W−1.

    `positions` (V, 3) float32, finite. Sorts one 64-bit hash per point and verifies it, so the answer is exact.
    """
    bits = np.ascontiguousarray(positions + np.float32(0.0), dtype=np.float32).view(np.uint32).astype(np.uint64)
    key = bits[:, 0] * np.uint64(0x9E3779B97F4A7C15) ^ (bits[:, 1] * np.uint64(0xC2B2AE3D27D4EB4F)) ^ (bits[:, 2] * np.uint64(0x165667B19E3779F9))
    key ^= key >> np.uint64(29)
    order = np.argsort(key)
    sorted_bits = bits[order]
    same_point = (sorted_bits[1:] == sorted_bits[:-1]).all(axis=1)
    same_key = key[order][1:] == key[order][:-1]
    if (same_key != same_point).any():  # two points with one hash
        order = np.lexsort(bits.T)
        same_point = (bits[order][1:] == bits[order][:-1]).all(axis=1)
    number = np.empty(len(positions), dtype=np.int32)
    number[order] = np.concatenate([[0], np.cumsum(~same_point)]) if len(order) else 0
    return number


def face_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(T, 3) float32 unit normals, right-hand rule; triangles must have an area."""
    edges = _edges(positions, triangles)
    cross = _cross(edges[0], edges[1])
    scale = np.sqrt(_row_dot(cross, cross))
    return (cross / scale[:, None]).astype(np.float32)


def corner_angles(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(T, 3) float32 interior angles; they sum to π."""
    e = _edges(positions, triangles)
    cross = _cross(e[0], e[1])
    area = np.sqrt(_row_dot(cross, cross))
    return np.stack([np.arctan2(area, -_row_dot(e[k - 1], e[k])) for k in range(3)], axis=1).astype(np.float32)


def crease_normals(positions: np.ndarray, triangles: np.ndarray, crease_angle_rad: float = DEFAULT_CREASE_RAD) -> np.ndarray:
    """Claim: (T, 3, 3) float32 unit normal of each corner: the mean, weighted by corner angle, of the normals of all faces that
    meet at this point (by position) and differ from this corner's face by at most `crease_angle_rad`.

    Domain: triangles with area, 0 ≤ angle ≤ π. Weighting by angle makes the result independent of how flat regions are cut up
    (Thürmer and Wüthrich 1998). Where more than `MAX_VALENCE` faces meet at a point that is not smooth, the faces keep their own normal.
    """
    normals = face_normals(positions, triangles)
    weights = corner_angles(positions, triangles).ravel()
    point = _points(positions, triangles)
    count = int(point.max()) + 1 if len(point) else 0
    face = np.repeat(np.arange(len(triangles)), 3)
    out = normals[face]
    mean, valence = _vertex_means(normals, weights, point, count)
    at_corner = mean[point]
    dot = _row_dot(at_corner, out)
    smooth = np.ones(count, dtype=bool)
    smooth[point[dot < cos(min(crease_angle_rad, pi) / 2)]] = False
    easy = smooth[point]
    out[easy] = at_corner[easy]
    hard = np.flatnonzero(~easy & (valence[point] <= MAX_VALENCE))
    if len(hard):
        out[hard] = _pairwise_means(normals, weights, point, hard, cos(min(crease_angle_rad, pi)))
    return out.reshape(-1, 3, 3)


def _points(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(3T,) number of the position at each corner. Points are welded, whatever the file's vertices are."""
    return weld(np.asarray(positions, dtype=np.float32))[triangles.ravel()]


def _vertex_means(normals: np.ndarray, weights: np.ndarray, point: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit weighted mean normal (count, 3) at each point (zero where opposite faces cancel) and its number of corners."""
    mean = np.stack([np.bincount(point, np.repeat(normals[:, k], 3) * weights, count) for k in range(3)], axis=1)
    length = np.sqrt(_row_dot(mean, mean))
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(length[:, None] > 1e-6, mean / length[:, None], 0.0)
    return mean.astype(np.float32), np.bincount(point, minlength=count)


def _pairwise_means(normals: np.ndarray, weights: np.ndarray, point: np.ndarray, corners: np.ndarray, min_cos: float) -> np.ndarray:
    """(N, 3) normals of `corners`, by comparing every two corners of a point; in chunks of bounded memory."""
    order = np.argsort(point[corners], kind="stable")
    sorted_corners = corners[order]
    _, start, size = np.unique(point[sorted_corners], return_index=True, return_counts=True)
    size_of = np.repeat(size, size)
    start_of = np.repeat(start, size)
    weighted = normals[sorted_corners // 3] * weights[sorted_corners, None]
    own = normals[sorted_corners // 3]
    result = np.empty((len(corners), 3), dtype=np.float32)
    ends = np.cumsum(size_of)
    first = 0
    while first < len(corners):
        done = ends[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(ends, done + PAIRS_AT_ONCE, side="right")))
        result[first:last] = _chunk_means(own, weighted, start_of[first:last], size_of[first:last], first, min_cos)
        first = last
    unsorted = np.empty_like(result)
    unsorted[order] = result
    return unsorted


def _chunk_means(own: np.ndarray, weighted: np.ndarray, start: np.ndarray, size: np.ndarray, first: int, min_cos: float) -> np.ndarray:
    me = np.repeat(np.arange(len(size)), size)
    begin = np.cumsum(size) - size
    other = np.arange(len(me)) - begin[me] + start[me]
    near = _row_dot(own[me + first], own[other]) >= min_cos - 1e-6
    total = np.add.reduceat(np.where(near[:, None], weighted[other], np.float32(0.0)), begin, axis=0)
    return total / np.sqrt(_row_dot(total, total))[:, None]


def split_vertices(vertex_of_corner: np.ndarray, corner_normals: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Claim: the fewest vertices that give each corner its normal.

    `vertex_of_corner` (C,) int, `corner_normals` (C, 3) float32 unit. Returns `source` (U,) the corner whose vertex and normal each
    new vertex has, `corner_to_new` (C,) int32, and `normals` (U, 3). Normals are told apart at 1/32767, the step of a 16-bit normal.
    """
    steps = np.rint(corner_normals * np.float32(32767.0)).astype(np.int64) + 32768
    key = (steps[:, 0] << 34) | (steps[:, 1] << 17) | steps[:, 2]
    mixed = (key.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)) ^ (vertex_of_corner.astype(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F))
    order = np.argsort(mixed)
    k, v = key[order], vertex_of_corner[order]
    new = np.concatenate([[True], (k[1:] != k[:-1]) | (v[1:] != v[:-1])]) if len(order) else np.empty(0, dtype=bool)
    source = order[new]
    corner_to_new = np.empty(len(order), dtype=np.int32)
    corner_to_new[order] = np.cumsum(new) - 1
    return source, corner_to_new, corner_normals[source]
