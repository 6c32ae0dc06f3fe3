"""Polygons become triangles that cover them once: convex or not, with holes on bridges, slits, corners on straight lines."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.scene.cad import ears
from addon.scene.cad.polygons import triangulate

SQUARE = [(0, 0), (6, 0), (6, 6), (0, 6)]


def cut(flat, tilt=0.5):
    """Triangles (T, 3, 2) of one polygon, lifted into a tilted plane for `triangulate` and flat again."""
    flat = np.array(flat, float)
    corners = np.column_stack([flat, tilt * flat[:, 0] - flat[:, 1]])
    triangles, polygon = triangulate(corners, np.array([len(flat)]))
    assert len(triangles) == len(flat) - 2 and (polygon == 0).all()
    return flat[triangles]


def areas(triangles):
    (ax, ay), (bx, by), (cx, cy) = np.moveaxis(triangles, 0, -1)
    return ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2.0


def signed_area(flat):
    x, y = np.array(flat, float).T
    return np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2.0


def assert_covered_once(flat):
    """No triangle is turned against the polygon and their areas sum to its own: together they cover it, and nothing twice."""
    found, whole = areas(cut(flat)), signed_area(flat)
    assert (found * np.sign(whole) >= -1e-12 * abs(whole)).all()
    assert found.sum() == pytest.approx(whole)


def bridged(outer, i, hole, j):
    """One ring: outer to its corner i, across to the hole's corner j, around the hole (clockwise) and back."""
    return [*outer[: i + 1], *hole[j:], *hole[: j + 1], *outer[i:]]


HOLE = [(2, 2), (2, 4), (4, 4), (4, 2)]
RINGS = {
    "a hole on a bridge": bridged(SQUARE, 0, HOLE, 0),
    "a hole on a bridge from another corner": bridged(SQUARE, 2, HOLE, 2),
    "a bridge across the view of other corners": bridged(SQUARE, 1, HOLE, 3),
    "a hole that touches the outline": bridged(SQUARE, 0, [(2, 2), (0, 3), (4, 4), (4, 2)], 0),
    "a hole that touches a corner of the outline": bridged(SQUARE, 0, [(2, 2), (3, 4), (6, 6), (4, 2)], 0),
    "a bridge of no length": [*SQUARE[:1], (2, 4), (4, 2), (0, 0), *SQUARE[1:]],
    "two holes": bridged(bridged(SQUARE, 0, [(1, 1), (1, 2), (2, 2), (2, 1)], 0), 7, [(4, 4), (4, 5), (5, 5), (5, 4)], 0),
    "two holes on one corner": bridged(bridged(SQUARE, 0, [(4, 1), (4, 2), (5, 2), (5, 1)], 0), 0, [(1, 4), (1, 5), (2, 5), (2, 4)], 0),
    "a slit": [(0, 0), (6, 0), (6, 3), (2, 3), (6, 3), (6, 6), (0, 6)],
    "corners on straight lines": [(0, 0), (1, 0), (3, 0), (6, 0), (6, 2), (3, 2), (1, 2), (1, 4), (1, 6), (0, 6), (0, 3)],
    "a corner twice": [(0, 0), (6, 0), (6, 0), (6, 6), (3, 1), (3, 1), (0, 6)],
    "a spiral": [
        (0, 0),
        (9, 0),
        (9, 9),
        (1, 9),
        (1, 3),
        (6, 3),
        (6, 6),
        (4, 6),
        (4, 5),
        (5, 5),
        (5, 4),
        (2, 4),
        (2, 8),
        (8, 8),
        (8, 1),
        (0, 1),
    ],
}


@pytest.mark.parametrize("name", RINGS)
@pytest.mark.parametrize("is_reversed", [False, True])
def test_rings_are_covered_once_from_every_corner_on(name, is_reversed):
    ring = RINGS[name][::-1] if is_reversed else RINGS[name]
    for shift in range(len(ring)):
        assert_covered_once(ring[shift:] + ring[:shift])


def plate_with_holes(columns, rows, sides=12):
    """A plate of round holes, each on a bridge of its own to the lower edge or to the hole below it: as CAD exports one face."""
    ring = [(0.0, 0.0)]
    angle = -np.pi / 2 - 2 * np.pi * np.arange(sides + 1) / sides
    for i in range(columns):
        foot = (i + 0.5, 0.0)
        way = [(i + 0.5 + 0.3 * np.cos(angle), j + 0.5 + 0.3 * np.sin(angle)) for j in range(rows)]
        up = [(x[k], y[k]) for x, y in way for k in range(sides // 2 + 1)]
        down = [(x[k], y[k]) for x, y in way[::-1] for k in range(sides // 2, sides + 1)]
        ring += [foot, *up, *down, foot]
    return [*ring, (columns, 0.0), (columns, rows), (0.0, rows)]


def test_a_plate_of_many_holes_is_covered_once():
    assert_covered_once(plate_with_holes(5, 4))


@settings(max_examples=40)
@given(st.integers(4, 40), st.integers(0, 2**32 - 1))
def test_stars_of_any_radii_are_covered_once(count, seed):
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * (np.arange(count) + 0.8 * rng.random(count)) / count
    radius = 0.05 + rng.random(count)
    assert_covered_once(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]).tolist())


@settings(max_examples=60)
@given(st.integers(3, 40), st.integers(0, 2**32 - 1))
def test_any_ring_gives_as_many_triangles_of_its_corners_as_it_should(count, seed):
    points = np.random.default_rng(seed).integers(0, 4, (count, 2)).astype(float).tolist()
    triangles = np.array(ears.ears_clipped(points))
    assert triangles.shape == (count - 2, 3) and set(triangles.ravel()) == set(range(count))


def test_the_work_grows_about_as_the_corners_do(monkeypatch):
    """Counted, not timed: comparisons of sides for four times the corners."""
    counts = []
    for columns, rows in ((6, 6), (12, 12)):
        calls = [0]

        def counted(a, b, p, calls=calls, whole=ears.side):
            calls[0] += 1
            return whole(a, b, p)

        with monkeypatch.context() as patched:
            patched.setattr(ears, "side", counted)
            cut(plate_with_holes(columns, rows))
        counts.append(calls[0])
    assert counts[1] < 8 * counts[0]
