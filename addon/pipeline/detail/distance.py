"""Hausdorff's distance between a mesh and a coarser one collapsed from it, measured at points of both. Numpy only.

Points are the corners, the middles of edges and the centres of triangles. A collapse says which corner every corner has come to: the
facets that meet there give an upper bound for each point, and only points whose bound is above the largest distance found so far are
measured against all facets, the worst first. So the number is the largest distance of all points, not an estimate of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..geometry.clusters import morton

PAIRS_AT_ONCE = 1 << 14
POINTS_AT_ONCE = 128
LEAF = 32
Columns = list[np.ndarray]


@dataclass(frozen=True, eq=False)
class Surface:
    """`points` (V, 3) float64, `triangles` (T, 3), and the `corners` (T, 3) of both meshes' common numbering that they belong to."""

    points: np.ndarray
    triangles: np.ndarray
    corners: np.ndarray


def hausdorff(one: Surface, other: Surface) -> float:
    """The largest distance of a point of either surface from the other."""
    return max(farthest(one, other), farthest(other, one))


def farthest(surface: Surface, facets: Surface) -> float:
    """The largest distance of a point of `surface` from `facets`."""
    places, shared = _places(surface)
    bound, _ = _nearest_sharing(places, shared, facets)
    order = np.argsort(-bound)
    worst, leaves = 0.0, None
    for at in range(0, len(order), POINTS_AT_ONCE):
        some = order[at : at + POINTS_AT_ONCE]
        some = some[bound[some] > worst * worst]
        if not len(some):
            break
        leaves = leaves or _Leaves(facets)
        worst = max(worst, float(np.sqrt(leaves.squared(places[some], bound[some]).max())))
    return worst


def sources(coarse: Surface, fine: Surface) -> np.ndarray:
    """(T,) the triangle of the fine surface nearest to the middle of each of the coarse one, of those that share a corner with it."""
    middles = coarse.points[coarse.triangles].mean(axis=1)
    return _nearest_sharing(middles, coarse.corners, fine)[1]


