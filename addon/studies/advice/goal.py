"""What is wanted of the advice: the least error for a budget of texels, or the least budget for an error."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, isqrt, sqrt

from ...maths.choices import require

SMALLEST_MAP, LARGEST_MAP = 16, 8192
GRAIN = 8  # map sizes are multiples of this
MOST_FRAMES = 12  # of an animation that are looked at
REFERENCE_MAP = 1024  # where an error is measured when the size is the question: m falls with the number of texels


@dataclass(frozen=True, slots=True)
class Goal:
    """Exactly one of: `texels`, the budget of all maps together; `error`, the m (pixels per texel) that 95 % of the pixels keep below."""

    texels: int | None = None
    error: float | None = None

    def __post_init__(self) -> None:
        require((self.texels is None) != (self.error is None), "Ask for advice with either a number of texels or a wanted error.")
        require(self.texels is None or self.texels >= SMALLEST_MAP**2, f"The budget must be at least {SMALLEST_MAP**2} texels.")
        require(self.error is None or 0.0 < self.error < 1e6, "The wanted error must be a positive number of pixels per texel.")

    def size_to_measure(self, maps: int) -> int | None:
        """Texels per side with which `maps` maps are measured; None when the budget cannot pay for so many."""
        if self.texels is None:
            return REFERENCE_MAP
        size = isqrt(self.texels // maps) // GRAIN * GRAIN
        return min(size, LARGEST_MAP) if size >= SMALLEST_MAP else None

    def size_for(self, measured_size: int, m_p95: float | None) -> int | None:
        """Texels per side to propose after measuring `m_p95` at `measured_size`: m ∝ 1/size². None where `LARGEST_MAP` would not do."""
        if self.error is None:
            return measured_size
        if m_p95 is None:
            return None
        size = max(ceil(measured_size * sqrt(m_p95 / self.error) / GRAIN) * GRAIN, SMALLEST_MAP)
        return size if size <= LARGEST_MAP else None


def picked_frames(first: int, last: int) -> tuple[int, ...]:
    """At most `MOST_FRAMES` frames from `first` to `last` ≥ `first`, evenly picked, both ends among them."""
    count = min(MOST_FRAMES, last - first + 1)
    return tuple(first + round(i * (last - first) / max(count - 1, 1)) for i in range(count))
