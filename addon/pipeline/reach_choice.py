"""How sums over many lights are made. Data only, no OpenGL."""

from __future__ import annotations

from dataclasses import dataclass

from ..settings.groups import ShadowTestChoice

EXACT = ShadowTestChoice(kind="triangle", outlines=True)
"""With the parts that are thinner than a map's texels."""
TIMES, COSINES = 0, 1
"""What is summed, SUMS of `shaders/reach_sums.frag`: weights of the lights that reach front and back; or with the cosine, of the front,
from all round, from above the horizon by brightness, from below it, and without anything in the way."""


@dataclass(frozen=True, slots=True)
class ReachChoice:
    """Texels a side of every map, the shadow test, and what is summed."""

    size: int = 1024
    test: ShadowTestChoice = EXACT
    sums: int = TIMES
