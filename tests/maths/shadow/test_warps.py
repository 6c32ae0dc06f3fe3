"""Warp parameters and the maps t(v) against their definitions."""

from dataclasses import replace
from functools import partial
from math import atan, inf, log, log1p, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.choices import CONVERGENCES, WARPS, WarpChoice
from addon.maths.error.aliasing import error_z, max_error_x, max_error_z
from addon.maths.error.warped_map import WarpedMap
from addon.maths.shadow.crop import bent
from addon.maths.shadow.projection import LogWarp
from addon.maths.shadow.warps import DIRECT_FADE_RAD, warp_parameter
from addon.maths.warping.formulas import (
    convergence,
    eta_from_parameter,
    faded_bend,
    far_parameter,
    gamma_lim_rad,
    lispsm_general_parameter,
    lispsm_parameter,
    lloyd_eta,
    log_apex,
    omega_from_parameter,
    parameter_from_eta,
    parameter_from_omega,
    pseudo_near_floor,
    pseudo_near_parameter,
    tsm_eta,
    warp_depth,
)
from tests.margins import agree, at_most
from tests.maths import logpsm_forms as spacing
from tests.maths.logpsm_forms import base_error_log_t, base_error_s, base_error_t
from tests.maths.views import HOSTILE_ANGLES, HOSTILE_RATIOS, light_z, pyramid_depth, reals, views

OVERHEAD = pi / 2
bends = st.floats(-0.95, 100.0).filter(lambda bend: bend == 0.0 or abs(bend) > 1e-6)


close = partial(agree, rel=1e-9)


# --- P, γ_lim ---------------------------------------------------------------------------------------------------------------------


@given(views())
def test_p_is_as_deep_as_the_frustum_in_the_light_s_view(view):
    close(warp_depth(*view.shape), pyramid_depth(view))
    close(far_parameter(2.5, *view.shape), 2.5 + pyramid_depth(view))


@given(views(min_ratio=1.01))
def test_gamma_lim_is_where_near_and_far_plane_start_to_overlap(view):
    limit = gamma_lim_rad(view.near, view.far, view.phi)
    assert view.phi < limit <= pi / 2
    at_limit = type(view)(view.near, view.far, view.phi, limit)
    top_of_near = light_z(at_limit, view.near, view.near * tan(view.phi))
    bottom_of_far = light_z(at_limit, view.far, -view.far * tan(view.phi))
    agree(top_of_near, bottom_of_far, abs=1e-9 * view.far)


# --- the generalised LiSPSM -------------------------------------------------------------------------------------------------------


@given(views(max_ratio=1e7))
def test_generalised_lispsm_has_equal_errors_at_both_ends(view):
    gamma = max(view.gamma, gamma_lim_rad(view.near, view.far, view.phi))
    m = WarpedMap(view.near, view.far, view.phi, gamma, lispsm_general_parameter(view.near, view.far, view.phi, gamma))
    close(error_z(m, view.near), error_z(m, view.far))


@given(views(), st.floats(0.2, 5.0))
def test_generalised_lispsm_has_the_least_largest_m_z(view, factor):
    gamma = max(view.gamma, gamma_lim_rad(view.near, view.far, view.phi))
    best = lispsm_general_parameter(view.near, view.far, view.phi, gamma)
    least, other = (max_error_z(WarpedMap(view.near, view.far, view.phi, gamma, p)) for p in (best, best * factor))
    at_most(least / other - 1.0, 1e-12)


@given(views(max_ratio=1e7))
def test_overhead_parameters_are_those_of_the_texts(view):
    near, far, phi = view.near, view.far, view.phi
    for kind in ("lispsm", "lispsm-general", "lloyd"):
        close(warp_parameter(WarpChoice(kind), near, far, phi, OVERHEAD), near + sqrt(far * near))
    for kind in ("psm", "log", "logpsm"):
        close(warp_parameter(WarpChoice(kind), near, far, phi, OVERHEAD), near)
    assert warp_parameter(WarpChoice("uniform"), near, far, phi, OVERHEAD) == inf


