"""Directions of an octahedral set of captures, and the cameras on them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SceneError, SettingsError
from addon.maths import spaces
from addon.maths.relief.views import nearest_views, view_camera, view_directions
from addon.maths.view import Camera
from tests.margins import agree


def camera_at(eye, target):
    return Camera(spaces.look_at(eye, target), spaces.perspective(0.2, 1.5, 0.1, 50.0), 0.1, 50.0)


@pytest.mark.parametrize(("per_side", "mean_deg", "largest_deg"), [(16, 4.9, 9.8), (32, 2.5, 4.9)])
def test_the_directions_cover_the_sphere_more_evenly_than_published(per_side, mean_deg, largest_deg):
    """Degrees to the nearest view; published (research) with the grid through the corners: 5.3 / 10.6, 2.6 / 5.1."""
    directions = view_directions(per_side)
    assert directions.shape == (per_side**2, 3)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=1e-12)
    towards = np.random.default_rng(7).normal(size=(4000, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    apart = np.degrees(np.arccos(np.clip((towards @ directions.T).max(axis=1), -1.0, 1.0)))
    assert apart.max() <= largest_deg
    assert apart.mean() == pytest.approx(mean_deg, abs=0.1)


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_the_nearest_views_are_the_nearest_and_their_cameras_look_at_the_object_from_as_far(seed, count):
    rng = np.random.default_rng(seed)
    centre = rng.uniform(-3.0, 3.0, 3)
    offset = rng.normal(size=3)
    offset *= rng.uniform(2.0, 20.0) / np.linalg.norm(offset)
    camera, directions = camera_at(centre + offset, centre + rng.uniform(-0.2, 0.2, 3)), view_directions(6)
    chosen = nearest_views(directions, camera, centre, count)
    angles = np.arccos(np.clip(directions @ offset / np.linalg.norm(offset), -1.0, 1.0))
    agree(angles[chosen], np.sort(angles)[:count], abs=1e-12)
    for direction in directions[chosen]:
        moved = view_camera(camera, centre, direction)
        agree(moved.eye_ws, centre + np.linalg.norm(offset) * direction, abs=1e-9)
        agree(moved.direction_ws, -direction, abs=1e-9)
        np.testing.assert_array_equal(moved.clip_from_view, camera.clip_from_view)


def test_a_camera_in_the_objects_middle_and_a_set_without_directions_are_refused():
    with pytest.raises(SceneError, match="middle"):
        nearest_views(view_directions(4), camera_at((1.0, 0.0, 0.0), (2.0, 0.0, 0.0)), np.array([1.0, 0.0, 0.0]), 1)
    with pytest.raises(SettingsError):
        view_directions(0)
