"""Depths of a picture: order, digits, and a range that holds what the view shows."""

import numpy as np
import pytest

from addon.maths import spaces
from addon.maths.anchored_camera import LARGE, AnchoredCamera
from addon.maths.depth_projection import DepthProjection, fitted, whole
from addon.maths.frusta import box_corners
from addon.maths.view import Camera

APART = 4e-7  # of the distance: what a float32 depth tells apart when nothing but it is rounded


def camera_at(eye, target, near, far, is_parallel, half=0.4, aspect=1.6):
    clip = spaces.orthographic(half * 10.0, aspect, near, far) if is_parallel else spaces.perspective(half, aspect, near, far)
    return Camera(spaces.look_at(eye, target), clip, near, far)


def float32_depth(projection: DepthProjection, view_depth: np.ndarray) -> np.ndarray:
    """As the shaders compute it, every step in float32."""
    a, b, c, e = np.float32(projection.rule)
    behind = (view_depth - projection.near).astype(np.float32)
    return (a + b * behind) / (c + e * behind)


@pytest.mark.parametrize("is_parallel", [True, False])
@pytest.mark.parametrize("ratio", [1.5, 1e2, 1e5, 1e8])
def test_depths_run_from_the_nearest_to_the_farthest_and_keep_their_order_in_float32(rng, is_parallel, ratio):
    near = float(np.float32(10.0 ** rng.uniform(-3.0, 2.0)))
    projection = DepthProjection(near, near * ratio, is_parallel)
    assert np.allclose(projection.depth([near, near * ratio]), [projection.nearest, projection.farthest], atol=1e-12)
    z = near * ratio ** rng.uniform(0.0, 0.999, 2000)
    behind = z + APART * z
    nearer, farther = float32_depth(projection, z), float32_depth(projection, behind)
    assert np.all(nearer < farther if projection.nearer == "<" else nearer > farther)
    assert np.abs(nearer - projection.depth(z)).max() < 2e-7


@pytest.mark.parametrize("is_parallel", [True, False])
def test_the_range_holds_all_that_the_view_shows_of_boxes_and_nothing_beyond_the_cameras_clip(rng, is_parallel):
    for _ in range(60):
        near = 0.0 if is_parallel else 10.0 ** rng.uniform(-3.0, 0.0)
        near, far = near + 0.01, 10.0 ** rng.uniform(1.0, 4.0)
        camera = camera_at(rng.normal(size=3) * 20.0, rng.normal(size=3), near, far, is_parallel)
        low = rng.normal(size=(6, 3)) * 15.0
        bounds = np.stack([low, low + rng.random((6, 3)) * 10.0 ** rng.uniform(-1.0, 2.0, (6, 1))], axis=1)
        points = (bounds[:, :1] + rng.random((6, 4000, 3)) * (bounds[:, 1:] - bounds[:, :1])).reshape(-1, 3)
        clip = spaces.transform(camera.clip_from_world, points)
        z = -spaces.transform(camera.view_from_world, points)[:, 2]
        shown = (np.abs(clip[:, :2]) <= clip[:, 3:]).all(axis=1) & (z >= near) & (z <= far)
        projection = fitted(camera, bounds)
        assert projection.near <= z[shown].min(initial=np.inf) and projection.far >= z[shown].max(initial=-np.inf)
        assert projection.near >= near * (1.0 - 1e-6) and projection.far <= far * (1.0 + 1e-6)


def test_a_parallel_view_of_a_corner_of_a_large_ground_is_fitted_to_that_corner():
    """The ground's box reaches 7 km before and behind it."""
    camera = Camera(spaces.look_at((500.0, -500.0, 400.0), (0.0, 0.0, 0.0)), spaces.orthographic(5.0, 1.6, -1e5, 1e5), -1e5, 1e5)
    projection = fitted(camera, np.array([[[-1e4, -1e4, -0.1], [1e4, 1e4, 0.0]]]))
    assert projection.far - projection.near < 25.0


def test_where_nothing_is_seen_the_range_is_the_cameras_own():
    camera = camera_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), 0.5, 50.0, False)
    for bounds in (np.empty((0, 2, 3)), np.array([[[0.0, 0.0, 9.0], [1.0, 1.0, 10.0]]])):
        assert fitted(camera, bounds) == whole(camera) and (whole(camera).near, whole(camera).far) == (0.5, 50.0)


@pytest.mark.parametrize("is_parallel", [True, False])
def test_a_plate_that_faces_the_view_has_a_range(is_parallel):
    camera = camera_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), 0.5, 50.0, is_parallel)
    projection = fitted(camera, np.array([[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]]))
    assert projection.near < 5.0 < projection.far < 5.001


@pytest.mark.parametrize("is_parallel", [True, False])
def test_places_about_the_anchor_are_seen_where_the_camera_sees_them_to_the_digits_of_their_distance(rng, is_parallel):
    """In float32, 10 km from the world's origin; a matrix about that origin is off by millimetres."""
    for _ in range(30):
        middle = rng.normal(size=3) * 1e4
        camera = camera_at(middle + rng.normal(size=3) * 10.0, middle, 0.01, 1e6, is_parallel)
        corners = box_corners(np.stack([middle - 2.0, middle + 2.0]))
        corners = corners[-spaces.transform(camera.view_from_world, corners)[:, 2] > 0.1]
        eye = AnchoredCamera.of(camera, np.stack([middle - 2.0, middle + 2.0])[None])
        assert np.array_equal(eye.anchor_ws, eye.anchor_ws.astype(np.float32))
        relative = np.c_[corners - eye.anchor_ws, np.ones(len(corners))].astype(np.float32)
        x, y, behind = (relative[:, None] * eye.rows.astype(np.float32)).sum(axis=-1, dtype=np.float32).T
        clip, z = spaces.transform(camera.clip_from_world, corners), -spaces.transform(camera.view_from_world, corners)[:, 2]
        assert np.abs(behind + eye.depth.near - z).max() < 1e-6 * np.abs(z).max() + 1e-6
        assert np.abs(np.stack([x, y]) - clip[:, :2].T).max() < 2e-5


def test_triangles_far_longer_than_their_distance_are_large():
    camera = camera_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), 0.1, 500.0, False)
    bounds = np.array([[[-90.0, -90.0, -1.0], [90.0, 90.0, 0.0]], [[20.0, 0.0, 5.0], [30.0, 1.0, 6.0]]])
    eye = AnchoredCamera.of(camera, bounds)
    assert eye.is_large(bounds, LARGE * np.array([5.1, 5.1])).tolist() == [True, False]
    assert eye.is_large(bounds, LARGE * np.array([4.9, 20.1])).tolist() == [False, True]
    assert not eye.is_large(bounds, np.full(2, eye.least_large_m)).any()


def test_in_a_parallel_view_triangles_far_longer_than_the_picture_are_large():
    camera = camera_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), 0.1, 500.0, True, half=0.4, aspect=2.0)
    bounds = np.array([[[-90.0, -90.0, -1.0], [90.0, 90.0, 0.0]]] * 2)
    assert AnchoredCamera.of(camera, bounds).is_large(bounds, LARGE * np.array([15.9, 16.1])).tolist() == [False, True]