@pytest.mark.parametrize("kind", CONVERGENCES)
def test_convergence_runs_smoothly_from_one_to_zero(kind):
    x = np.linspace(0.0, 1.0, 101)
    r = np.array([convergence(float(g), 1.0, kind) for g in x])
    expected = np.sin(x * pi / 2) if kind == "sine" else (1 + np.sin((x - 1) * pi / 2)) ** 2
    np.testing.assert_allclose(r, expected, atol=1e-12)
    assert (np.diff(r) > 0).all()


@given(views(), st.sampled_from(CONVERGENCES))
def test_below_gamma_lim_the_parameter_is_the_limit_s_over_r(view, kind):
    limit = gamma_lim_rad(view.near, view.far, view.phi)
    gamma = 0.2 * limit + 0.8 * limit * view.gamma / (pi / 2)
    n1 = lispsm_parameter(view.near, view.far) * sin(limit) - view.near * tan(view.phi) * np.cos(limit)
    close(warp_parameter(WarpChoice(convergence=kind), view.near, view.far, view.phi, gamma), n1 / convergence(gamma, limit, kind))


def test_wimmer_divides_by_the_sine():
    close(warp_parameter(WarpChoice("lispsm"), 1.0, 100.0, radians(30), radians(50)), 11.0 / sin(radians(50)))


def test_lloyd_s_ramp_passes_its_three_corners():
    phi = radians(30)
    high = phi + 0.3 * (pi / 2 - phi)
    assert lloyd_eta(phi, phi / 3) == -1.0 and lloyd_eta(phi, 0.0) == -1.0
    close(lloyd_eta(phi, phi), -0.2)
    assert abs(lloyd_eta(phi, high)) < 1e-12 and abs(lloyd_eta(phi, pi / 2)) < 1e-12
    ramp = [lloyd_eta(phi, float(g)) for g in np.linspace(0, pi / 2, 200)]
    assert (np.diff(ramp) >= 0).all()


@given(views(min_ratio=1.0))
def test_tsm_gives_eighty_per_cent_of_the_map_to_what_lies_before_its_focus(view):
    near, far = view.near, view.near * (16.0 + view.ratio)  # below f/n = 16 PSM's own warp bounds it
    n_bar = parameter_from_eta(tsm_eta(near, far), near, far) / (far - near)
    close(spacing.perspective_forward((sqrt(near * far) - near) / (far - near), n_bar), 0.8)
    assert tsm_eta(near, near * 15.9) == 1.0


# --- every method -----------------------------------------------------------------------------------------------------------------


def choices():
    plain = [WarpChoice(kind, convergence=r) for kind in WARPS for r in CONVERGENCES]
    return (
        plain
        + [WarpChoice(kind, pseudo_near=3.0) for kind in WARPS]
        + [*(WarpChoice(eta=eta) for eta in (-1.0, -0.3, 0.0, 1.0)), *(WarpChoice(parameter=p) for p in (1e-6, 2.0, 1e300, inf))]
    )


@pytest.mark.parametrize("choice", choices(), ids=str)
def test_no_view_gives_a_nan_or_a_parameter_that_is_not_positive(choice):
    for ratio in HOSTILE_RATIOS:
        for phi in (radians(0.01), radians(30), radians(89)):
            for gamma in (*HOSTILE_ANGLES, phi, phi / 3, gamma_lim_rad(1.0, ratio, phi)):
                for sub in ((None, None), (0.5, 2.0 * ratio), (1.0 + 0.9 * (ratio - 1.0), ratio), (ratio, ratio), (2.0, 1.5)):
                    assert 0.0 < warp_parameter(choice, 1.0, ratio, phi, gamma, *sub) <= inf


@pytest.mark.parametrize("kind", WARPS)
def test_every_warp_fades_out_where_light_and_view_are_parallel(kind):
    assert warp_parameter(WarpChoice(kind), 1.0, 100.0, radians(30), 0.0) == inf
    ends = [strength(WarpChoice(kind), 1.0, 100.0, radians(30), g) for g in (1e-2, 1e-4)]
    assert ends[0] < 0.2 and ends[1] <= ends[0] / 50.0


