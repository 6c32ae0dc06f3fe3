"""Light from the sky: frozen and checked; defaults are written here."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..maths.domains import one_of, require_fields, within
from ..maths.sky import SKY_TYPES

QUICK_SAMPLES = 16  # at most, of pictures that shall be quick
SKIES = ("off", "uniform", "cie", "overcast", "scene")


@dataclass(frozen=True, slots=True)
class SkyChoice:
    """How ambient light arrives: `kind` 'off' as if nothing stood in its way; else what the sky and the ground round a surface send it is
    stopped by what stands before them. 'uniform' is equally bright all over, 'overcast' and 'cie', the clear one, are skies of the CIE; all
    light level ground alike. 'scene' is 'uniform' in the colours of the scene's world, whatever ambient light was chosen by hand.
    `samples`: directions that it comes from."""

    kind: str = one_of("off", "Sky", SKIES)
    samples: int = within(64, "The number of sky samples", 4, 4096)

    def __post_init__(self) -> None:
        require_fields(self)

    @property
    def luminance(self) -> str:
        """Which of the skies of `maths.sky` it is."""
        return self.kind if self.kind in SKY_TYPES else "uniform"

    @property
    def quick(self) -> SkyChoice:
        """The same in few samples: of the first picture of a view that is refined afterwards."""
        return replace(self, samples=min(self.samples, QUICK_SAMPLES))
