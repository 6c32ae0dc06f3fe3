"""Triangles made fit to draw: bad ones left out, corners given the normals a machined part wants. numpy only.

What it is not: a repair of topology. Nothing is moved, no hole is closed, no winding is turned (everything is drawn two-sided).
The crease rule is VRML97's `creaseAngle` read per corner: faces that meet at a point share a normal there when their own normals
differ by at most the angle. It needs no edge adjacency, so it holds on T-junctions, non-manifold edges and doubled faces.
Arrays of vectors are worked on as three columns: numpy is several times faster on those than on rows of three.
Underflow is let pass: a product of two tiny components that rounds to zero is the right answer here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi

import numpy as np

DEFAULT_CREASE_RAD = pi / 6
PAIRS_AT_ONCE = 1 << 17
TRIANGLES_AT_ONCE = 1 << 14
MAX_VALENCE = 512
FLATNESS = 1e-9
HASH_FACTORS = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x27D4EB2F165667C5)
Columns = list[np.ndarray]


@dataclass(frozen=True, slots=True)
class Defects:
    """How much of a mesh was left out: vertices that are not finite, triangles that use one, triangles without area."""

    bad_vertices: int = 0
    bad_faces: int = 0
    zero_area_faces: int = 0

    def __add__(self, other: Defects) -> Defects:
        return Defects(
            self.bad_vertices + other.bad_vertices, self.bad_faces + other.bad_faces, self.zero_area_faces + other.zero_area_faces
        )

    def __bool__(self) -> bool:
        return bool(self.bad_vertices or self.bad_faces or self.zero_area_faces)

    def sentence(self, of: str = "") -> str:
        """One line for a report's warnings; `of` names the mesh."""
        parts = [
            (self.bad_vertices, "vertices that are NaN or infinite"),
            (self.bad_faces, "faces that use them"),
            (self.zero_area_faces, "faces without area"),
        ]
        found = ", ".join(f"{count} {what}" for count, what in parts if count)
        return f"Left out{f' of {of}' if of else ''}: {found}."


@dataclass(frozen=True, eq=False)
class Shaded:
    """Vertices ready for the GPU: `positions` (V, 3), `normals` (V, 3) unit, float32; `triangles` (T, 3) int32 in the order given.

    `source` (V,) tells the vertex each one came from; every vertex is used.
    """

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    source: np.ndarray


@np.errstate(under="ignore")
def drawable(positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, Defects]:
    """Claim: (T,) bool, true where all three corners exist, are finite, and span an area; and the count of what is not so.

    `positions` (V, 3) float, `triangles` (T, 3) int. A triangle has no area when its height over the longest edge is below
    `FLATNESS` times that edge: in float32 no such triangle can be told from a line. Scale-free: 1 µm and 1 km parts are treated alike.
    """
    finite = np.isfinite(positions).all(axis=1)
    bad_vertices = int(len(finite) - np.count_nonzero(finite))
    usable = ((triangles >= 0) & (triangles < len(positions))).all(axis=1)
    if bad_vertices:
        usable[usable] = finite[triangles[usable]].all(axis=1)
    keep = usable.copy()
    chosen, has_area = triangles if usable.all() else triangles[usable], np.empty(int(np.count_nonzero(usable)), bool)
    for rows in _blocks(len(chosen)):
        geometry = _Geometry(positions, chosen[rows])
        has_area[rows] = geometry.twice_area > FLATNESS * geometry.longest_squared
    keep[usable] = has_area
    used = int(np.count_nonzero(usable))
    return keep, Defects(bad_vertices, len(triangles) - used, used - int(np.count_nonzero(keep)))


def _dot(a: Columns, b: Columns) -> np.ndarray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _blocks(count: int) -> Iterator[slice]:
    """Rows of so many, some at once: what is worked out of them in float64 stays small."""
    return (slice(at, at + TRIANGLES_AT_ONCE) for at in range(0, count, TRIANGLES_AT_ONCE))


class _Geometry:
    """Edges, cross product, area of some triangles, float64 columns (T,)."""

    def __init__(self, positions: np.ndarray, triangles: np.ndarray) -> None:
        corners = (np.take(positions, triangles[:, k], axis=0) for k in range(3))
        a, b, c = ([corner[:, k].astype(np.float64) for k in range(3)] for corner in corners)
        self.edges: list[Columns] = [[q - p for p, q in zip(u, v, strict=True)] for u, v in ((a, b), (b, c), (c, a))]
        (x, y, z), (u, v, w) = self.edges[0], self.edges[1]
        self.cross: Columns = [y * w - z * v, z * u - x * w, x * v - y * u]
        self.twice_area = np.sqrt(_dot(self.cross, self.cross))

    @property
    def longest_squared(self) -> np.ndarray:
        """(T,) square of the longest edge."""
        return np.maximum.reduce([_dot(e, e) for e in self.edges])

    def normals(self) -> Columns:
        """Unit normals as float32 columns, right-hand rule; every triangle must have an area."""
        return [(c / self.twice_area).astype(np.float32) for c in self.cross]

    def angles(self) -> np.ndarray:
        """(T, 3) float32 interior angle at each corner; they sum to π."""
        out = np.empty((len(self.twice_area), 3), dtype=np.float32)
        area = self.twice_area.astype(np.float32)
        for k in range(3):
            out[:, k] = np.arctan2(area, -_dot(self.edges[k - 1], self.edges[k]).astype(np.float32))
        return out


