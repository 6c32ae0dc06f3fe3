"""One flat polygon cut into triangles by clipping ears. Its ring may touch itself: bridges to holes, slits, corners on edges.

An ear is a corner whose triangle with its two neighbours holds nothing of the ring. Only corners that are not convex can be in the way
(Meisters 1975); they are kept in a grid, so that an ear is compared with those near it.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, isfinite, sqrt

Point = list[float]


def ears_clipped(points: list[Point]) -> list[tuple[int, int, int]]:
    """The n − 2 triangles of a polygon of n ≥ 3 finite counterclockwise points: they cover it once unless its ring crosses itself.

    Corners where the ring turns back on itself are clipped at once, those on a straight line last: triangles without an area.
    """
    ring = _Ring(points)
    triangles, corner, since, fresh = [], 0, 0, list(range(len(points)))
    while ring.left > 3:
        if fresh:
            found = fresh.pop()
            if not ring.is_fold(found):
                continue
        elif since > ring.left:
            found = ring.without_ear(corner)
        elif ring.is_ear(corner):
            found = corner
        else:
            corner, since = ring.next[corner], since + 1
            continue
        triangles.append(ring.clip(found))
        before, _, after = triangles[-1]
        corner, since = ring.next[after], 0  # not the neighbour: fewer slivers
        fresh += [before, after]
    return [*triangles, (ring.previous[corner], corner, ring.next[corner])]


def side(a: Point, b: Point, p: Point) -> float:
    """Twice the signed area of a, b, p: positive when p lies left of a → b."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


class _Ring:
    """What is left of the polygon: its corners in order, and those that are not convex in a grid."""

    def __init__(self, points: list[Point]) -> None:
        n = self.left = len(points)
        self.points = points
        self.next = [*range(1, n), 0]
        self.previous = [n - 1, *range(n - 1)]
        self._blocks = [self._turn(i) <= 0.0 for i in range(n)]
        self._grid = _Grid(points, [i for i in range(n) if self._blocks[i]])

    def _turn(self, i: int) -> float:
        return side(self.points[self.previous[i]], self.points[i], self.points[self.next[i]])

    def is_fold(self, i: int) -> bool:
        """Whether corner i is in the ring, and the ring leaves it the way it came, or stays where it is."""
        if self.next[self.previous[i]] != i or self._turn(i) != 0.0:
            return False
        a, b, c = (self.points[k] for k in (self.previous[i], i, self.next[i]))
        return (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]) >= 0.0

    def is_ear(self, i: int) -> bool:
        """Whether corner i is convex and nothing of the ring enters its triangle."""
        if self._turn(i) <= 0.0:
            return False
        own = (self.previous[i], i, self.next[i])
        triangle = self.points[own[0]], self.points[own[1]], self.points[own[2]]
        return not any(k not in own and self._blocks[k] and self._enters(k, *triangle) for k in self._grid.near(triangle))

    def _enters(self, k: int, a: Point, b: Point, c: Point) -> bool:
        """Whether corner k lies inside the triangle, or on its border with an edge that leads inside."""
        p = self.points[k]
        edges = ((a, b), (b, c), (c, a))
        sides = [side(*edge, p) for edge in edges]
        if min(sides) < 0.0:
            return False
        touched = [edge for edge, height in zip(edges, sides, strict=True) if height == 0.0]
        ends = (self.points[self.previous[k]], self.points[self.next[k]])
        return any(all(side(*edge, end) > 0.0 for edge in touched) for end in ends)

    def clip(self, i: int) -> tuple[int, int, int]:
        """The triangle of corner i, which leaves the ring; its neighbours may have become convex."""
        before, after = self.previous[i], self.next[i]
        self.next[before], self.previous[after] = after, before
        self._blocks[i] = False
        self.left -= 1
        for k in (before, after):
            self._blocks[k] = self._blocks[k] and self._turn(k) <= 0.0
        return before, i, after

    def without_ear(self, start: int) -> int:
        """The corner to clip where no ear is: one on a straight line, else a convex one (the ring crosses itself)."""
        corners = [start]
        while self.next[corners[-1]] != start:
            corners.append(self.next[corners[-1]])
        turns = [(self._turn(k), k) for k in corners]
        straight = (k for turn, k in turns if turn == 0.0)
        return next(straight, next((k for turn, k in turns if turn > 0.0), start))


class _Grid:
    """Corners by the cell they lie in, about one to a cell."""

    def __init__(self, points: list[Point], corners: list[int]) -> None:
        self._corners = corners
        xs, ys = zip(*(points[i] for i in corners), strict=True) if corners else ((0.0,), (0.0,))
        self._low = (min(xs), min(ys))
        size = max(max(xs) - self._low[0], max(ys) - self._low[1]) / ceil(sqrt(len(corners)) or 1)
        self._per_cell = 1.0 / size if size > 0.0 and isfinite(1.0 / size) else 0.0
        self._last = self._cell((max(xs), max(ys)))
        self._cells: dict[tuple[int, int], list[int]] = {}
        for i in corners:
            self._cells.setdefault(self._cell(points[i]), []).append(i)

    def _cell(self, point: Point | tuple[float, float]) -> tuple[int, int]:
        return int((point[0] - self._low[0]) * self._per_cell), int((point[1] - self._low[1]) * self._per_cell)

    def near(self, triangle: tuple[Point, Point, Point]) -> Iterator[int]:
        """All corners in cells that the triangle's bounding box touches, and no cell twice."""
        xs, ys = zip(*triangle, strict=True)
        left, low = (max(k - 1, 0) for k in self._cell((min(xs), min(ys))))
        right, high = (min(k + 1, last) for k, last in zip(self._cell((max(xs), max(ys))), self._last, strict=True))
        if (right - left + 1) * (high - low + 1) > len(self._corners):
            yield from self._corners
            return
        for x in range(left, right + 1):
            for y in range(low, high + 1):
                yield from self._cells.get((x, y), ())
