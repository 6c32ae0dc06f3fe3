"""Schaufler's angles against the angle between the true and the shown place of single points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.relief.beta import beta_screen, betas
from addon.maths.relief.frame import capture_frame
from tests.margins import agree
from tests.maths.relief.rigs import HALF_FOV, IMAGE, capture_of, chosen, corners, homography_of_quad, hull_of, look_at, ortho_at, random_eye

BOX = corners([-1, -1, -1], [1, 1, 1])


def _by_hand(frame, hull, eye):
    """Largest angle from `eye` between each point and the place of the plane that the capture's projection gave it."""
    normal, origin = frame.world_from_plane[:3, 2], frame.world_from_plane[:3, 3]
    worst = 0.0
    for point in hull:
        ray = normal if not frame.is_perspective else point - (frame.world_from_plane @ frame.source)[:3]
        shown = point - ray * ((point - origin) @ normal) / (ray @ normal)
        a, b = point - eye, shown - eye
        worst = max(worst, float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
    return worst


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=60)
def test_beta_is_the_largest_angle_between_true_and_shown(seed, perspective):
    rng = np.random.default_rng(seed)
    hull = hull_of(rng)
    frame, capture_camera = capture_of(rng, hull, perspective)
    camera = random_eye(rng, hull, capture_camera, False)
    found = betas(frame, hull, camera, IMAGE)
    agree(found.total, _by_hand(frame, hull, camera.eye_ws), abs=1e-9)
    normal = frame.world_from_plane[:3, 2]
    moved = camera.eye_ws - capture_camera.eye_ws
    along = normal * (moved @ normal)
    agree(found.trans_n, _by_hand(frame, hull, capture_camera.eye_ws + along), abs=1e-9)
    agree(found.trans_p, _by_hand(frame, hull, camera.eye_ws - along), abs=1e-9)


def test_at_the_captures_eye_a_perspective_sprite_is_exact_and_an_orthographic_one_is_not():
    camera = look_at([0, -9, 0], [0, 0, 0])
    exact = betas(capture_frame(BOX, camera, IMAGE), BOX, camera, IMAGE)
    assert max(exact.total, exact.trans_p, exact.trans_n) < 1e-9
    flat = betas(capture_frame(BOX, camera, IMAGE, chosen(perspective=False)), BOX, camera, IMAGE)
    assert flat.total > flat.screen


def test_the_orthographic_error_at_rest_is_the_known_formula():
    """f·r·d/(D(D − d)) pixels for a point r beside the axis and d behind the plane (method §7)."""
    camera = look_at([0, -9, 0], [0, 0, 0])
    frame = capture_frame(BOX, camera, IMAGE, chosen(perspective=False))
    point = np.array([[0.9, 1.0, 0.0]])
    focal = IMAGE[1] / 2 / np.tan(HALF_FOV)
    shown = frame.texels(point)[0]
    pixel = homography_of_quad(frame, camera, IMAGE) @ [*shown[0], 1.0]
    true_pixel = IMAGE[0] / 2 + focal * 0.9 / 10.0
    assert pixel[0] / pixel[2] - true_pixel == pytest.approx(focal * 0.9 * 2.0 / (10.0 * 8.0), rel=1e-9)


def test_the_screens_angle_is_the_field_of_view_over_the_resolution():
    assert beta_screen(look_at([0, -9, 0], [0, 0, 0]), IMAGE) <= 2 * HALF_FOV / IMAGE[1] + 1e-12
    assert beta_screen(ortho_at([0, -9, 0], [0, 0, 0], half_height=3.0), IMAGE) == pytest.approx(6.0 / IMAGE[1])


def test_in_orthographic_views_the_errors_are_metres_and_sliding_costs_nothing():
    camera = ortho_at([0, -9, 0], [0, 0, 0])
    frame = capture_frame(BOX, camera, IMAGE)
    slid = ortho_at([2, -9, 1], [2, 0, 1])
    assert betas(frame, BOX, slid, IMAGE).total == pytest.approx(0.0, abs=1e-9)
    turned = ortho_at([3, -9, 0], [0, 0, 0])
    assert betas(frame, BOX, turned, IMAGE).total == pytest.approx(2.0 * np.sin(np.arctan2(3, 9)))
    assert betas(frame, BOX, slid, IMAGE).texel == pytest.approx(frame.texel_m)


def test_moving_away_within_the_plane_or_along_the_normal_is_told_apart():
    camera = look_at([0, -9, 0], [0, 0, 0])
    frame = capture_frame(BOX, camera, IMAGE)
    aside, nearer = betas(frame, BOX, look_at([1, -9, 0], [0, 0, 0]), IMAGE), betas(frame, BOX, look_at([0, -7, 0], [0, 0, 0]), IMAGE)
    assert aside.trans_n < 1e-9 < aside.trans_p == pytest.approx(aside.total)
    assert nearer.trans_p < 1e-9 < nearer.trans_n == pytest.approx(nearer.total)
    assert nearer.texel > aside.texel


def test_behind_the_plane_everything_is_infinite():
    frame = capture_frame(BOX, look_at([0, -9, 0], [0, 0, 0]), IMAGE)
    found = betas(frame, BOX, look_at([0, 9, 0], [0, 0, 0]), IMAGE)
    assert found.total == found.trans_p == found.trans_n == found.texel == np.inf