def strength(choice, near, far, phi, gamma):
    parameter = warp_parameter(choice, near, far, phi, gamma)
    return log1p(warp_depth(near, far, phi, gamma) / parameter)


@pytest.mark.parametrize("choice", [c for c in choices() if c.parameter is None or 1.0 < c.parameter < 1e9], ids=str)
@settings(max_examples=25)
@given(view=views(max_ratio=1e3, min_ratio=1.01))
def test_the_strength_of_every_warp_is_continuous_in_gamma(choice, view):
    limit = gamma_lim_rad(view.near, view.far, view.phi)
    for gamma in (0.0, view.gamma, view.phi / 3, view.phi, limit, min(limit, DIRECT_FADE_RAD), view.phi + 0.3 * (pi / 2 - view.phi)):
        before, after = (strength(choice, view.near, view.far, view.phi, min(max(g, 0.0), pi / 2)) for g in (gamma - 1e-9, gamma + 1e-9))
        agree(after, before, abs=1e-3)


@given(views(max_ratio=1e3, min_ratio=1.5), st.sampled_from(WARPS), reals(0.0, 1.2))
def test_the_strength_of_every_warp_is_continuous_in_the_pseudo_near_plane(view, kind, share):
    place = view.near + share * (view.far - view.near)
    before, after = (strength(WarpChoice(kind, pseudo_near=place + d), *view.shape) for d in (-1e-9 * view.near, 1e-9 * view.near))
    agree(after, before, abs=1e-3)


def test_orthographic_and_empty_views_are_not_warped():
    assert warp_parameter(WarpChoice(), -5.0, 10.0, 0.0, 1.0) == inf
    assert warp_parameter(WarpChoice(), 5.0, 5.0, 0.5, 1.0) == inf
    with pytest.raises(SettingsError):
        warp_parameter(WarpChoice(), float("nan"), 5.0, 0.5, 1.0)
    with pytest.raises(SettingsError):
        warp_parameter(WarpChoice(), -1.0, 5.0, 0.5, 1.0)


@given(views(min_ratio=1.01, min_gamma=DIRECT_FADE_RAD), reals(-0.99, 1.0))
def test_parameters_given_by_hand_are_taken_as_they_are(view, eta):
    depth = warp_depth(*view.shape)
    close(eta_from_parameter(warp_parameter(WarpChoice(eta=eta), *view.shape), view.near, view.far, depth) + 2.0, eta + 2.0)
    assert warp_parameter(WarpChoice(parameter=view.near), *view.shape) == view.near


# --- η, ω, pseudo-near ------------------------------------------------------------------------------------------------------------


@given(views(max_ratio=1e7), reals(-0.999, 1.0))
def test_eta_and_its_parameter_are_inverse(view, eta):
    back = eta_from_parameter(parameter_from_eta(eta, view.near, view.far), view.near, view.far)
    agree(back, eta, abs=1e-9 * (view.ratio / (view.ratio - 1.0)))
    assert eta_from_parameter(inf, view.near, view.far) == -1.0 and parameter_from_eta(-1.0, view.near, view.far) == inf


@given(views(min_ratio=1.1), reals(-0.99, 1.0))
def test_eta_is_the_share_of_the_largest_m_z(view, eta):
    def m_z(parameter):
        return max_error_z(WarpedMap(view.near, view.far, view.phi, OVERHEAD, parameter))

    least, end = m_z(lispsm_parameter(view.near, view.far)), m_z(view.near if eta > 0 else inf)
    close(m_z(parameter_from_eta(eta, view.near, view.far)), least + abs(eta) * (end - least))


@given(views(max_ratio=1e5, min_ratio=1.01), st.floats(1e-3, 1.0))
def test_omega_is_linear_in_the_largest_m_x_and_inverts(view, omega):
    parameter = parameter_from_omega(omega, view.near, view.far)
    close(omega_from_parameter(parameter, view.near, view.far), omega)
    flat, best = view.ratio, 1.0
    close(max_error_x(WarpedMap(view.near, view.far, view.phi, OVERHEAD, parameter)), flat + omega * (best - flat), rel=1e-7)
    assert parameter_from_omega(0.0, view.near, view.far) == inf and omega_from_parameter(inf, view.near, view.far) == 0.0
    close(parameter_from_omega(1.0, view.near, view.far), view.near, rel=1e-6)


