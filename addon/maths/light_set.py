"""Many lights at infinity as one thing: their directions and what each counts for in a sum. numpy only."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .directions import sphere_directions
from .sky import sky_luminance


@dataclass(frozen=True, eq=False)
class LightSet:
    """`directions_ws` (N, 3) unit, towards the lights; `weights` (N,); `brightness` (N,) relative, 1 where not given."""

    directions_ws: np.ndarray
    weights: np.ndarray
    brightness: np.ndarray = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        if not len(self.brightness):
            object.__setattr__(self, "brightness", np.ones(len(self.weights)))

    def __len__(self) -> int:
        return len(self.weights)

    @property
    def key(self) -> tuple[bytes, bytes, bytes]:
        """Comparable and hashable."""
        return self.directions_ws.tobytes(), self.weights.tobytes(), self.brightness.tobytes()


def all_round(count: int, kind: str = "uniform", sun_ws: np.ndarray | None = None) -> LightSet:
    """Light from everywhere in `count` directions: ∫ max(n·ω, 0) dω / π is the sum of weights times cosines, 1 for every surface.

    Above the horizon their brightness is that of the sky of `kind` (`sky.SKY_TYPES`) under a sun in direction `sun_ws` (None: the zenith).
    """
    directions = sphere_directions(count)
    sun = np.array([0.0, 0.0, 1.0]) if sun_ws is None else sun_ws
    return LightSet(directions, np.full(count, 4.0 / count), sky_luminance(kind, directions, sun))
