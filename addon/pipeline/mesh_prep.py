"""Triangles made fit to draw: bad ones left out, corners given the normals a machined part wants. numpy only.

What it is not: a repair of topology. Nothing is moved, no hole is closed, no winding is turned (everything is drawn two-sided).
The crease rule is VRML97's `creaseAngle` read per corner: faces that meet at a point share a normal there when their own normals
differ by at most the angle. It needs no edge adjacency, so it holds on T-junctions, non-manifold edges and doubled faces.
Arrays of vectors are worked on as three columns: numpy is several times faster on those than on rows of three.
Underflow is let pass: a product of two tiny components that rounds to zero is the right answer here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

import numpy as np

DEFAULT_CREASE_RAD = pi / 6
PAIRS_AT_ONCE = 1 << 20
MAX_VALENCE = 512
FLATNESS = 1e-9
Columns = list[np.ndarray]


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


@dataclass(frozen=True, eq=False)
class Shaded:
    """Vertices ready for the GPU: `positions` (V, 3), `normals` (V, 3) unit, float32; `triangles` (T, 3) int32 in the order given."""

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray

    def part(self, chosen: np.ndarray) -> Shaded:
        """The triangles of a (T,) bool mask with the vertices they use."""
        triangles = self.triangles[chosen]
        used = np.zeros(len(self.positions), dtype=bool)
        used[triangles.ravel()] = True
        number = np.cumsum(used, dtype=np.int32) - 1
        return Shaded(self.positions[used], self.normals[used], number[triangles])


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
    geometry = _Geometry(positions, triangles if usable.all() else triangles[usable])
    keep[usable] = geometry.twice_area > FLATNESS * geometry.longest_squared
    used = int(np.count_nonzero(usable))
    return keep, Defects(bad_vertices, len(triangles) - used, used - int(np.count_nonzero(keep)))


def _dot(a: Columns, b: Columns) -> np.ndarray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class _Geometry:
    """Edges, cross product, area of every triangle, float64 columns (T,)."""

    def __init__(self, positions: np.ndarray, triangles: np.ndarray) -> None:
        columns = [np.ascontiguousarray(positions[:, k], dtype=np.float64) for k in range(3)]
        index = [np.ascontiguousarray(triangles[:, k]) for k in range(3)]
        a, b, c = ([column[i] for column in columns] for i in index)
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


def weld(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Claim: `number` (V,) int32, equal exactly where positions are equal (−0.0 = 0.0), 0…W−1; `first` (W,) a vertex at each point.

    `positions` (V, 3) float32, finite. Sorts one 64-bit hash per point and verifies it, so the answer is exact.
    """
    bits = np.ascontiguousarray(positions + np.float32(0.0), dtype=np.float32).view(np.uint32)
    key = np.zeros(len(bits), dtype=np.uint64)
    for k, odd in enumerate((0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)):
        key ^= bits[:, k].astype(np.uint64) * np.uint64(odd)
        key ^= key >> np.uint64(31)
    order = np.argsort(key)
    new = _differs(bits[order])
    if not np.array_equal(new, _differs(key[order])):  # two points with one hash
        order = np.lexsort(bits.T)
        new = _differs(bits[order])
    number = np.empty(len(bits), dtype=np.int32)
    number[order] = np.cumsum(new, dtype=np.int32) - 1
    return number, order[new]


def _differs(rows: np.ndarray) -> np.ndarray:
    """(N,) bool: whether a row differs from the one before it; the first does."""
    out = np.ones(len(rows), dtype=bool)
    changed = rows[1:] != rows[:-1]
    out[1:] = changed if rows.ndim == 1 else changed.any(axis=1)
    return out