def _normals_and_angles(positions: np.ndarray, triangles: np.ndarray) -> tuple[Columns, np.ndarray]:
    """Unit normals, float32 columns, and interior angles (T, 3) of all triangles, which have an area."""
    normals, angles = [np.empty(len(triangles), np.float32) for _ in range(3)], np.empty((len(triangles), 3), np.float32)
    for rows in _blocks(len(triangles)):
        geometry = _Geometry(positions, triangles[rows])
        angles[rows] = geometry.angles()
        for column, own in zip(normals, geometry.normals(), strict=True):
            column[rows] = own
    return normals, angles


def weld(positions: np.ndarray, group: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Claim: `number` (V,) int32, equal exactly where positions (and groups) are equal (−0.0 = 0.0), 0…W−1; `first` (W,) a vertex of each.

    `positions` (V, 3) float32, finite; `group` (V,) int32 keeps meshes apart that are worked on together.
    Sorts one 64-bit hash per point and verifies it, so the answer is exact.
    """
    bits = np.ascontiguousarray(positions + np.float32(0.0), dtype=np.float32).view(np.uint32)
    columns = [np.ascontiguousarray(bits[:, k]) for k in range(3)] + ([] if group is None else [group.astype(np.uint32)])
    key = np.zeros(len(bits), dtype=np.uint64)
    for column, odd in zip(columns, HASH_FACTORS, strict=False):
        key ^= column.astype(np.uint64) * np.uint64(odd)
        key ^= key >> np.uint64(31)
    order = np.argsort(key)
    new = _any_differs([column[order] for column in columns])
    if not np.array_equal(new, _differs(key[order])):  # two points with one hash
        order = np.lexsort(columns)
        new = _any_differs([column[order] for column in columns])
    number = np.empty(len(bits), dtype=np.int32)
    number[order] = np.cumsum(new, dtype=np.int32) - 1
    return number, order[new]


def _differs(column: np.ndarray) -> np.ndarray:
    """(N,) bool: whether an element differs from the one before it; the first does."""
    out = np.ones(len(column), dtype=bool)
    np.not_equal(column[1:], column[:-1], out=out[1:])
    return out


def _any_differs(columns: Columns) -> np.ndarray:
    return np.logical_or.reduce([_differs(column) for column in columns])


@np.errstate(under="ignore")
def shade_by_crease(
    positions: np.ndarray, triangles: np.ndarray, crease_angle_rad: float = DEFAULT_CREASE_RAD, group: np.ndarray | None = None
) -> Shaded:
    """Claim: at each corner the mean, weighted by corner angle, of the normals of all faces that meet at this point and differ from
    this corner's face by at most `crease_angle_rad`; vertices are split where that gives different normals, welded where it does not.

    Domain: triangles with an area, 0 ≤ angle ≤ π; `group` (V,) int32 keeps meshes apart that are shaded together.
    Weighting by angle makes the result independent of how flat regions are cut up (Thürmer and Wüthrich 1998). Shortcut without loss:
    where all faces lie within half the angle of their mean, every two of them lie within the angle. Where more than `MAX_VALENCE` faces
    meet at a point that is not smooth (the tip of a fine cone), they keep their own normals.
    """
    points, first = weld(np.asarray(positions, dtype=np.float32), group)
    corners = np.take(points, triangles)
    normals, weights = _normals_and_angles(positions, triangles)
    mean = _point_means(normals, weights, corners, len(first))
    rough = _rough_points(mean, normals, corners, cos(min(crease_angle_rad, pi) / 2))
    used = np.zeros(len(first), dtype=bool)
    used[corners.ravel()] = True
    easy = used & ~rough
    number = np.cumsum(easy, dtype=np.int32) - 1
    new_triangles = np.take(number, corners).ravel()
    source, new_normals = first[easy], np.stack([m[easy] for m in mean], axis=1)
    if rough.any():
        corner, normal = _crease_corners(normals, weights, corners, rough, cos(min(crease_angle_rad, pi)))
        point = corners.ravel()[corner]
        chosen, new_of_corner = split_vertices(point, normal)
        new_triangles[corner] = new_of_corner + len(source)
        source = np.concatenate([source, first[point[chosen]]])
        new_normals = np.concatenate([new_normals, np.stack([n[chosen] for n in normal], axis=1)])
    return Shaded(np.take(positions, source, axis=0), new_normals, new_triangles.reshape(-1, 3), source)


def _point_means(normals: Columns, weights: np.ndarray, corners: np.ndarray, count: int) -> Columns:
    """Unit weighted mean normal at each point as float32 columns; zero where opposite faces cancel."""
    flat = corners.ravel()
    sums = [np.bincount(flat, (n[:, None] * weights).ravel(), count) for n in normals]
    length = np.sqrt(_dot(sums, sums))
    scale = np.where(length > 1e-6, 1.0 / np.maximum(length, 1e-6), 0.0)
    return [(s * scale).astype(np.float32) for s in sums]


def _rough_points(mean: Columns, normals: Columns, corners: np.ndarray, limit: float) -> np.ndarray:
    """(W,) bool: some face at the point leans from the point's mean normal by more than arccos(limit)."""
    rough = np.zeros(len(mean[0]), dtype=bool)
    for k in range(3):
        index = np.ascontiguousarray(corners[:, k])
        rough[index[_dot([m[index] for m in mean], normals) < limit]] = True
    return rough


def _crease_corners(
    normals: Columns, weights: np.ndarray, corners: np.ndarray, rough: np.ndarray, min_cos: float
) -> tuple[np.ndarray, Columns]:
    """The corners at rough points, sorted by point, and the crease normal of each, found by comparing every two corners of a point."""
    flat = corners.ravel()
    corner = np.flatnonzero(rough[flat])
    corner = corner[np.argsort(flat[corner], kind="stable")]
    face = corner // 3
    own = [n[face] for n in normals]
    weight = weights.ravel()[corner]
    weighted = [n * weight for n in own]
    new = _differs(flat[corner])
    start = np.flatnonzero(new)
    size = np.diff(np.append(start, len(corner)))
    size, start = np.repeat(size, size), np.repeat(start, size)
    alone = size > MAX_VALENCE
    size[alone], start[alone] = 1, np.flatnonzero(alone)
    result = [np.empty_like(n) for n in own]
    ends = np.cumsum(size)
    first = 0
    while first < len(corner):
        done = ends[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(ends, done + PAIRS_AT_ONCE, side="right")))
        for out, values in zip(result, _chunk_means(own, weighted, start[first:last], size[first:last], first, min_cos), strict=True):
            out[first:last] = values
        first = last
    return corner, result


