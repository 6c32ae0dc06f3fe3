"""What the program knows of a partition scheme, and the view that it divides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class DividedView:
    """View depths [near, far], 0 < near < far, to be divided in `count`, the light at γ ∈ [0, π/2]; and what the user has set."""

    near: float
    far: float
    count: int
    gamma_rad: float
    split_weight: float
    pseudo_near: float | None
    alphas: tuple[float, ...] | None


@dataclass(frozen=True, slots=True, eq=False)
class PartitionScheme:
    """One scheme.

    `name` in settings and on the command line; `place` in menus, `label` and `text` there. `splits` gives the (count + 1,) depths, near to
    far, strictly increasing. `divides_depth` False: one slice, whatever the number set. `has_faces`: the side faces of the view frustum
    get maps of their own (T4 §4.3.1). `options`: those of the group `partition` that change something with it, beside number and cut.
    `parts_spots`: a spot's maps part its own picture instead (`shadow/lamps.py`). `advised`: the numbers of slices that advice tries.
    """

    name: str
    place: int
    label: str
    text: str
    splits: Callable[[DividedView], np.ndarray]
    divides_depth: bool = True
    has_faces: bool = False
    parts_spots: bool = False
    options: frozenset[str] = frozenset()
    advised: tuple[int, ...] = (1,)

    @property
    def is_divided(self) -> bool:
        """Whether there may be more than one map for a sun."""
        return self.divides_depth or self.has_faces
