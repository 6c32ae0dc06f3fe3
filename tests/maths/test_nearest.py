"""The distance from a point to triangles."""

import numpy as np

from addon.maths.nearest import distance_to_triangles


def test_it_is_the_least_over_points_strewn_on_the_triangles_and_no_more(rng):
    for _ in range(40):
        corners = rng.normal(size=(6, 3, 3)) * rng.uniform(0.2, 3.0)
        point = rng.normal(size=3) * rng.uniform(0.1, 4.0)
        u, v = np.sort(rng.random((2, 40000)), axis=0)
        strewn = np.einsum("kn,tkc->tnc", np.stack([u, v - u, 1.0 - v]), corners)
        sampled = np.linalg.norm(strewn - point, axis=-1).min()
        found = distance_to_triangles(point, corners)
        assert found <= sampled + 1e-12 and found > sampled - 0.05 * np.abs(corners).max()


def test_a_point_above_a_face_beside_an_edge_and_off_a_corner():
    triangle = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]])
    for point, distance in (((0.5, 0.5, 3.0), 3.0), ((1.0, -4.0, 0.0), 4.0), ((-3.0, -4.0, 0.0), 5.0), ((0.5, 0.5, 0.0), 0.0)):
        assert np.isclose(distance_to_triangles(np.array(point), triangle), distance, atol=1e-12)


def test_slivers_and_nothing_at_all_have_a_distance():
    line = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]]])
    assert np.isclose(distance_to_triangles(np.array([1.0, 0.0, 7.0]), line), 7.0)
    assert distance_to_triangles(np.zeros(3), np.empty((0, 3, 3))) == np.inf