def _chunk_means(own: Columns, weighted: Columns, start: np.ndarray, size: np.ndarray, first: int, min_cos: float) -> Columns:
    """Normalised sums over the near ones among the corners start…start+size of each corner first, first + 1, …"""
    begin = np.cumsum(size) - size
    other = np.arange(int(size.sum())) + np.repeat(start - begin, size)
    near = _dot([np.repeat(n[first : first + len(size)], size) for n in own], [n[other] for n in own]) >= min_cos - 1e-6
    total = [np.add.reduceat(w[other] * near, begin) for w in weighted]
    length = np.sqrt(_dot(total, total))
    return [t / length for t in total]


def shade_by_corners(positions: np.ndarray, triangles: np.ndarray, corner_normals: np.ndarray) -> Shaded:
    """Claim: vertices split just where the given (T, 3, 3) unit normals of their corners differ."""
    normals = [np.ascontiguousarray(corner_normals[:, :, k]).ravel() for k in range(3)]
    vertex = triangles.ravel()
    chosen, new_of_corner = split_vertices(vertex, normals)
    source = vertex[chosen]
    return Shaded(np.take(positions, source, axis=0), np.stack([n[chosen] for n in normals], axis=1), new_of_corner.reshape(-1, 3), source)


def split_vertices(vertex: np.ndarray, normals: Columns) -> tuple[np.ndarray, np.ndarray]:
    """Claim: `chosen` (U,) a corner for each new vertex and `new_of_corner` (C,) int32; corners share a new vertex only if their
    `vertex` (C,) is the same and their `normals` (three columns (C,)) agree to 1/2¹⁵, the step of a 16-bit normal.

    Exact but for a collision of 64-bit hashes (in which case corners are split once more, never joined wrongly).
    """
    key = np.zeros(len(vertex), dtype=np.uint64)
    for column in normals:
        key = (key << np.uint64(17)) | np.rint(column * np.float32(32767.0) + np.float32(32768.0)).astype(np.uint64)
    order = np.argsort((key * np.uint64(HASH_FACTORS[0])) ^ (vertex.astype(np.uint64) * np.uint64(HASH_FACTORS[1])))
    new = _any_differs([key[order], vertex[order]])
    new_of_corner = np.empty(len(order), dtype=np.int32)
    new_of_corner[order] = np.cumsum(new, dtype=np.int32) - 1
    return order[new], new_of_corner