def base_storage(n_bar, n_bar0, v_np):
    ends = np.array([v_np, 1.0])
    return base_error_s(ends, n_bar, n_bar0).max() * base_error_t(ends, n_bar, n_bar0).max()


@given(views(max_ratio=1e5, min_ratio=1.5), st.floats(1e-6, 0.99), st.floats(0.01, 100.0))
def test_the_pseudo_near_parameter_has_the_least_storage_behind_the_plane(view, v_np, factor):
    near, far = view.near, view.far
    n_bar0 = near / (far - near)
    best = pseudo_near_parameter(near, far, near + v_np * (far - near)) / (far - near)
    other = max((best if best < inf else 10.0) * factor, n_bar0)
    at_most(base_storage(best, n_bar0, v_np) / base_storage(other, n_bar0, v_np) - 1.0, 1e-12)
    at_most(base_storage(best, n_bar0, v_np) / base_storage(inf, n_bar0, v_np) - 1.0, 1e-12)


def test_the_pseudo_near_floor_is_lloyd_s():
    assert pseudo_near_floor(0.0) == 0.0 and pseudo_near_floor(0.7) == inf
    close(pseudo_near_floor(0.5), 1.0)


@settings(max_examples=40)
@given(views(max_ratio=1e4, min_ratio=1.5), st.floats(0.001, 0.6), reals(-0.999, 1.0), st.booleans())
def test_the_log_warps_apex_has_the_least_storage_behind_the_pseudo_near_plane(view, v_np, eta, perspective_s):
    near, far = view.near, view.far
    n_bar0 = near / (far - near)

    def storage(parameter):
        n_bar = parameter / (far - near)
        return base_error_log_t(v_np, n_bar, n_bar0) * (base_error_s(v_np, n_bar, n_bar0) if perspective_s else 1.0)

    best = log_apex(near, far, near + v_np * (far - near), perspective_s)
    assert near <= best
    at_most(storage(best) / storage(parameter_from_eta(eta, near, far)) - 1.0, 1e-7)


# --- the maps ---------------------------------------------------------------------------------------------------------------------

TRIOS = {
    "perspective": (spacing.perspective_forward, spacing.perspective_inverse, spacing.perspective_derivative, ()),
    "logarithmic": (spacing.logarithmic_forward, spacing.logarithmic_inverse, spacing.logarithmic_derivative, ()),
    **{
        f"log+perspective b={b}": (
            spacing.log_perspective_forward,
            spacing.log_perspective_inverse,
            spacing.log_perspective_derivative,
            (b,),
        )
        for b in (inf, 0.03, 7.0, -1.2, -40.0)
    },
}


@pytest.mark.parametrize("name", TRIOS)
@given(n_bar=st.floats(1e-5, 1e5))
def test_maps_run_from_zero_to_one_and_invert(name, n_bar):
    forward, inverse, derivative, extra = TRIOS[name]
    v = np.linspace(0.0, 1.0, 33)
    t = forward(v, n_bar, *extra)
    agree(t[[0, -1]], (0.0, 1.0), abs=1e-12)
    assert (np.diff(t) > 0.0).all()
    agree(inverse(t, n_bar, *extra), v, abs=1e-9)
    exact = np.imag(forward(v + 1e-30j, n_bar, *extra)) * 1e30
    agree(derivative(v, n_bar, *extra), exact, rel=1e-9)
    for f in (forward, inverse, derivative):
        agree([f(float(x), n_bar, *extra) for x in v], f(v, n_bar, *extra), rel=1e-13, abs=1e-15)


def test_uniform_maps_are_the_identity():
    v = np.linspace(0.0, 1.0, 5)
    for forward, inverse, derivative, extra in TRIOS.values():
        if extra in ((), (inf,)):
            assert (forward(v, inf, *extra) == v).all() and (inverse(v, inf, *extra) == v).all()
            assert (derivative(v, inf, *extra) == 1.0).all()
    assert (spacing.perspective_s_scale(v, inf) == 1.0).all()


