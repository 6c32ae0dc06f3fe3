"""Lights with a size as hard lights: even sequences, even shapes, and the light that they add up to."""

from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.light_shapes import axes_across, ball, cap, disc
from addon.maths.low_discrepancy import generalised_golden_ratio, kronecker
from addon.maths.view import Light

COUNTS = st.integers(1, 400)
STARTS = st.integers(0, 100_000)


@given(st.integers(1, 6))
def test_the_golden_ratio_solves_its_equation(dimensions):
    root = generalised_golden_ratio(dimensions)
    assert abs(root ** (dimensions + 1) - root - 1.0) < 1e-12


@given(STARTS, COUNTS, st.integers(1, 3))
def test_points_depend_on_their_number_alone_and_lie_in_the_cube(start, count, dimensions):
    points = kronecker(np.arange(start, start + count), dimensions)
    assert points.shape == (count, dimensions)
    assert (points >= 0.0).all() and (points < 1.0).all()
    assert np.array_equal(points[-1], kronecker([start + count - 1], dimensions)[0])


def test_the_first_point_is_the_middle():
    assert np.array_equal(kronecker([0], 2), [[0.5, 0.5]])


@given(STARTS, st.integers(16, 512), st.floats(0.05, 1.0), st.floats(0.05, 1.0))
def test_any_run_of_points_is_much_more_even_than_random_ones(start, count, width, height):
    """The share of points in a box differs from its area by less than 1.2 log(n)² / n; of random ones it does by √(A (1 − A) / n)."""
    inside = (kronecker(np.arange(start, start + count), 2) < [width, height]).all(axis=1)
    assert abs(inside.mean() - width * height) < 1.2 * np.log(count) ** 2 / count


@given(STARTS)
def test_the_disc_is_filled_evenly(start):
    points = disc(kronecker(np.arange(start, start + 256), 2))
    radius = np.linalg.norm(points, axis=1)
    assert radius.max() <= 1.0 + 1e-12
    assert abs((radius < sqrt(0.5)).mean() - 0.5) < 0.06
    assert np.abs(points.mean(axis=0)).max() < 0.04


@given(STARTS, st.floats(1e-4, pi / 2.0))
def test_the_cap_is_filled_evenly_and_no_further(start, angle):
    points = cap(kronecker(np.arange(start, start + 256), 2), angle)
    assert np.allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-12)
    away = np.arctan2(np.hypot(points[:, 0], points[:, 1]), points[:, 2])
    assert away.max() <= angle * (1.0 + 1e-9)
    half = 2.0 * np.arcsin(np.sin(0.5 * angle) * sqrt(0.5))  # half the cap's area lies within
    assert abs((away < half).mean() - 0.5) < 0.06


@given(STARTS, st.integers(0, 180).map(radians), st.integers(0, 360).map(radians))
def test_the_ball_looks_like_an_even_disc_from_every_side(start, tilt, turn):
    away = np.array([sin(tilt) * cos(turn), sin(tilt) * sin(turn), cos(tilt)])
    points = ball(kronecker(np.arange(start, start + 512), 3))
    across = points @ axes_across(away)[:2].T
    radius = np.linalg.norm(across, axis=1)
    assert radius.max() <= 1.0 + 1e-9
    for part in (0.25, 0.5, 0.75):
        assert abs((radius < sqrt(part)).mean() - part) < 0.07


@settings(max_examples=30)
@given(st.floats(0.001, pi / 2.0), st.integers(0, 30).map(radians))
def test_a_suns_samples_give_the_surface_that_faces_it_its_irradiance(half_angle, tilt):
    sun = Light("sun", np.array([sin(tilt), 0.0, cos(tilt)]), color=(2.0, 1.0, 0.5), half_angle_rad=half_angle)
    samples = [sun.sample(k) for k in range(256)]
    facing = np.array([s.direction_ws @ sun.direction_ws for s in samples])
    assert facing.min() >= cos(half_angle) - 1e-9
    assert abs(np.mean([s.color[0] * f for s, f in zip(samples, facing, strict=True)]) / 2.0 - 1.0) < 0.02
    assert all(not s.is_soft and s.name == sun.name for s in samples)


@pytest.mark.parametrize("is_round", [False, True])
def test_a_panels_samples_lie_on_it(is_round):
    axes = np.array([[0.5, 0.0, 0.0], [0.0, 2.0, 0.0]])
    panel = Light(
        "spot", np.array([0.0, 0.0, 1.0]), np.array([1.0, 2.0, 3.0]), 1.5, 0.0, spread_rad=pi / 2.0, half_axes_ws=axes, is_round=is_round
    )
    places = np.array([panel.sample(k).position_ws for k in range(512)]) - panel.position_ws
    local = places[:, :2] / [0.5, 2.0]
    assert np.abs(places[:, 2]).max() == 0.0
    assert np.abs(local).max() <= 1.0
    second_moment = 1.0 / 4.0 if is_round else 1.0 / 3.0
    assert np.abs((local**2).mean(axis=0) - second_moment).max() < 0.01
    assert is_round == bool((np.linalg.norm(local, axis=1) <= 1.0 + 1e-12).all())


def test_a_light_without_a_size_is_its_own_sample():
    for light in (
        Light("sun", np.array([0.0, 0.0, 1.0])),
        Light("point", None, np.zeros(3)),
        Light("spot", np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.5),
    ):
        assert not light.is_soft
        assert light.sample(5).key == light.key == light.hard.key == light.softened(3.0).key


def test_softness_scales_a_light_and_none_makes_it_hard():
    sun = Light("sun", np.array([0.0, 0.0, 1.0]), half_angle_rad=radians(1.0))
    lamp = Light("point", None, np.zeros(3), radius=0.2)
    assert sun.softened(2.0).half_angle_rad == radians(2.0)
    assert sun.softened(1e3).half_angle_rad == pi / 2.0
    assert lamp.softened(2.0).radius == 0.4
    assert lamp.softened(0.0).key == lamp.hard.key
    assert sun.softened(0.0).key == sun.hard.key
