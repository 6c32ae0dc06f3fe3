"""Capturing ahead of a moving eye: where from, when not, and how far."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.relief.ahead import SHARES, ahead_of, next_share
from addon.maths.relief.frame import capture_frame
from addon.maths.spaces import divide, look_at, perspective, rotation, transform
from addon.maths.view import Camera
from tests.margins import agree, at_most
from tests.maths.views import reals

CENTRE = np.array([1.0, -2.0, 0.5])
LENS = perspective(0.4, 1.5, 0.1, 100.0)
HULL = CENTRE + 0.1 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
unit = st.integers(-20, 20).map(lambda n: n / 20.0)
axes = st.tuples(unit, unit, unit).map(np.array).filter(lambda axis: np.linalg.norm(axis) > 0.1)


def _camera(eye: np.ndarray, target: np.ndarray = CENTRE) -> Camera:
    return Camera(look_at(eye, target), LENS, 0.1, 100.0)


@given(axes, st.integers(-70, 70).map(lambda n: n / 10.0), axes)
def test_a_rotation_keeps_distances_its_axis_and_turns_by_its_angle(axis, angle, point):
    turn = rotation(axis, angle, point)
    agree(turn[:3, :3] @ turn[:3, :3].T, np.eye(3), abs=1e-12)
    agree(np.linalg.det(turn), 1.0, rel=1e-6)
    agree(divide(transform(turn, (point + 3.0 * axis)[None])), [point + 3.0 * axis], abs=1e-9)
    side = np.cross(axis, [0.3, -0.5, 0.8])
    carried = turn[:3, :3] @ side
    agree(side @ carried, side @ side * np.cos(angle), abs=1e-12)
    agree(np.cross(side, carried) @ axis, side @ side * np.linalg.norm(axis) * np.sin(angle), abs=1e-9)


@settings(max_examples=50)
@given(st.floats(1.0, 5.0), st.floats(0.001, 0.05), st.floats(0.2, 1.0), reals(-1.2, 1.2))
def test_an_eye_on_an_orbit_is_met_farther_on_along_it(distance, step, share, height):
    start = _camera(CENTRE + distance * np.array([1.0, 0.2, height]))
    before, camera = (start.carried(CENTRE, n * step) for n in (3, 4))
    met = ahead_of(capture_frame(HULL, start, (64, 64)), before, camera, CENTRE, share)
    assert met is not None
    agree(np.linalg.norm(met.eye_ws - CENTRE), np.linalg.norm(camera.eye_ws - CENTRE), rel=1e-6)
    agree(met.view_from_world @ [*CENTRE, 1.0], camera.view_from_world @ [*CENTRE, 1.0], abs=1e-9)
    farther = start.carried(CENTRE, 4.0 * (1.0 + share) * step).eye_ws
    at_most(np.linalg.norm(met.eye_ws - farther), 40.0 * step**2 * np.linalg.norm(camera.eye_ws - CENTRE))


@pytest.mark.parametrize(
    ("eye", "why"),
    [((4.0, 0.0, 1.0), "it stands"), ((5.5, 1.0, 1.25), "it comes nearer"), ((-2.0, 3.0, 2.0), "it jumps")],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_eye_that_does_not_move_on_round_the_object_is_met_nowhere(eye, why):
    captured = capture_frame(HULL, _camera(np.array([4.0, 0.3, 1.0])), (64, 64))
    assert ahead_of(captured, _camera(np.array(eye)), _camera(np.array([4.0, 0.0, 1.0])), CENTRE, 0.8) is None, why


def test_an_object_whose_error_grows_with_the_turn_is_soon_captured_at_the_wanted_error():
    share, worn = 0.8, 0.1
    for _ in range(20):
        found = 0.3 + 0.7 * share * worn / 0.1
        share = next_share(share, found, 0.6)
    assert found == pytest.approx(0.6, abs=0.01)


def test_what_was_wrong_all_over_is_met_half_as_far_on_and_never_behind():
    assert next_share(0.8, np.inf, 0.5) == pytest.approx(0.4)
    assert next_share(SHARES[0], np.inf, 0.5) == SHARES[0]
    assert next_share(1.0, 0.0, 0.5) == SHARES[1]
