"""The warp parameter n' of the choice made: by its method, or by hand.

Every parameter here is positive or ∞, never NaN, continuous in γ, and ∞ at γ = 0, where the warp has no direction. The formulas and the
methods are those of `warping`.
"""

from __future__ import annotations

from math import expm1, inf, isnan, log1p, pi, radians

from ..choices import WarpChoice, require
from ..warping.formulas import convergence, gamma_lim_rad, parameter_from_eta
from ..warping.row import WarpedView

EPSILON = 2.0**-52
"""n' is ∞ when n̄' > 1/ε, where no double tells f' from n', and at least ε (f'−n')."""

DIRECT_FADE_RAD = radians(5.0)
"""Below this γ even a parameter given by hand fades: z_ls, the warp's direction, turns over as the light passes through the view axis."""


def warp_parameter(
    choice: WarpChoice,
    near: float,
    far: float,
    half_fov_rad: float,
    gamma_rad: float,
    sub_near: float | None = None,
    sub_far: float | None = None,
) -> float:
    """n' in metres of one map over view depths [near, far]; ∞ = uniform. In (0, ∞], never NaN, continuous in γ, ∞ at γ = 0.

    `sub_near`, `sub_far`: the view depths whose error counts, when less than the map covers (default all; `choice.pseudo_near` raises
    `sub_near`). A map that ends before the pseudo-near plane is uniform (LogPSM 5.65 for v_np > 2/3).
    ∞ where there is nothing to warp for: an orthographic camera (φ = 0) sees every depth alike, and near ≥ far is an empty range.
    The methods are those of `warping`; `choice.eta` and `choice.parameter` override them. Raises SettingsError on NaN.
    """
    require(not any(isnan(x) for x in (near, far, half_fov_rad, gamma_rad)), "The view's distances and angles must be numbers.")
    gamma_rad = min(max(gamma_rad, 0.0), pi / 2.0)
    if half_fov_rad <= 0.0 or gamma_rad == 0.0 or not near < far:
        return inf
    require(near > 0.0 and far < inf and half_fov_rad < pi / 2.0, "A perspective view needs 0 < near < far and a field of view below 180°.")
    z2 = far if sub_far is None else min(max(sub_far, near), far)
    z1 = min(max(near, near if sub_near is None else sub_near, choice.pseudo_near or near), z2)
    view = WarpedView(near, far, half_fov_rad, gamma_rad, z1, z2, choice.convergence)
    by_hand = choice.parameter is not None or choice.eta is not None
    parameter = _direct_parameter(choice, view) if by_hand else choice.method.parameter(view)
    return inf if parameter > view.depth / EPSILON else max(parameter, view.depth * EPSILON)


def _direct_parameter(choice: WarpChoice, view: WarpedView) -> float:
    """n' given by hand, as n' or as η, faded only below `DIRECT_FADE_RAD`."""
    if choice.eta is not None:
        parameter = parameter_from_eta(choice.eta, view.near, view.far, view.depth, view.balanced)
    else:
        parameter = inf if choice.parameter is None else choice.parameter
    limit = min(gamma_lim_rad(view.near, view.far, view.half_fov_rad), DIRECT_FADE_RAD)
    if view.gamma_rad >= limit or parameter == inf:
        return parameter
    return _faded(parameter, view.depth, convergence(view.gamma_rad, limit, choice.convergence))


def _faded(parameter: float, depth: float, r: float) -> float:
    """The n' whose ln(f'/n') is r times its own: every warp strength fades alike, however small its n' was."""
    grown = expm1(min(log1p(depth / parameter), 600.0) * r)
    return depth / grown if grown > 0.0 else inf
