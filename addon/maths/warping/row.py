"""What the program knows of a warp, and the view that it is asked about."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sin

from .formulas import lloyd_eta, log_apex, log_apex_parameter, parameter_from_eta, pseudo_near_floor, pseudo_near_parameter, warp_depth

RATE = 0.16
"""How fast ln(f'/n') may grow with γ, per degree (`shadow/strength.py`)."""


@dataclass(frozen=True, slots=True)
class WarpedView:
    """One map over view depths [near, far], 0 < near < far, of a view of half angle φ > 0 whose light comes at γ ∈ (0, π/2].

    `sub_near` … `sub_far` are the depths whose error counts, all or some of them; `convergence` the way to uniform below γ_lim.
    """

    near: float
    far: float
    half_fov_rad: float
    gamma_rad: float
    sub_near: float
    sub_far: float
    convergence: str

    @property
    def depth(self) -> float:
        """f' − n', metres (T4 (36))."""
        return warp_depth(self.near, self.far, self.half_fov_rad, self.gamma_rad)

    @property
    def balanced(self) -> float:
        """n' for light ⟂ view that errs alike at both ends of the depths that count (T4 (27), LogPSM 5.64, 5.65)."""
        return pseudo_near_parameter(self.near, self.far, self.sub_near, self.sub_far)

    def by_eta(self, top: float) -> float:
        """n' by Lloyd's ramp η(γ), up to `top`."""
        eta = lloyd_eta(self.half_fov_rad, self.gamma_rad, top)
        parameter = parameter_from_eta(eta, self.near, self.far, self.depth, self.balanced)
        return max(parameter, self.depth * pseudo_near_floor((self.sub_near - self.near) * sin(self.gamma_rad) / self.depth))

    def by_apex(self, perspective_s: bool) -> float:
        """n' of a logarithmic map: the one that makes m_z the same at every depth that counts (LogPSM 5.41, §5.1.9)."""
        apex = log_apex(self.near, self.far, self.sub_near, perspective_s)
        return log_apex_parameter(self.near, self.far, self.half_fov_rad, self.gamma_rad, self.convergence, apex)


@dataclass(frozen=True, slots=True, eq=False)
class WarpMethod:
    """One warp.

    `name` in settings and on the command line; `place` in menus, `label` and `text` there. `parameter` gives n', positive or ∞,
    continuous in γ, ∞ as γ → 0. `is_warped` False: uniform whatever the view. `fades`: it takes the setting `convergence`. `log`: None
    where t is projective; where it is logarithmic, whether s is divided by w (`projection.LogWarp`). `bends`: it takes the setting
    `log_bend`. `slice_rate`: `RATE` for a slice along the light, whose own shape changes with γ too.
    """

    name: str
    place: int
    label: str
    text: str
    parameter: Callable[[WarpedView], float]
    is_warped: bool = True
    fades: bool = False
    log: bool | None = None
    bends: bool = False
    slice_rate: float = RATE
