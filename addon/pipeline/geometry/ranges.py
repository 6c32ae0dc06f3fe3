"""A first-fit allocator of ranges in a growing buffer. Pure Python; knows nothing of GL."""

from __future__ import annotations

from bisect import insort


class Ranges:
    """Ranges [start, start + count) of a capacity that grows by doubling, and beyond `most` only as far as it must."""

    def __init__(self, capacity: int, most: int | None = None) -> None:
        self.capacity = capacity if most is None else min(capacity, most)
        self._most = most
        self._free: list[tuple[int, int]] = [(0, self.capacity)]

    def allocate(self, count: int) -> int | None:
        """The start of a free range of that many units, or None when none is long enough (then `grow`)."""
        for i, (start, length) in enumerate(self._free):
            if length >= count:
                if length == count:
                    del self._free[i]
                else:
                    self._free[i] = (start + count, length - count)
                return start
        return None

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
        insort(self._free, (start, count))
        merged: list[tuple[int, int]] = []
        for s, c in self._free:
            if merged and merged[-1][0] + merged[-1][1] == s:
                merged[-1] = (merged[-1][0], merged[-1][1] + c)
            else:
                merged.append((s, c))
        self._free = merged
