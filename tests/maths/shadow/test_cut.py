"""Triangles cut to a map in float64: nothing outside is left, nothing inside is lost, neighbours share their points to the last bit."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from addon.maths.shadow import cut
from addon.maths.shadow.lookup import project, unproject
from addon.maths.spaces import transform
from addon.maths.view import Light
from tests.maths.shadow.fit_rigs import camera_at, plan_of, receivers_on, sun_at

BOUNDS = np.array([[-20.0, -20.0, 0.0], [20.0, 20.0, 6.0]])


def projections():
    """Maps of every kind: warps, logarithms, parallel views, lamps."""
    camera = camera_at((-15.0, -12.0, 5.0), (3.0, 2.0, 1.0))
    points = receivers_on(camera, BOUNDS)
    sun, spot = sun_at(camera, 60.0), Light("spot", np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 15.0]))
    cases = [(sun, warp, "none") for warp in ("psm", "logpsm", "log", "uniform")]
    for light, warp, partition in ((sun, "lispsm-general", "z-adaptive"), *cases, (spot, "lispsm", "none")):
        yield from (p for p in plan_of(camera, light, points, BOUNDS, warp, partition).projections if not p.is_empty)
    flat = camera_at((-15.0, -12.0, 25.0), (0.0, 0.0, 0.0), orthographic=6.0)
    yield from plan_of(flat, sun_at(flat, 40.0), receivers_on(flat, BOUNDS), BOUNDS).projections


def corners_of(seed: int, count: int = 60, reach: float = 4.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(count, 3, 4)) * reach
    corners[..., 3] = rng.uniform(-2.0, 4.0, (count, 3))
    return corners


PLANES = np.array([[0, 0, 0, 1, -0.5], [1, 0, 0, 1, 0], [-1, 0, 0, 1, 0], [0, 1, 0, 1, 0], [0, -1, 0, 1, 0], [0, 0, -1, 1, 0]], float)


def doubled_area(triangles: np.ndarray) -> np.ndarray:
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return np.sqrt(np.maximum((u * u).sum(-1) * (v * v).sum(-1) - (u * v).sum(-1) ** 2, 0.0))


@given(st.integers(0, 2**32 - 1))
def test_what_is_left_lies_inside_every_plane(seed):
    pieces, source = cut.cut(corners_of(seed), PLANES)
    assert (pieces @ PLANES[:, :4].T + PLANES[:, 4] >= -1e-13).all()
    assert ((source >= 0) & (source < 60)).all()


@given(st.integers(0, 2**32 - 1))
def test_inside_and_outside_of_one_plane_add_up_to_the_triangle(seed):
    corners, plane = corners_of(seed), np.random.default_rng(seed + 1).normal(size=(1, 5))
    area = np.zeros(60)
    for side in (plane, -plane):
        pieces, source = cut.cut(corners, side)
        np.add.at(area, source, doubled_area(pieces))
    whole = doubled_area(corners)
    assert np.abs(area - whole).max() <= 1e-11 * whole.max()


@given(st.integers(0, 2**32 - 1))
def test_a_point_is_kept_exactly_where_all_planes_hold(seed):
    corners = corners_of(seed, 4)
    pieces, source = cut.cut(corners, PLANES)
    inside = np.random.default_rng(seed).dirichlet([1.0, 1.0, 1.0], size=30)
    points = np.einsum("kb,lbd->lkd", inside, corners)
    height = (points @ PLANES[:, :4].T + PLANES[:, 4]).min(axis=-1)
    for row in range(4):
        own = pieces[source == row]
        covered = np.array([_covers(own, point) for point in points[row]]) if len(own) else np.zeros(30, bool)
        clear = np.abs(height[row]) > 1e-9
        assert (covered == (height[row] > 0.0))[clear].all()


def _covers(pieces: np.ndarray, point: np.ndarray) -> bool:
    basis = np.stack([pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0]], axis=-1)
    weights = np.einsum("fij,fj->fi", np.linalg.pinv(basis), point - pieces[:, 0])
    return bool(((weights >= -1e-9).all(axis=1) & (weights.sum(axis=1) <= 1.0 + 1e-9)).any())


@given(st.integers(0, 2**32 - 1))
def test_neighbours_share_the_points_on_their_edge(seed):
    a, b, c, d = np.random.default_rng(seed).normal(size=(4, 4)) * 5.0
    plane = np.random.default_rng(seed + 7).normal(size=(1, 5))
    pieces, source = cut.cut(np.stack([[a, b, c], [b, a, d]]), plane)
    on_plane = [{tuple(p) for p in pieces[source == k].reshape(-1, 4) if abs(p @ plane[0, :4] + plane[0, 4]) < 1e-9} for k in (0, 1)]
    crosses_edge = (a @ plane[0, :4] + plane[0, 4] >= 0.0) != (b @ plane[0, :4] + plane[0, 4] >= 0.0)
    assert bool(on_plane[0] & on_plane[1]) == crosses_edge


def test_every_point_of_a_map_has_w_in_its_range_and_lies_inside_its_planes():
    rng, seen = np.random.default_rng(3), 0
    for projection in projections():
        low, high = cut.w_range(projection)
        assert 0.0 < low < high or projection.eta == -1.0
        s, t, depth = rng.uniform(-1.0, 1.0, (3, 500))
        points = unproject(projection, s, t, depth)
        w = project(projection, points)[3]
        assert (w >= low * (1.0 - 1e-9)).all()
        assert (w <= high * (1.0 + 1e-9)).all()
        planes = cut.map_planes(projection, 0.01)
        assert (transform(projection.clip_from_world, points) @ planes[:, :4].T + planes[:, 4] >= -1e-9).all()
        beyond = transform(projection.clip_from_world, unproject(projection, s * 0.0 + 1.05, t, depth))
        assert (beyond @ planes[:, :4].T + planes[:, 4] < 0.0).any(axis=1).all()
        seen += 1
    assert seen >= 9


def test_triangles_are_large_by_what_the_map_shows_of_their_surroundings():
    projection = next(projections())
    middle = np.linalg.inv(projection.clip_from_world) @ [0.0, 0.0, 0.0, 1.0]
    middle = middle[:3] / middle[3]
    unit = cut.w_range(projection)[0] / np.linalg.norm(projection.clip_from_world[[0, 1, 3], :3], axis=1).max()
    boxes = np.stack([middle + [[-unit] * 3, [unit] * 3]] * 3)
    large = cut.are_large(projection, boxes, unit * np.array([1.0, 10.0, 1e6]))
    assert large.tolist() == [False, False, True]