def _places(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Points (P, 3) of a surface, and the corners (P, 3) that each belongs to."""
    p, t, c = surface.points[surface.triangles], surface.triangles, surface.corners
    places, shared = [p.mean(axis=1)], [c]
    used, first = np.unique(t, return_index=True)
    places.append(surface.points[used])
    shared.append(np.repeat(c.reshape(-1)[first][:, None], 3, axis=1))
    for k, n in ((0, 1), (1, 2), (2, 0)):
        places.append(0.5 * (p[:, k] + p[:, n]))
        shared.append(c[:, [k, n, n]])
    return np.concatenate(places), np.concatenate(shared)


def _nearest_sharing(places: np.ndarray, shared: np.ndarray, facets: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Squared distance (P,) of places (P, 3) from the nearest facet that shares one of their corners (P, 3), and that facet; ∞ and −1
    where none does."""
    flat = facets.corners.ravel()
    order = np.argsort(flat, kind="stable")
    begins = np.searchsorted(flat[order], np.arange(int(max(shared.max(initial=0), flat.max(initial=0))) + 2))
    order //= 3
    squared, facet = np.full(len(places), np.inf), np.full(len(places), -1, np.int64)
    columns = _corner_columns(facets)
    for rows in _some(begins, shared):
        row, own = _pairs(begins, order, shared[rows])
        if len(row):
            found = _squared([places[rows, k][row] for k in range(3)], [[x[own] for x in corner] for corner in columns])
            begin = np.flatnonzero(np.diff(row, prepend=-1))
            squared[rows.start + row[begin]] = np.minimum.reduceat(found, begin)
            best = found == squared[rows][row]
            facet[rows.start + row[best]] = own[best]
    return squared, facet


def _some(begins: np.ndarray, shared: np.ndarray) -> Iterator[slice]:
    """Rows of `shared` with about `PAIRS_AT_ONCE` facets at their corners."""
    ends = np.cumsum(_counts(begins, shared).sum(axis=1))
    first = 0
    while first < len(ends):
        last = max(first + 1, int(np.searchsorted(ends, (ends[first - 1] if first else 0) + PAIRS_AT_ONCE, side="right")))
        yield slice(first, last)
        first = last


def _counts(begins: np.ndarray, shared: np.ndarray) -> np.ndarray:
    """How many facets meet at each corner of a row, those named twice counted once."""
    counts = begins[shared + 1] - begins[shared]
    counts[:, 1] *= shared[:, 1] != shared[:, 0]
    counts[:, 2] *= (shared[:, 2] != shared[:, 0]) & (shared[:, 2] != shared[:, 1])
    return counts


def _pairs(begins: np.ndarray, order: np.ndarray, shared: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every row with every facet at its corners, rows rising: (P,) rows, (P,) facets."""
    counts = _counts(begins, shared).ravel()
    starts = np.repeat(begins[shared.ravel()] - (np.cumsum(counts) - counts), counts)
    return np.repeat(np.arange(len(counts)) // 3, counts), order[starts + np.arange(int(counts.sum()))]


class _Leaves:
    """Facets in spatial order, some in a box."""

    def __init__(self, facets: Surface) -> None:
        order = np.argsort(morton(facets.points[facets.triangles[:, 0]]), kind="stable")
        self._columns = [[x[order] for x in corner] for corner in _corner_columns(facets)]
        self._begins = np.arange(0, len(order), LEAF)
        self._ends = np.append(self._begins[1:], len(order))
        self._low = [np.minimum.reduceat(np.minimum.reduce([c[k] for c in self._columns]), self._begins) for k in range(3)]
        self._high = [np.maximum.reduceat(np.maximum.reduce([c[k] for c in self._columns]), self._begins) for k in range(3)]

    def squared(self, places: np.ndarray, bound: np.ndarray) -> np.ndarray:
        """(P,) squared distances of places (P, 3) from the nearest facet, which `bound` (P,) are not below."""
        away = np.zeros((len(places), len(self._begins)))
        for k in range(3):
            x = places[:, k, None]
            away += np.square(np.maximum(np.maximum(self._low[k] - x, x - self._high[k]), 0.0))
        best = bound.copy()
        nearest = away.argmin(axis=1)
        self._take(places, np.arange(len(places)), nearest, best)
        away[np.arange(len(places)), nearest] = np.inf
        row, leaf = np.nonzero(away < best[:, None])
        for at in range(0, len(row), PAIRS_AT_ONCE // LEAF):
            self._take(places, row[at : at + PAIRS_AT_ONCE // LEAF], leaf[at : at + PAIRS_AT_ONCE // LEAF], best)
        return best

    def _take(self, places: np.ndarray, row: np.ndarray, leaf: np.ndarray, best: np.ndarray) -> None:
        """Lower `best` (P,) by the facets of some leaves."""
        counts = (self._ends - self._begins)[leaf]
        own = np.repeat(self._begins[leaf] - (np.cumsum(counts) - counts), counts) + np.arange(int(counts.sum()))
        rows = np.repeat(row, counts)
        found = _squared([places[rows, k] for k in range(3)], [[x[own] for x in corner] for corner in self._columns])
        np.minimum.at(best, rows, found)


def _corner_columns(facets: Surface) -> list[Columns]:
    """Columns x, y, z of the three corners."""
    return [[np.ascontiguousarray(facets.points[facets.triangles[:, c], k]) for k in range(3)] for c in range(3)]


@np.errstate(under="ignore")
def _squared(p: Columns, corners: list[Columns]) -> np.ndarray:
    """(P,) squared distance of points from triangles: to the plane where the foot lies inside, else to the nearest edge."""
    edges = [_minus(corners[k - 2], corners[k]) for k in range(3)]
    offsets = [_minus(p, corner) for corner in corners]
    normal = _cross(edges[0], edges[1])
    area = np.maximum(_dot(normal, normal), 1e-300)
    inside, best = np.ones(len(p[0]), bool), np.full(len(p[0]), np.inf)
    for edge, offset in zip(edges, offsets, strict=True):
        inside &= _dot(_cross(edge, offset), normal) >= 0.0
        along = np.clip(_dot(offset, edge) / np.maximum(_dot(edge, edge), 1e-300), 0.0, 1.0)
        away = [o - along * e for o, e in zip(offset, edge, strict=True)]
        np.minimum(best, _dot(away, away), out=best)
    return np.where(inside, _dot(offsets[0], normal) ** 2 / area, best)


def _minus(a: Columns, b: Columns) -> Columns:
    return [x - y for x, y in zip(a, b, strict=True)]


def _cross(a: Columns, b: Columns) -> Columns:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _dot(a: Columns, b: Columns) -> np.ndarray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
