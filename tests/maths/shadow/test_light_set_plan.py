"""The maps of many lights: their receivers' hull, and that each map holds all of them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from addon.maths.choices import FitChoice
from addon.maths.directions import sphere_directions
from addon.maths.shadow.light_set_plan import hull_points, plan_light_set
from addon.maths.shadow.lookup import project
from tests.margins import at_most

clouds = st.builds(
    lambda seed, count, flat: (
        np.random.default_rng(seed).normal(size=(count, 3)) * np.array([1.0, 1.0, 0.0 if flat else 1.0]) * 7.0 + 100.0
    ),
    st.integers(0, 2**20),
    st.integers(1, 300),
    st.booleans(),
)


@given(clouds, st.integers(0, 99))
def test_the_hull_holds_every_point_and_little_more(points, direction):
    d = sphere_directions(100)[direction]
    hull, along = hull_points(points, 16) @ d, points @ d
    assert hull.max() >= along.max() - 1e-9 and hull.min() <= along.min() + 1e-9
    cell = max(np.ptp(points, axis=0).max() / 16, 1e-9)
    at_most(hull.max() - along.max(), 3.0**0.5 * cell + 1e-6)


@given(clouds)
def test_every_map_holds_every_receiver(points):
    hull, bounds = hull_points(points), np.stack([points.min(axis=0) - 1.0, points.max(axis=0) + 1.0])
    origin = hull.mean(axis=0).astype(np.float32).astype(np.float64)
    directions = sphere_directions(7)
    plan = plan_light_set(directions, hull, origin, FitChoice(size=64), bounds, bounds[None])
    assert len(plan.projections) == 7 and (plan.origin_ws == origin).all()
    for projection in plan.projections:
        s, t, depth, _ = project(projection, points)
        at_most(np.abs(np.stack([s, t])), 1.0)
        at_most(np.abs(depth), 1.001)


@given(clouds)
def test_depth_grows_away_from_each_light(points):
    hull, bounds = hull_points(points), np.stack([points.min(axis=0) - 1.0, points.max(axis=0) + 1.0])
    for d in sphere_directions(5):
        (projection,) = plan_light_set(d[None], hull, np.zeros(3), FitChoice(size=64), bounds, bounds[None]).projections
        near, far = (float(project(projection, (points[:1] + offset * d))[2][0]) for offset in (0.1, -0.1))
        assert near < far
