"""One shadow map as the theory sees it: its stretch of the view, its warp; and the maps that a choice of warp and partition asks for.

The theory's P just holds the view frustum; the maps that are really drawn are fitted to scene and receivers in `shadow/fit.py`. Sources: T4
§4.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, log1p, pi, sin, tan

import numpy as np

from ..choices import PartitionChoice, WarpChoice
from ..shadow.partitions import split_distances
from ..shadow.warps import warp_parameter
from ..warping.formulas import faded_bend, warp_depth

Values = float | np.ndarray


@dataclass(frozen=True, slots=True)
class WarpedMap:
    """One map over view depths [near, far] of a view of half field φ > 0, lit at γ, by a directional light; P just holds the view frustum.

    `parameter` n' ∈ (0, ∞] metres. `logarithmic`: t runs with ln w instead of 1/w; `perspective_s`: s is divided by w; `bend` = 1/b of
    the log map (LogPSM 5.47).
    """

    near: float
    far: float
    half_fov_rad: float
    gamma_rad: float = pi / 2.0
    parameter: float = inf
    logarithmic: bool = False
    perspective_s: bool = True
    bend: float = 0.0

    @property
    def depth(self) -> float:
        """f' − n', metres (T4 (36))."""
        return warp_depth(self.near, self.far, self.half_fov_rad, self.gamma_rad)

    def offset(self, z: Values) -> Values:
        """ψ − n' (T4 (35), (37)): how far, along z_ls, the point of the view axis at depth z lies behind P's near plane; metres."""
        s, c, t = sin(self.gamma_rad), cos(self.gamma_rad), tan(self.half_fov_rad)
        if self.gamma_rad < self.half_fov_rad:
            return self.far * t * c + (z - self.far) * s
        return self.near * t * c + (z - self.near) * s


def partition_maps(
    near: float, far: float, half_fov_rad: float, gamma_rad: float, warp: WarpChoice, partition: PartitionChoice
) -> tuple[WarpedMap, ...]:
    """The maps the choices ask for, near to far. With faces: a side face's, as for light ⟂ view (a face keeps its warp at every γ)."""
    angle = pi / 2.0 if partition.uses_faces else gamma_rad
    splits = split_distances(partition, near, far, gamma_rad).tolist()
    return tuple(chosen_map(n, f, half_fov_rad, angle, warp) for n, f in zip(splits[:-1], splits[1:], strict=True))


def chosen_map(near: float, far: float, half_fov_rad: float, gamma_rad: float, warp: WarpChoice) -> WarpedMap:
    """The map of one choice of warp over view depths [near, far]."""
    parameter = warp_parameter(warp, near, far, half_fov_rad, gamma_rad)
    bend = 0.0
    if warp.method.bends and parameter < inf:
        bend = faded_bend(warp.log_bend, near, far, log1p(warp_depth(near, far, half_fov_rad, gamma_rad) / parameter))
    return WarpedMap(near, far, half_fov_rad, gamma_rad, parameter, warp.method.log is not None, warp.method.log is not False, bend)
