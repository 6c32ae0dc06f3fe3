"""The result of fitting: one `ShadowProjection` per partition, gathered in a `ShadowPlan`. Data only; `fit.py` makes them."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, log

import numpy as np

LEAST_DIVISOR = 1e-6


@dataclass(frozen=True, slots=True)
class LogWarp:
    """The logarithmic step after the projective one, on the t axis only (LogPSM 5.39, 5.43); for the sun only.

    With (X, Y, Z, w) = clip_from_world · p, where w is the distance to the apex of P in units of n' (1 … f'/n'):
    t = scale · log2(w/(base + slope · w)) + offset, depth = Z (undivided: linear in the light depth),
    s = X/w if `perspective_s` (logpsm) else X (log). base + slope · w = 1 + bend · v, v ∈ [0, 1] over the receivers: LogPSM 5.43 for
    `bend` 0 (base 1, slope 0), 5.47–5.51 with b = 1/bend for others (only with `perspective_s`).
    Y/w is the projective t of the same map: it covers exactly the same strip of the world ([−1, 1] ↔ [−1, 1]) with other spacing.
    `near` is n', `far` is f', metres along z_ls.
    """

    near: float
    far: float
    scale: float
    offset: float
    perspective_s: bool = True
    bend: float = 0.0
    base: float = 1.0
    slope: float = 0.0

    def t_at(self, w: np.ndarray | float) -> np.ndarray:
        """t of w > 0; beyond the zero of the divisor, where no map reaches, it is kept large and finite."""
        return self.scale * np.log2(w / np.maximum(self.base + self.slope * w, LEAST_DIVISOR)) + self.offset

    def w_at(self, t: np.ndarray | float) -> np.ndarray:
        """w of t, the inverse of `t_at`."""
        ratio = np.exp2((t - self.offset) / self.scale)
        return self.base * ratio / (1.0 - self.slope * ratio)

    def t_rate(self, w: np.ndarray) -> np.ndarray:
        """dt/dw."""
        return self.scale / log(2.0) * self.base / (w * np.maximum(self.base + self.slope * w, LEAST_DIVISOR))


@dataclass(frozen=True, eq=False)
class ShadowProjection:
    """One shadow map: where a world point falls in it, and which receivers it serves.

    `clip_from_world` (4, 4) float64: NDC after division by w is (s, t, depth), depth growing away from the light, w > 0 on every receiver.
    w is 1 on the near plane of P and f'/n' on its far plane (sun; a finite light multiplies it by the distance along its axis).
    With `log` set, s, t and depth are what `LogWarp` says.
    `near`, `far`: view-depth bounds [near, far) of the receivers served; `fitted_range` (≤ them) the view depths the warp was made for.
    `region_planes_ws` (P, 4): P ≤ 4 planes (a, b, c, d) with a·x + b·y + c·z + d ≥ 0 inside, that bound the receivers served too: faces
    of the view frustum, of a point light's cube, cuts along the light's rays (`is_cut_along_light`: `near`, `far` are the whole view's).
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
    fitted_range: tuple[float, float] = (0.0, 0.0)
    is_cut_along_light: bool = False

    @property
    def depth_range(self) -> tuple[float, float]:
        """View depths of what it serves: its bounds, or what it was fitted to where planes along the light part the view."""
        return self.fitted_range if self.is_cut_along_light else (self.near, self.far)


@dataclass(frozen=True, eq=False)
class ShadowPlan:
    """All the maps of one light for one view, in the order the shader asks: the first whose bounds and planes hold serves the pixel.

    `light_from_world` (4, 4): for the sun Wimmer's axes as a rotation about the world's origin (light depth = −y_ls); for a finite light
    the homogeneous rows (X, Y, Z, R) of `light_space.py` (of the first face for a point light). `origin_ws` (3,), exact in float32, a place
    near what the camera sees: relative to it float32 loses
    nothing that would be seen; `nearest` the least view depth of the receivers. `gamma_rad`, `gamma_lim_rad` of the view.
    """

    projections: tuple[ShadowProjection, ...]
    gamma_rad: float
    gamma_lim_rad: float
    light_from_world: np.ndarray
    origin_ws: np.ndarray = field(default_factory=lambda: np.zeros(3))
    nearest: float = 0.0
    warnings: tuple[str, ...] = ()
