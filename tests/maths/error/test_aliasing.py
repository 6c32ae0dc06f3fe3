"""The error theory against its definition: texel beam over pixel beam, on a pyramid built from the frustum's corners."""

from dataclasses import replace
from functools import partial
from math import cos, inf, log, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.maths.error.aliasing import (
    aliasing_statistics,
    beam_error_z,
    error_statistics,
    error_x,
    error_z,
    max_beam_error_z,
    max_error_x,
    max_error_z,
    side_face_maxima,
    storage_factor_log,
    storage_factor_parallel,
    storage_factor_z,
)
from addon.maths.error.warped_map import WarpedMap
from addon.maths.warping.formulas import lispsm_parameter
from tests.margins import agree, at_most
from tests.maths.logpsm_forms import base_error_log_t, base_error_s, base_error_t
from tests.maths.views import HOSTILE_ANGLES, HOSTILE_RATIOS, depths, pyramid_depth, pyramid_w, pyramid_width, views

strengths = st.floats(0.02, 1e4)  # n' over P's depth


close = partial(agree, rel=1e-9)


def warped(view, strength, **kind):
    return WarpedMap(*view.shape, strength * pyramid_depth(view), **kind)


# --- the definition ---------------------------------------------------------------------------------------------------------------


@given(views(), strengths)
def test_m_z_is_the_texel_s_beam_over_the_pixel_s(view, strength):
    m, z = warped(view, strength), depths(view, 33)
    n, f = m.parameter, m.parameter + pyramid_depth(view)
    w = pyramid_w(view, n, z)
    t = f / (f - n) * (1 - n / (w + 1e-30j * w))  # (21), its derivative by a complex step
    beam = 1 / (np.imag(t) / (1e-30 * w))
    agree(beam_error_z(m, z), beam / (2 * z * tan(view.phi)), rel=1e-7)


@given(views(), strengths)
def test_m_z_of_a_log_map_is_the_texel_s_beam_over_the_pixel_s(view, strength):
    m, z = warped(view, strength, logarithmic=True), depths(view, 33)
    n, f = m.parameter, m.parameter + pyramid_depth(view)
    beam = np.log(f / n) * pyramid_w(view, n, z)  # t = ln(w/n')/ln(f'/n')
    agree(beam_error_z(m, z), beam / (2 * z * tan(view.phi)), rel=1e-7)


@given(views(), strengths)
def test_m_x_is_the_texel_s_beam_over_the_pixel_s_on_a_pyramid_that_just_holds_the_view(view, strength):
    m, z = warped(view, strength), depths(view, 33)
    agree(error_x(m, z), pyramid_width(view, m.parameter) * pyramid_w(view, m.parameter, z) / z, rel=1e-7)


@given(views(min_gamma=0.01), strengths)
def test_m_z_along_the_view_axis_is_the_text_s(view, strength):
    m, z = warped(view, strength), depths(view, 9)
    n, f = m.parameter, m.parameter + pyramid_depth(view)
    a, b, s, c = view.near * tan(view.phi), view.far * tan(view.phi), sin(view.gamma), cos(view.gamma)
    psi = n + a * c + (z - view.near) * s if view.phi <= view.gamma else n + b * c + (z - view.far) * s
    agree(error_z(m, z), (f - n) / (2 * tan(view.phi) * n * f) * psi**2 / (z * s), rel=1e-9)
    agree(error_z(m, z, 3.0), 3.0 * error_z(m, z), rel=1e-12)


@given(views(), strengths, st.booleans(), st.booleans())
def test_the_maxima_are_those_over_the_view_axis(view, strength, logarithmic, perspective_s):
    m, z = warped(view, strength, logarithmic=logarithmic, perspective_s=perspective_s or not logarithmic), depths(view)
    for at, largest in ((error_x, max_error_x), (beam_error_z, max_beam_error_z)):
        close(at(m, z).max(), largest(m))
    if view.gamma > 0.0:
        close(error_z(m, z).max(), max_error_z(m))


