"""How many lights there are, and how soft their shadows: frozen and checked; defaults are written here."""

from __future__ import annotations

from dataclasses import dataclass

from ..maths.domains import one_of, require_fields, within

WHICH = ("all", "one")
MOST_SAMPLES = 4096
SOFTEST = 100.0


@dataclass(frozen=True, slots=True)
class LightsChoice:
    """Which lights of a scene light the picture, and from how many places each.

    `which` 'all' that reach what is seen, or 'one', the light that lights most of it. `samples`: hard lights that stand for one with a
    size; 0: its middle alone. `softness`: so many times its size. `sun_angle_deg` of a sun's disc, None: its own.
    """

    which: str = one_of("all", "Lights", WHICH)
    samples: int = within(0, "The number of light samples", 0, MOST_SAMPLES)
    softness: float = within(1.0, "The softness", 0.0, SOFTEST)
    sun_angle_deg: float | None = within(None, "The sun's angle (degrees)", 0.0, 180.0)

    def __post_init__(self) -> None:
        require_fields(self)
