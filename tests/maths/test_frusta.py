"""Clipped bodies against a brute-force oracle: all triples of planes, kept where no plane cuts them off."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths import spaces
from addon.maths.frusta import box_corners, box_planes, frustum_corners, hexahedron
from tests.margins import agree
from tests.maths.shadow.fit_rigs import camera_at

DIRECTIONS = np.random.default_rng(5).normal(size=(200, 3))


def slab_planes(direction, near, far):
    """Keep near ≤ direction · p ≤ far, p relative to the eye."""
    return np.array([[*direction, -near], [*-direction, far]])


def _frustum_planes(camera):
    """(6, 4) inward planes relative to the eye, from the rows of the clip matrix (Gribb–Hartmann), unit normals."""
    m = camera.clip_from_view @ np.block([[camera.view_from_world[:3, :3], np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])
    planes = np.array([m[3] + s * m[k] for k in range(3) for s in (1.0, -1.0)])
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def _brute_vertices(planes):
    found = []
    for three in combinations(planes, 3):
        a = np.array(three)
        if abs(np.linalg.det(a[:, :3])) > 1e-9:
            p = np.linalg.solve(a[:, :3], -a[:, 3])
            if (planes[:, :3] @ p + planes[:, 3] >= -1e-7 * (1.0 + np.abs(p).max())).all():
                found.append(p)
    return np.array(found).reshape(-1, 3)


@pytest.mark.parametrize("orthographic", [None, 8.0])
@given(seed=st.integers(0, 10_000))
@settings(max_examples=25)
def test_view_frustum_clipped_by_a_box_has_the_oracles_support_in_every_direction(orthographic, seed):
    rng = np.random.default_rng(seed)
    camera = camera_at(rng.uniform(-10, 10, 3), rng.uniform(-3, 3, 3), near=0.3, far=rng.uniform(5, 60), orthographic=orthographic)
    bounds = np.sort(rng.uniform(-12, 12, (2, 3)), axis=0) - camera.eye_ws
    frustum = hexahedron(frustum_corners(camera, camera.near, camera.far))
    got = frustum.clipped(box_planes(bounds)).vertices
    want = _brute_vertices(np.concatenate([_frustum_planes(camera), box_planes(bounds)]))
    assert (len(got) > 0) == (len(want) > 0)
    if len(want):
        agree((got @ DIRECTIONS.T).max(axis=0), (want @ DIRECTIONS.T).max(axis=0), abs=1e-5)


@pytest.mark.parametrize("orthographic", [None, 8.0])
def test_slab_corners_have_the_asked_view_depths_and_the_frustums_sides(orthographic):
    camera = camera_at((1, 2, 3), (4, -2, 0), near=0.5, far=50.0, orthographic=orthographic)
    corners = frustum_corners(camera, 2.0, 20.0)
    assert np.allclose(corners @ camera.direction_ws, [2.0] * 4 + [20.0] * 4)
    clip = spaces.transform(camera.clip_from_world, corners + camera.eye_ws)
    assert np.allclose(np.abs(clip[:, :2]), clip[:, 3:], rtol=1e-9)


def test_clipping_to_a_slab_is_the_slab():
    camera = camera_at((1, 2, 3), (4, -2, 0), near=0.5, far=50.0)
    whole = hexahedron(frustum_corners(camera, 0.5, 50.0)).clipped(slab_planes(camera.direction_ws, 2.0, 20.0))
    slab = frustum_corners(camera, 2.0, 20.0)
    assert np.allclose((whole.vertices @ DIRECTIONS.T).max(axis=0), (slab @ DIRECTIONS.T).max(axis=0))


def test_a_flat_scene_keeps_its_floor_and_a_scene_behind_the_camera_leaves_nothing():
    camera = camera_at((0, -10, 5), (0, 0, 0), near=0.5, far=100.0)
    frustum = hexahedron(frustum_corners(camera, 0.5, 100.0))
    floor = frustum.clipped(box_planes(np.array([[-5.0, -5.0, 0.0], [5.0, 5.0, 0.0]]) - camera.eye_ws)).vertices + camera.eye_ws
    assert len(floor) >= 4 and np.allclose(floor[:, 2], 0.0, atol=1e-7) and np.ptp(floor[:, 1]) > 5.0
    assert len(frustum.clipped(box_planes(np.array([[-5.0, -50.0, 0.0], [5.0, -40.0, 1.0]]) - camera.eye_ws)).vertices) == 0


def test_camera_inside_the_box_keeps_its_whole_near_plane():
    camera = camera_at((0, 0, 0), (1, 1, 0), near=0.5, far=100.0)
    body = hexahedron(frustum_corners(camera, 0.5, 100.0)).clipped(box_planes(np.array([[-9.0] * 3, [9.0] * 3]))).vertices
    assert np.isclose((body @ camera.direction_ws).min(), 0.5)
    assert np.abs(body).max() <= 9.0 + 1e-9


def test_box_corners_are_the_eight_of_every_box():
    boxes = np.array([[[0, 1, 2], [3, 4, 5]], [[-1, -1, -1], [1, 1, 1]]], float)
    corners = box_corners(boxes)
    assert corners.shape == (2, 8, 3)
    assert np.allclose(corners.min(axis=1), boxes[:, 0]) and np.allclose(corners.max(axis=1), boxes[:, 1])
    assert all(len({tuple(c) for c in box}) == 8 for box in corners)
