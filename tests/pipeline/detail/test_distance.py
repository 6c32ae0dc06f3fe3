"""Hausdorff's distance between a mesh and a coarser one is the largest of all points' distances, whatever the collapse says of them."""

import numpy as np
import pytest

from addon.pipeline.detail.distance import Surface, _squared, farthest, hausdorff
from tests import scenes


def columns(points):
    return [np.ascontiguousarray(points[:, k]) for k in range(3)]


def by_sampling(point, triangle, rng):
    """The least distance from many points of a triangle."""
    u = np.sort(rng.random((4000, 2)), axis=1)
    weights = np.concatenate([np.column_stack([u[:, 0], u[:, 1] - u[:, 0], 1.0 - u[:, 1]]), np.eye(3), along_edges()])
    return np.linalg.norm(weights @ triangle - point, axis=1).min()


def along_edges():
    t = np.linspace(0.0, 1.0, 400)[:, None]
    return np.concatenate([t * np.eye(3)[k] + (1.0 - t) * np.eye(3)[k - 1] for k in range(3)])


def test_distance_from_a_triangle_is_that_of_its_nearest_point(rng):
    points, triangles = rng.normal(size=(60, 3)) * 2.0, rng.normal(size=(60, 3, 3))
    found = np.sqrt(_squared(columns(points), [columns(triangles[:, k]) for k in range(3)]))
    for distance, point, triangle in zip(found, points, triangles, strict=True):
        sampled = by_sampling(point, triangle, rng)
        assert distance <= sampled + 1e-12
        assert distance >= sampled - 0.08


def moved(surface, offset):
    return Surface(surface.points + offset, surface.triangles, surface.corners)


def ball():
    positions, triangles = scenes.ball((0.0, 0.0, 0.0), 1.0)
    return Surface(positions.astype(np.float64), triangles.astype(np.int64), triangles.astype(np.int64))


def test_a_mesh_is_at_no_distance_from_itself():
    assert hausdorff(ball(), ball()) < 1e-12


@pytest.mark.parametrize("shift", [1, 7, 100])
def test_distance_does_not_depend_on_what_the_collapse_says(shift):
    one = ball()
    other = moved(one, np.array([0.05, 0.0, 0.0]))
    wrong = Surface(other.points, other.triangles, (one.corners + shift) % len(one.points))
    assert hausdorff(one, other) == pytest.approx(hausdorff(one, wrong), rel=1e-12)


def test_distance_of_a_moved_flat_sheet_is_how_far_it_was_moved():
    points = np.array([[x, y, 0.0] for x in range(5) for y in range(5)], float)
    cells = [(5 * i + j, 5 * i + j + 1, 5 * i + j + 6, 5 * i + j + 5) for i in range(4) for j in range(4)]
    triangles = np.array([t for a, b, c, d in cells for t in ((a, b, c), (a, c, d))])
    sheet = Surface(points, triangles, triangles)
    assert hausdorff(sheet, moved(sheet, np.array([0.0, 0.0, 0.25]))) == pytest.approx(0.25)


def test_one_bump_of_a_coarser_mesh_is_found():
    one = ball()
    points = one.points.copy()
    points[3] *= 1.4
    assert farthest(Surface(points, one.triangles, one.corners), one) == pytest.approx(0.4, abs=0.02)