@given(views(), strengths, st.floats(-0.95, 50.0).filter(lambda bend: bend == 0.0 or abs(bend) > 1e-6))
def test_the_largest_m_z_of_a_bent_log_map_is_the_largest_of_all(view, strength, bend):
    m, z = warped(view, strength, logarithmic=True, bend=bend), depths(view, 400)
    largest = float(beam_error_z(m, z).max())
    at_most(largest / max_beam_error_z(m) - 1.0, 1e-12)
    at_most(max_beam_error_z(m) / largest - 1.0, 0.02)


@given(views(), st.floats(0.02, 100.0))
def test_a_log_map_bent_to_the_perspective_map_has_its_error(view, strength):
    m, z = warped(view, strength), depths(view, 9)
    bent = warped(view, strength, logarithmic=True, bend=pyramid_depth(view) / m.parameter)
    agree(beam_error_z(bent, z), beam_error_z(m, z), rel=1e-7)


@given(views(), strengths, st.booleans())
def test_scalars_and_arrays_agree_and_weak_warps_tend_to_uniform(view, strength, logarithmic):
    m, z = warped(view, strength, logarithmic=logarithmic), depths(view, 9)
    for at in (error_x, beam_error_z):
        agree([float(at(m, float(x))) for x in z], at(m, z), rel=1e-13)
        weak, flat = (replace(m, parameter=p * pyramid_depth(view)) for p in (1e11, inf))
        agree(at(weak, z), at(flat, z), rel=1e-9)


def test_nothing_is_nan_on_hostile_views():
    for ratio in HOSTILE_RATIOS:
        for gamma in HOSTILE_ANGLES:
            for parameter in (1e-9, 1.0, ratio, 1e12, inf):
                for logarithmic in (False, True):
                    m = WarpedMap(1.0, ratio, radians(30), gamma, parameter, logarithmic)
                    for value in (max_error_x(m), max_beam_error_z(m)):
                        assert 0.0 < value < inf
                    assert 0.0 < max_error_z(m) <= inf


# --- the texts' closed forms ------------------------------------------------------------------------------------------------------


@given(views(), st.floats(1.0, 1e4))
def test_overhead_errors_and_maxima_are_the_text_s(view, factor):
    n, f, phi = view.near, view.far, view.phi
    p = n * factor
    m, z = WarpedMap(n, f, phi, pi / 2, p), depths(view, 17)
    agree(error_x(m, z), f * (p + z - n) / (z * (p + f - n)), rel=1e-9)  # (25)
    agree(error_z(m, z), (f - n) / (2 * tan(phi)) * (p + z - n) ** 2 / (z * p * (p + f - n)), rel=1e-9)  # (26)
    near_side = p <= lispsm_parameter(n, f)
    close(max_error_x(m), f * p / (n * (f - n + p)))  # (28)
    close(max_error_z(m), (f - n) / (2 * tan(phi)) * ((p + f - n) / (f * p) if near_side else p / (n * (p + f - n))))  # (29)
    storage = (f / n - 1) / (2 * tan(phi)) * (1.0 if near_side else f * p**2 / (n * (p + f - n) ** 2))  # (31)
    close(max_error_x(m) * max_error_z(m), storage)
    v, n_bar, n_bar0 = (z - n) / (f - n), p / (f - n), n / (f - n)
    agree(error_x(m, z), base_error_s(v, n_bar, n_bar0), rel=1e-7)  # 5.27
    agree(error_z(m, z), base_error_t(v, n_bar, n_bar0) / (2 * tan(phi)), rel=1e-7)  # 5.28
    log_map = replace(m, logarithmic=True)
    agree(error_z(log_map, z), base_error_log_t(v, n_bar, n_bar0) / (2 * tan(phi)), rel=1e-7)  # 5.41


@given(views(min_ratio=1.01))
def test_the_log_map_with_its_apex_in_the_eye_is_flat(view):
    gamma = view.phi + 0.02 + (pi / 2 - view.phi - 0.02) * view.gamma / (pi / 2)
    m = WarpedMap(view.near, view.far, view.phi, gamma, view.near * (sin(gamma) - tan(view.phi) * cos(gamma)), True)
    values = error_z(m, depths(view))
    agree(values, values[0], rel=1e-9)
    if gamma == pi / 2:
        close(values[0], log(view.ratio) / (2 * tan(view.phi)))  # (49)


