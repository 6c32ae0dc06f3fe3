"""The jump of the error at the border of two partitions: what the eye sees as a seam (T4 §4.3.2, figure 27). Theory, not measurement."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..choices import PartitionChoice, WarpChoice
from .aliasing import beam_error_z, error_x
from .warped_map import WarpedMap, partition_maps


@dataclass(frozen=True, slots=True)
class Seam:
    """A border at view depth `z`: m_x and m_z just before and just behind it, resolution terms 1. m_z is beam over beam, as in an image."""

    z: float
    m_x: tuple[float, float]
    m_z: tuple[float, float]

    @property
    def jump_x(self) -> float:
        """m_x behind over m_x before: 1 is no seam; above 1 the texels grow behind the border."""
        return self.m_x[1] / self.m_x[0]

    @property
    def jump_z(self) -> float:
        """m_z behind over m_z before."""
        return self.m_z[1] / self.m_z[0]


def seams(near: float, far: float, half_fov_rad: float, gamma_rad: float, warp: WarpChoice, partition: PartitionChoice) -> tuple[Seam, ...]:
    """Every border between z partitions, near to far; empty for one partition. Domain as `theory`, φ > 0.

    The jumps do not depend on the resolutions as long as all partitions have the same texels.
    """
    maps = partition_maps(near, far, half_fov_rad, gamma_rad, warp, partition)

    def pair(error: Callable[[WarpedMap, float], float | np.ndarray], before: WarpedMap, behind: WarpedMap) -> tuple[float, float]:
        return float(error(before, before.far)), float(error(behind, behind.near))

    return tuple(Seam(a.far, pair(error_x, a, b), pair(beam_error_z, a, b)) for a, b in zip(maps[:-1], maps[1:], strict=True))
