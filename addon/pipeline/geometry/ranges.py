"""A best-fit allocator of ranges in a growing buffer. Pure Python; knows nothing of GL.

Free ranges are kept by where they start and by how long they are: to take or to give back costs a search in each, however many there are.
"""

from __future__ import annotations

from bisect import bisect_left, insort


class Ranges:
    """Ranges [start, start + count) of a capacity that grows by doubling, and beyond `most` only as far as it must."""

    def __init__(self, capacity: int, most: int | None = None) -> None:
        self.capacity = capacity if most is None else min(capacity, most)
        self._most = most
        self._free: list[tuple[int, int]] = []  # (start, count), sorted
        self._by_count: list[tuple[int, int]] = []  # (count, start), sorted
        self._keep(0, self.capacity)

    def allocate(self, count: int) -> int | None:
        """The start of a free range of that many units, or None when none is long enough (then `grow`)."""
        if count <= 0:
            return 0
        i = bisect_left(self._by_count, (count, -1))
        if i == len(self._by_count):
            return None
        length, start = self._by_count[i]
        self._drop(start, length)
        self._keep(start + count, length - count)
        return start

    def grow(self, needed: int) -> None:
        """Raise the capacity so that `needed` contiguous units are free."""
        target = self.capacity
        while target - self.capacity < needed:
            target *= 2
        if self._most is not None and target > self._most:
            target = max(self._most, self.capacity + needed)
        self.free(self.capacity, target - self.capacity)
        self.capacity = target

    def free(self, start: int, count: int) -> None:
        """Give a range back; it merges with its free neighbours."""
        if count <= 0:
            return
        i = bisect_left(self._free, (start, 0))
        if i < len(self._free) and self._free[i][0] == start + count:
            count += self._free[i][1]
            self._drop(*self._free[i])
        if i and sum(self._free[i - 1]) == start:
            start, before = self._free[i - 1]
            count += before
            self._drop(start, before)
        self._keep(start, count)

    def _keep(self, start: int, count: int) -> None:
        if count > 0:
            insort(self._free, (start, count))
            insort(self._by_count, (count, start))

    def _drop(self, start: int, count: int) -> None:
        del self._free[bisect_left(self._free, (start, count))]
        del self._by_count[bisect_left(self._by_count, (count, start))]
