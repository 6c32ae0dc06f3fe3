"""Sequences against what they are for: integrals over the sphere, the square and the triangle."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from addon.maths.directions import sphere_directions, square_points, triangle_points
from tests.margins import agree, at_most

counts = st.integers(16, 2048)
thousandths = st.integers(-1000, 1000).map(lambda n: n / 1000)
normals = st.tuples(thousandths, thousandths, thousandths).filter(lambda n: np.linalg.norm(n) > 0.1)


@given(counts)
def test_directions_have_unit_length_and_even_heights(count):
    d = sphere_directions(count)
    agree(np.linalg.norm(d, axis=1), 1.0, abs=1e-12)
    agree(np.diff(d[:, 2]), -2.0 / count, abs=1e-12)


@given(counts, normals)
def test_a_surface_of_any_slope_sees_all_of_the_cosine(count, normal):
    """∫ max(n·ω, 0) dω = π, whatever n; the lattice's error falls faster than 1 / count."""
    n = np.array(normal) / np.linalg.norm(normal)
    total = 4.0 / count * np.maximum(sphere_directions(count) @ n, 0.0).sum()
    at_most(abs(total - 1.0), 1.8 / count)


@given(counts, normals)
def test_the_upper_half_gives_a_slope_its_share_of_the_sky(count, normal):
    """∫ over the upper half of max(n·ω, 0) dω = π (1 + n_z) / 2."""
    n, d = np.array(normal) / np.linalg.norm(normal), sphere_directions(count)
    seen = 4.0 / count * np.maximum(d @ n, 0.0)[d[:, 2] > 0.0].sum()
    at_most(abs(seen - 0.5 * (1.0 + n[2])), 3.0 / count)


@given(st.integers(64, 4096), st.integers(0, 1000))
def test_places_fill_the_square_from_any_start(count, start):
    p = square_points(count, start)
    assert (p >= 0.0).all() and (p < 1.0).all()
    at_most(np.abs(p.mean(axis=0) - 0.5), 4.0 / count)
    at_most(np.abs((p < 0.5).all(axis=1).mean() - 0.25), 12.0 / count)


@given(st.integers(64, 4096))
def test_places_in_a_triangle_lie_within_it_and_about_its_middle(count):
    w = triangle_points(square_points(count))
    assert (w >= 0.0).all() and (w.sum(axis=1) <= 1.0).all()
    at_most(np.abs(w.mean(axis=0) - 1.0 / 3.0), 6.0 / count)
