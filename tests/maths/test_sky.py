"""The CIE's skies against their definition and what they must integrate to."""

from math import cos, exp, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.directions import sphere_directions
from addon.maths.sky import SKY_TYPES, sky_luminance
from tests.margins import agree

skies = st.sampled_from(sorted(SKY_TYPES))


def sun_at(elevation_deg, azimuth_deg=0.0):
    e, a = radians(elevation_deg), radians(azimuth_deg)
    return np.array([cos(e) * cos(a), cos(e) * sin(a), sin(e)])


suns = st.builds(sun_at, st.integers(0, 90), st.integers(0, 359))


@given(skies, suns)
def test_every_sky_lights_level_ground_as_a_white_one(kind, sun):
    d = sphere_directions(20_000)
    total = 4.0 / len(d) * (sky_luminance(kind, d, sun) * np.maximum(d[:, 2], 0.0)).sum()
    agree(total, 1.0, abs=2e-3)


@given(skies, suns)
def test_no_sky_is_dark_above_or_bright_below_the_horizon(kind, sun):
    d = sphere_directions(500)
    luminance, up = sky_luminance(kind, d, sun), d[:, 2] > 0.0
    assert (luminance[up] > 0.0).all() and (luminance[~up] == 0.0).all()


@given(suns)
def test_a_uniform_sky_is_the_same_everywhere(sun):
    d = sphere_directions(500)
    agree(sky_luminance("uniform", d, sun)[d[:, 2] > 0.0], 1.0, abs=1e-12)


def test_an_overcast_sky_grows_with_height_to_three_times_the_horizon():
    """CIE type 1, in the place of Moon and Spencer's (1 + 2 sin h) / 3."""
    heights = np.radians(np.arange(1.0, 91.0))
    d = np.stack([np.cos(heights), 0.0 * heights, np.sin(heights)], axis=-1)
    found = sky_luminance("overcast", d, sun_at(30.0))
    assert (np.diff(found) > 0.0).all()
    agree(found[-1] / found[0], 3.0, rel=0.01)


def test_a_clear_sky_has_the_ratios_of_its_formula():
    sun, d = sun_at(40.0), np.array([[0.0, 0.0, 1.0], sun_at(60.0, 50.0)])
    a, b, c, e = -1.0, -0.32, 10.0, 0.45
    values = []
    for v in d:
        chi = np.arccos(v @ sun)
        values.append((1 + a * exp(b / v[2])) * (1 + c * (exp(-3.0 * chi) - exp(-1.5 * pi)) + e * np.cos(chi) ** 2))
    found = sky_luminance("cie", d, sun)
    agree(found[1] / found[0], values[1] / values[0], rel=1e-12)


@given(suns)
def test_a_clear_sky_is_brightest_towards_the_sun(sun):
    d = sphere_directions(2000)
    best = d[sky_luminance("cie", d, sun).argmax()]
    assert best @ sun > cos(radians(25.0))


def test_a_sun_below_the_horizon_counts_as_one_at_it():
    d = sphere_directions(100)
    agree(sky_luminance("cie", d, sun_at(-20.0, 70.0)), sky_luminance("cie", d, sun_at(0.0, 70.0)), rel=1e-12)


def test_an_unknown_sky_is_named_with_those_there_are():
    with pytest.raises(SettingsError, match="cie"):
        sky_luminance("plaid", sphere_directions(4), sun_at(10.0))
