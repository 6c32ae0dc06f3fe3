"""The result of fitting: one `ShadowProjection` per partition, gathered in a `ShadowPlan`. Data only; `fit.py` makes them."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np


@dataclass(frozen=True, slots=True)
class LogWarp:
    """The logarithmic step after the projective one, on the t axis only (LogPSM 5.39, 5.43).

    The projective part of a log map sends w to the distance from the apex of P (so w runs from n' to f') and x to x/w (logpsm) or
    leaves it affine (log). Then `t = 2·log2(w/near)/log2(far/near) − 1`, in NDC. `near` is n', `far` is f', metres along z_ls.
    `perspective_s` tells whether s is divided by w (logpsm) or not (log).
    """

    near: float
    far: float
    perspective_s: bool = True


@dataclass(frozen=True, eq=False)
class ShadowProjection:
    """One shadow map: where a world point falls in it, and which receivers it serves.

    `clip_from_world` (4, 4) float64: NDC after division by w is (s, t, depth), depth growing away from the light, w > 0 on every receiver.
    With `log` set, t is replaced as `LogWarp` says (and s left undivided for plain 'log').
    `near`, `far`: view-depth bounds [near, far) of the receivers served. `region_planes_ws` (P, 4): P ≤ 4 planes (a, b, c, d) with
    a·x + b·y + c·z + d ≥ 0 inside, that contain the light's direction (faces; empty for z partitions).
    `warp_parameter` n' in metres (inf = uniform), `eta` its η (T4 (32)), `face` the index of the frustum's face or −1.
    `light_depth_range` (2,) metres: the light depths that map to NDC depth −1 and +1 at the map's centre.
    """

    clip_from_world: np.ndarray
    near: float
    far: float
    log: LogWarp | None = None
    region_planes_ws: np.ndarray = field(default_factory=lambda: np.empty((0, 4)))
    warp_parameter: float = inf
    eta: float = -1.0
    face: int = -1
    light_depth_range: tuple[float, float] = (0.0, 0.0)
    is_empty: bool = False


@dataclass(frozen=True, eq=False)
class ShadowPlan:
    """All the maps of one light for one view, in the order the shader asks: the first whose bounds and planes hold serves the pixel."""

    projections: tuple[ShadowProjection, ...]
    gamma_rad: float
    gamma_lim_rad: float
    light_from_world: np.ndarray
    warnings: tuple[str, ...] = ()