@given(views(max_ratio=1e7))
def test_parallel_light_needs_the_area_ratio_of_far_and_near_plane(view):
    m = WarpedMap(view.near, view.far, view.phi, 0.0)
    close(max_error_x(m) * max_beam_error_z(m), storage_factor_parallel(view.near, view.far, 1))
    assert max_error_z(m) == inf


@given(views(min_ratio=1.01))
def test_side_faces_have_lloyd_s_maxima(view):
    n, f, t = view.near, view.far, view.phi
    tight = 2 * tan(t) * cos(t) ** 2
    kinds = ((inf, False), (lispsm_parameter(n, f), False), (n, True))
    flat, liss, log_persp = (side_face_maxima(WarpedMap(*view.shape, p, logarithmic)) for p, logarithmic in kinds)
    close(flat[0], f / (n * cos(t)))  # 5.11
    close(flat[1], (f - n) / (n * tight))  # 5.12
    close(liss[1], (f - n) / (sqrt(n * f) * tight))  # 5.37
    close(liss[0] * liss[1], (f / n - 1) / (2 * tan(t) * cos(t) ** 3))  # 5.38
    close(log_persp[0], 1 / cos(t))  # 5.36
    close(log_persp[1], log(f / n) / tight)  # 5.42


@given(views(min_ratio=1.01), st.integers(1, 8))
def test_storage_of_partitions_is_the_sum_of_theirs(view, count):
    splits = view.near * view.ratio ** (np.arange(count + 1) / count)
    pairs = list(zip(splits[:-1], splits[1:], strict=True))
    for warp in (False, True):
        each = [WarpedMap(a, b, view.phi, pi / 2, lispsm_parameter(a, b) if warp else inf) for a, b in pairs]
        close(sum(max_error_x(m) * max_error_z(m) for m in each), storage_factor_z(view.near, view.far, view.phi, count, warp), rel=1e-9)
        assert storage_factor_z(view.near, view.far, view.phi, count, warp) > storage_factor_log(view.near, view.far, view.phi)
        close(storage_factor_z(view.near, view.far, view.phi, 10**9, warp), storage_factor_log(view.near, view.far, view.phi), rel=1e-7)
    each = [WarpedMap(a, b, view.phi, pi / 2, a, True) for a, b in pairs]
    close(sum(max_error_x(m) * max_error_z(m) for m in each), storage_factor_log(view.near, view.far, view.phi), rel=1e-7)  # 5.57


# --- statistics -------------------------------------------------------------------------------------------------------------------


def test_statistics_ignore_pixels_without_a_surface():
    m = np.arange(1, 101, dtype=np.float32).reshape(10, 10) / 50
    holes = np.full((10, 10), np.nan, np.float32)
    expected = {"m_max": 2.0, "m_p99": 2.0, "m_p95": 1.92, "m_median": 1.02, "share_above_1": 0.5}
    assert error_statistics(m) == pytest.approx(expected)
    assert error_statistics(np.concatenate([m, holes])) == pytest.approx(expected)
    measured = aliasing_statistics(m, 2 * m, np.full_like(m, 0.5))
    assert measured["perspective"] == pytest.approx(expected)
    assert {k: v for k, v in measured.items() if k != "perspective"} == pytest.approx(expected)


def test_statistics_of_nothing_are_unknown():
    empty = np.full((2, 3), np.nan)
    keys = ("m_max", "m_p99", "m_p95", "m_median", "share_above_1")
    assert aliasing_statistics(empty, empty, empty) == {**dict.fromkeys(keys), "perspective": dict.fromkeys(keys)}


def test_infinite_errors_count_but_are_never_reported_as_numbers():
    stats = aliasing_statistics(np.array([0.5, np.inf, 2.0]), np.array([np.inf, 1.0, 1e300]), np.array([0.0, 1.0, 1e300]))
    assert stats["m_max"] == 2.0 and stats["m_p99"] is None and stats["m_median"] == 2.0 and stats["share_above_1"] == pytest.approx(2 / 3)
    assert stats["perspective"]["m_max"] == 1.0 and stats["perspective"]["m_p99"] is None
