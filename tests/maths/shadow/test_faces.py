"""Faces of the view frustum: one sector for every point, whatever the light; six maps always; halves, axes and sizes that do not jump."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.shadow import faces, lookup
from addon.maths.view import Light
from tests.margins import at_most
from tests.maths.shadow.fit_rigs import camera_at, plan_of, receivers_on, sun_at, texel_sizes, unit

BOUNDS = np.array([[-20.0, -20.0, 0.0], [20.0, 40.0, 8.0]])
WARPS_TRIED = ("uniform", "psm", "lispsm-general", "log", "logpsm")


def _camera():
    return camera_at((0, -30, 15), (0, 5, 0))


def _light(camera, seed):
    rng = np.random.default_rng(seed)
    near_axis = seed % 2 == 0
    direction = camera.direction_ws + rng.normal(size=3) * (0.3 if near_axis else 5.0)
    return Light("sun", unit(direction * rng.choice([-1.0, 1.0])))


@given(
    seed=st.integers(0, 100_000),
    warp=st.sampled_from(WARPS_TRIED),
    partition=st.sampled_from(["faces", "faces-z"]),
    kind=st.sampled_from(["frustum", "scene", "samples"]),
)
@settings(max_examples=60)
def test_every_receiver_has_exactly_one_face_and_falls_inside_its_map(seed, warp, partition, kind):
    camera = _camera()
    light, points = _light(camera, seed), receivers_on(camera, BOUNDS, seed=seed)
    plan = plan_of(camera, light, points, BOUNDS, warp, partition, kind, **({"count": 2} if partition == "faces-z" else {}))
    depth = (points - camera.eye_ws) @ camera.direction_ws
    serving = np.zeros(len(points), int)
    for p in plan.projections:
        inside = (depth >= p.near) & (depth < p.far)
        for plane in p.region_planes_ws:
            inside &= points @ plane[:3] + plane[3] >= 0.0
        serving += inside
        if inside.any():
            s, t, d, w = lookup.project(p, points[inside])
            assert not p.is_empty and (w > 0.0).all()
            at_most(max(np.abs(s).max(), np.abs(t).max(), np.abs(d).max()) - 1.0, 1e-5)
    assert (serving == 1).all()


@pytest.mark.parametrize("azimuth", [0.0, 60.0, 90.0, 180.0, 270.0])
@pytest.mark.parametrize("gamma", [0.0, 1e-9, 10.0, 22.5, 36.4, 45.0, 90.0, 180.0])
def test_degenerate_lights_leave_no_point_unserved_and_nothing_infinite(gamma, azimuth):
    camera = _camera()
    points = receivers_on(camera, BOUNDS)
    plan = plan_of(camera, sun_at(camera, gamma, azimuth), points, BOUNDS, "lispsm-general", "faces")
    assert len(plan.projections) == faces.COUNT and all(np.isfinite(p.clip_from_world).all() for p in plan.projections)
    assert (lookup.partition_index(plan, camera, points) >= 0).all()


def test_planes_contain_the_lights_direction_and_the_eye():
    camera = _camera()
    for seed in range(20):
        light = _light(camera, seed)
        for p in plan_of(camera, light, receivers_on(camera, BOUNDS), BOUNDS, partition="faces").projections:
            if not p.is_empty:
                assert np.allclose(p.region_planes_ws[:, :3] @ light.direction_ws, 0.0, atol=1e-12)
                assert np.allclose(p.region_planes_ws[:, :3] @ camera.eye_ws + p.region_planes_ws[:, 3], 0.0, atol=1e-9)


def test_faces_turned_away_are_culled_and_a_light_along_the_view_has_all_four():
    camera = _camera()
    points = receivers_on(camera, BOUNDS, 20_000)

    def served(gamma, ahead):
        plan = plan_of(camera, sun_at(camera, gamma, 90.0, ahead), points, BOUNDS, partition="faces")
        return {p.face for p in plan.projections if not p.is_empty}

    assert served(2.0, True) == served(2.0, False) == {0, 1, 2, 3}
    assert served(60.0, True) == {0, 1, 2}  # above and ahead: the rays leave through the bottom and the sides
    assert served(60.0, False) == {0, 1, 3}  # above and behind: they enter through the top and the sides


def test_wide_sectors_come_in_halves_with_bisected_axes():
    camera = _camera()
    sectors = faces._sectors(camera, sun_at(camera, 0.5, 90.0).direction_ws)
    of_face = {face: [s for s in sectors if s.face == face] for face in range(4)}
    assert [len(of_face[k]) for k in range(4)] == [1, 1, 2, 2]  # a wide picture: bottom and top span more than 100°
    assert all(np.isclose(np.linalg.norm(s.axis_ws), 1.0) for s in sectors)
    first, second = of_face[3]
    assert first.axis_ws @ second.axis_ws < np.cos(faces.SPLIT_FROM / 8)


def test_halves_ease_in_without_a_jump_of_axis_or_fit():
    image = faces._Image(unit([0.0, 0.0, 1.0]))
    last = None
    for tau in np.radians(np.arange(95.0, 135.0, 0.25)):
        a, b = image.direction(0.0) - 0.1 * unit([0, 0, 1.0]), image.direction(tau) - 0.1 * unit([0, 0, 1.0])
        halves = faces._of_face(image, 0, a, b, [True, True], faces.SPLIT_FROM)
        axes = np.array([halves[0].axis_ws, halves[-1].axis_ws])
        if last is not None:
            assert (np.arccos(np.clip((axes * last).sum(axis=1), -1.0, 1.0)) < np.radians(3.5)).all()
        last = axes
    assert len(halves) == 2


@pytest.mark.parametrize("kind", ["scene", "samples"])
@pytest.mark.parametrize("warp", ["uniform", "lispsm-general", "logpsm"])
def test_a_faces_texels_are_steady_while_the_light_passes_through_the_view_axis(warp, kind):
    axis = unit([np.cos(0.5), 0.0, -np.sin(0.5)])
    light = Light("sun", unit(-(axis + 0.005 * np.array([np.sin(0.5), 0, np.cos(0.5)]))))
    grid = np.stack(np.meshgrid(np.linspace(-15, 15, 61), np.linspace(-15, 15, 61), [0.0, 3.0]), axis=-1).reshape(-1, 3)
    bounds = np.array([[-15.0, -15.0, 0.0], [15.0, 15.0, 3.0]])
    last = None
    for angle in np.radians(np.arange(-18.0, 18.5, 1.0)):
        c, s = np.cos(angle), np.sin(angle)
        camera = camera_at(-45.0 * np.array([c * axis[0], s * axis[0], axis[2]]), (0, 0, 0), near=1.0, far=100.0)
        plan = plan_of(camera, light, grid, bounds, warp, "faces", kind, casters=np.zeros((0, 2, 3)))
        sizes = texel_sizes(plan, light)[:, 0]
        now = {(p.face, k): sizes[k] for k, p in enumerate(plan.projections) if not p.is_empty}
        for key in now.keys() & (last or {}).keys():
            assert max(now[key] / last[key], last[key] / now[key]) < 1.25
        last = now


def test_lights_and_cameras_without_faces_say_so_and_are_divided_in_depth():
    camera = _camera()
    points = receivers_on(camera, BOUNDS)
    spot = Light("spot", unit([0, 0, 1.0]), np.array([0.0, 0.0, 40.0]), cone_rad=1.0)
    plan = plan_of(camera, spot, points, BOUNDS, partition="faces-z", count=3)
    assert len(plan.projections) == 3 and "faces-z" in plan.warnings[0]
    parallel = camera_at((0, -30, 15), (0, 5, 0), near=1.0, far=120.0, orthographic=12.0)
    assert len(plan_of(parallel, sun_at(parallel, 50.0), points, BOUNDS, partition="faces").projections) == 1
