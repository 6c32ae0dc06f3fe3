"""Which triangle lies across each edge, beside the index pool: the exact test walks over a surface by it. Worker thread only.

Made for a part when a frame first asks for it; scenes that are never tested exactly pay nothing.
"""

from __future__ import annotations

from collections.abc import Iterable

import moderngl
import numpy as np

from ...scene.mesh_prep import weld

BORDER = 0xFFFFFFFF  # nothing across the edge
SEVERAL = 0xFFFFFFFE  # more than one triangle: no telling which


def across_edges(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Claim: (T, 3) uint32, the triangle that shares the edge from corner k to corner k + 1, or `BORDER`, or `SEVERAL`.

    Corners are the same point where `positions` (V, 3) float32 are equal. Windings do not matter, and triangles with the same three corners
    (both sides of a sheet, as CAD writes it) count once: a link names the first. An edge without length has no other side: `SEVERAL`.
    """
    points, _ = weld(positions)
    corners = points[triangles]
    order = np.argsort(corners, axis=1, kind="stable")
    first = _first_copy(np.take_along_axis(corners, order, axis=1))
    kept = np.flatnonzero(first == np.arange(len(first)))
    if len(kept) == len(corners):
        return _across_distinct(corners)
    links = np.full(corners.shape, SEVERAL, np.uint32)
    found = _across_distinct(corners[kept])
    found[found < SEVERAL] = kept[found[found < SEVERAL]]
    links[kept] = found
    # a copy's edges may come in another order: by the corner across from each
    opposite = np.take_along_axis(np.roll(links, -1, axis=1), order, axis=1)[first]
    turned = np.empty_like(links)
    np.put_along_axis(turned, order, opposite, axis=1)
    return np.roll(turned, 1, axis=1)


def _first_copy(ranked: np.ndarray) -> np.ndarray:
    """(T,) the first triangle that has the same three corners as each; `ranked` (T, 3) points in rising order."""
    by_corners = np.lexsort(ranked.T)
    new = np.flatnonzero(np.append(True, (np.diff(ranked[by_corners], axis=0) != 0).any(axis=1))[: len(ranked)])
    first = np.empty(len(ranked), np.int64)
    first[by_corners] = np.repeat(np.minimum.reduceat(by_corners, new), np.diff(np.append(new, len(ranked))))
    return first


def _across_distinct(corners: np.ndarray) -> np.ndarray:
    """`across_edges` of triangles (T, 3) by points, no two with the same three."""
    start = corners.astype(np.uint64)
    end = np.roll(start, -1, axis=1)
    key = (np.minimum(start, end) << np.uint64(32) | np.maximum(start, end)).ravel()
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.append(True, key[order][1:] != key[order][:-1]))
    count = np.diff(np.append(first, len(order)))
    out = np.full(len(key), SEVERAL, np.uint32)
    out[order[first[count == 1]]] = BORDER
    one, other = order[first[count == 2]], order[first[count == 2] + 1]
    out[one], out[other] = other // 3, one // 3
    out[(start == end).ravel()] = SEVERAL
    return out.reshape(-1, 3)


class SurfaceLinks:
    """The pool of links, parallel to the index pool: three numbers of the pool's triangles for each of its triangles."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self.buffer: moderngl.Buffer | None = None
        self._done: dict[int, object] = {}

    def update(self, indices: moderngl.Buffer, parts: Iterable[tuple[object, np.ndarray, int, int, int]]) -> None:
        """Make what is missing for `parts`: (mesh, positions, first vertex, first index, index count) as they lie in the pools."""
        if self.buffer is None or self.buffer.size != indices.size:
            self.release()
            self.buffer = self._context.buffer(reserve=indices.size)
        there = {}
        for mesh, positions, first_vertex, first_index, count in parts:
            there[first_index] = mesh
            if self._done.get(first_index) is mesh:
                continue
            pool = np.frombuffer(indices.read(count * 4, offset=first_index * 4), np.uint32)
            links = across_edges(positions, (pool - np.uint32(first_vertex)).reshape(-1, 3))
            links[links < SEVERAL] += np.uint32(first_index // 3)
            self.buffer.write(links.tobytes(), offset=first_index * 4)
        self._done = there

    def drop(self, first_index: int) -> None:
        """The triangles from there on were written anew."""
        self._done.pop(first_index, None)

    def release(self) -> None:
        """Free the buffer."""
        if self.buffer is not None:
            self.buffer.release()
        self.buffer, self._done = None, {}