@np.errstate(under="ignore")
def shade_by_crease(positions: np.ndarray, triangles: np.ndarray, crease_angle_rad: float = DEFAULT_CREASE_RAD) -> Shaded:
    """Claim: at each corner the mean, weighted by corner angle, of the normals of all faces that meet at this point and differ from
    this corner's face by at most `crease_angle_rad`; vertices are split where that gives different normals, welded where it does not.

    Domain: triangles with an area, 0 ≤ angle ≤ π. Weighting by angle makes the result independent of how flat regions are cut up
    (Thürmer and Wüthrich 1998). Shortcut without loss: where all faces lie within half the angle of their mean, every two of them lie
    within the angle. Where more than `MAX_VALENCE` faces meet at a point that is not smooth, faces keep their own normal.
    """
    points, first = weld(np.asarray(positions, dtype=np.float32))
    corners = points[triangles]
    geometry = _Geometry(positions, triangles)
    normals, weights = geometry.normals(), geometry.angles()
    mean = _point_means(normals, weights, corners, len(first))
    limit = cos(min(crease_angle_rad, pi) / 2)
    rough = np.zeros(len(first), dtype=bool)
    for k in range(3):
        index = np.ascontiguousarray(corners[:, k])
        rough[index[_dot([m[index] for m in mean], normals) < limit]] = True
    smooth_normals = np.stack(mean, axis=1)
    if not rough.any():
        return Shaded(positions[first], smooth_normals, corners)
    hard = np.flatnonzero(rough[corners].ravel())
    point = corners.ravel()[hard]
    hard_normals = _crease_means(np.stack(normals, axis=1)[hard // 3], weights.ravel()[hard], point, cos(min(crease_angle_rad, pi)))
    return _joined(positions[first], smooth_normals, corners, rough, hard, point, hard_normals)


def _point_means(normals: Columns, weights: np.ndarray, corners: np.ndarray, count: int) -> Columns:
    """Unit weighted mean normal at each point as float32 columns; zero where opposite faces cancel."""
    flat = corners.ravel()
    sums = [np.bincount(flat, (n[:, None] * weights).ravel(), count) for n in normals]
    length = np.sqrt(_dot(sums, sums))
    scale = np.where(length > 1e-6, 1.0 / np.maximum(length, 1e-6), 0.0)
    return [(s * scale).astype(np.float32) for s in sums]


def _joined(points: np.ndarray, smooth: np.ndarray, corners: np.ndarray, rough: np.ndarray, hard: np.ndarray, point: np.ndarray,
            hard_normals: np.ndarray) -> Shaded:
    """Smooth points as one vertex each, then the split vertices of the rough ones."""
    source, new_of_corner = split_vertices(point, hard_normals)
    kept = ~rough
    number = np.cumsum(kept, dtype=np.int32) - 1
    triangles = number[corners].ravel()
    triangles[hard] = new_of_corner + np.count_nonzero(kept)
    return Shaded(np.concatenate([points[kept], points[point[source]]]), np.concatenate([smooth[kept], hard_normals[source]]),
                  triangles.reshape(-1, 3))


def _crease_means(own: np.ndarray, weights: np.ndarray, point: np.ndarray, min_cos: float) -> np.ndarray:
    """(N, 3) crease normal of N corners with face normal `own`, by comparing every two corners of a point; in chunks of bounded memory."""
    order = np.argsort(point, kind="stable")
    own, weighted = own[order], (own * weights[:, None])[order]
    new = _differs(point[order])
    start = np.flatnonzero(new)
    group = np.cumsum(new) - 1
    size = np.diff(np.append(start, len(order)))[group]
    start = start[group]
    alone = size > MAX_VALENCE
    size[alone], start[alone] = 1, np.flatnonzero(alone)
    ends = np.cumsum(size)
    result = np.empty_like(own)
    first = 0
    while first < len(order):
        done = ends[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(ends, done + PAIRS_AT_ONCE, side="right")))
        result[first:last] = _chunk_means(own, weighted, start[first:last], size[first:last], first, min_cos)
        first = last
    unsorted = np.empty_like(result)
    unsorted[order] = result
    return unsorted


def _chunk_means(own: np.ndarray, weighted: np.ndarray, start: np.ndarray, size: np.ndarray, first: int, min_cos: float) -> np.ndarray:
    me = np.repeat(np.arange(len(size)), size)
    begin = np.cumsum(size) - size
    other = np.arange(len(me)) + (start - begin)[me]
    columns = [(own[first:first + len(size), k][me], own[:, k][other]) for k in range(3)]
    near = columns[0][0] * columns[0][1] + columns[1][0] * columns[1][1] + columns[2][0] * columns[2][1] >= min_cos - 1e-6
    total = [np.add.reduceat(weighted[:, k][other] * near, begin) for k in range(3)]
    return np.stack(total, axis=1) / np.sqrt(_dot(total, total))[:, None]


def shade_by_corners(positions: np.ndarray, triangles: np.ndarray, corner_normals: np.ndarray) -> Shaded:
    """Claim: vertices split just where the given (T, 3, 3) unit normals of their corners differ."""
    normals = corner_normals.reshape(-1, 3)
    vertex = triangles.ravel()
    source, new_of_corner = split_vertices(vertex, normals)
    return Shaded(positions[vertex[source]], normals[source], new_of_corner.reshape(-1, 3))


def split_vertices(vertex: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Claim: `source` (U,) a corner for each new vertex and `new_of_corner` (C,) int32; corners share a new vertex only if their
    `vertex` (C,) is the same and their `normals` (C, 3) agree to 1/2¹⁵, the step of a 16-bit normal.

    Exact but for a collision of 64-bit hashes (in which case corners are split once more, never joined wrongly).
    """
    steps = np.rint(normals * np.float32(32767.0)).astype(np.int64)
    key = ((steps[:, 0] + 32768) << 34) | ((steps[:, 1] + 32768) << 17) | (steps[:, 2] + 32768)
    mixed = (key.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)) ^ (vertex.astype(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F))
    order = np.argsort(mixed)
    new = _differs(key[order]) | _differs(vertex[order])
    new_of_corner = np.empty(len(order), dtype=np.int32)
    new_of_corner[order] = np.cumsum(new, dtype=np.int32) - 1
    return order[new], new_of_corner