@given(st.floats(1e-4, 1e4), st.floats(0.01, 100.0))
def test_general_b_is_the_text_s_and_holds_the_log_and_the_perspective_map(n_bar, b):
    v = np.linspace(0.0, 1.0, 17)
    agree(spacing.log_perspective_forward(v, n_bar), spacing.logarithmic_forward(v, n_bar), abs=1e-12)
    agree(spacing.log_perspective_forward(v, n_bar, n_bar), spacing.perspective_forward(v, n_bar), abs=1e-12)
    near_b = spacing.log_perspective_forward(v, n_bar, n_bar * (1 + 1e-9))
    agree(near_b, spacing.perspective_forward(v, n_bar), abs=1e-8)
    if abs(b / n_bar - 1.0) > 0.1:
        text = np.log((v + n_bar) * b / ((v + b) * n_bar)) / np.log((1 + n_bar) * b / ((1 + b) * n_bar))
        agree(spacing.log_perspective_forward(v, n_bar, b), text, abs=1e-9)


@given(near=st.floats(0.01, 100.0), ratio=st.floats(1.05, 1e4), bend=bends)
def test_a_map_s_log_step_is_general_b_over_its_strip(near, ratio, bend):
    """`LogWarp` of the fitted maps against LogPSM 5.43, 5.47-5.51; its inverse and its derivative."""
    far, v = near * ratio, np.linspace(0.0, 1.0, 17)
    _, base, slope = bent(bend, near, far)
    unit = LogWarp(near, far, 1.0 if base > 0.0 else -1.0, 0.0, True, bend, base, slope)
    used, w = slope * (far - near), near + v * (far - near)
    assert used == pytest.approx(bend, abs=1e-9) or abs((1.0 + bend) / ratio - 1.0) < 0.016
    span = float(unit.t_at(far) - unit.t_at(near))
    log_warp = replace(unit, scale=unit.scale * 2.0 / span, offset=-1.0 - 2.0 * float(unit.t_at(near)) / span)
    n_bar, b = near / (far - near), 1.0 / used if used else inf
    t = 2.0 * spacing.log_perspective_forward(v, n_bar, b) - 1.0
    agree(log_warp.t_at(w), t, abs=1e-7)
    agree(log_warp.w_at(t), w, rel=1e-6)
    rate = 2.0 * spacing.log_perspective_derivative(v, n_bar, b) / (far - near)
    agree(log_warp.t_rate(w), rate, rel=1e-6)


@given(near=st.floats(0.01, 10.0), ratio=st.floats(1.1, 1e4), bend=bends)
def test_a_log_map_straightens_with_its_warp(near, ratio, bend):
    strengths = np.linspace(0.0, 1.2, 40) * log(ratio)
    faded = np.array([faded_bend(bend, near, near * ratio, s) for s in strengths])
    assert faded[0] == 0.0
    agree(faded[-1], bend, rel=1e-6)
    assert (np.diff(np.abs(faded)) >= -1e-12).all()
    at_most(np.abs(np.diff(np.log1p(faded))).max(), abs(np.log1p(bend)) / 30 + 1e-6)


@given(views(min_ratio=1.01), st.floats(0.1, 100.0))
def test_spacing_over_the_eye_s_is_the_error(view, factor):
    n_bar0 = view.near / (view.far - view.near)
    n_bar, v = n_bar0 * factor, np.linspace(0.0, 1.0, 17)
    agree(1 / spacing.perspective_derivative(v, n_bar) / (v + n_bar0), base_error_t(v, n_bar, n_bar0), rel=1e-9)
    agree(1 / spacing.logarithmic_derivative(v, n_bar) / (v + n_bar0), base_error_log_t(v, n_bar, n_bar0), rel=1e-9)
    scale = (v + n_bar0) / (1 + n_bar0)
    agree(1 / spacing.perspective_s_scale(v, n_bar) / scale, base_error_s(v, n_bar, n_bar0), rel=1e-9)


def test_gamma_lim_is_the_text_s():
    close(gamma_lim_rad(1.0, 100.0, radians(30)), atan(101.0 * tan(radians(30)) / 99.0))
