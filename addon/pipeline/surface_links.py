"""Which triangle lies across each edge, beside the index pool: the exact test walks over a surface by it. Worker thread only.

Made for a part when a frame first asks for it; scenes that are never tested exactly pay nothing.
"""

from __future__ import annotations

from collections.abc import Iterable

import moderngl
import numpy as np

from .mesh_prep import weld

BORDER = 0xFFFFFFFF  # nothing across the edge
SEVERAL = 0xFFFFFFFE  # more than one triangle: no telling which


def across_edges(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Claim: (T, 3) uint32, the triangle that shares the edge from corner k to corner k + 1, or `BORDER`, or `SEVERAL`.

    Corners are the same point where `positions` (V, 3) float32 are equal. Windings do not matter. An edge without length has no other
    side: `SEVERAL`.
    """
    points, _ = weld(positions)
    start = points[triangles].astype(np.uint64)
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

    def release(self) -> None:
        """Free the buffer."""
        if self.buffer is not None:
            self.buffer.release()
        self.buffer, self._done = None, {}
