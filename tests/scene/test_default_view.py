"""The views of scenes without a camera: framing, depth range, the sun."""

from dataclasses import replace

import numpy as np
import pytest

from addon.errors import SettingsError
from addon.scene.default_view import (
    BORDER,
    VIEWS,
    camera_for_view,
    camera_from_eye,
    default_sun,
    nearest_surface_m,
    outline_points,
    world_sun,
)
from tests import scenes
from tests.pipeline import oracle


def projected(camera, points):
    clip = np.concatenate([points, np.ones((len(points), 1))], axis=1) @ camera.clip_from_world.T
    return clip[:, :3] / clip[:, 3:]


@pytest.mark.parametrize("size", [(1280, 720), (300, 900)])
@pytest.mark.parametrize("fov", [0.1, 0.7, 1.6])
@pytest.mark.parametrize("name", VIEWS)
def test_a_view_frames_everything_and_wastes_nothing(name, fov, size):
    scene = scenes.scene_of(scenes.box((2, 3, 4), (5, 4, 9)), scenes.ball((-6, 0, 0), 1.5, 12, 6))
    camera = camera_for_view(scene, size, name, fov)
    ndc = projected(camera, outline_points(scene))
    reach = np.abs(ndc).max(axis=0)
    assert reach[:2].max() <= 1 - BORDER + 1e-9 and reach[2] < 1
    low, high = ndc[:, :2].min(axis=0), ndc[:, :2].max(axis=0)
    touches = np.isclose(high - low, 2 * (1 - BORDER), atol=1e-6)
    assert touches.any(), "one direction is used to the full"
    assert np.allclose((high + low)[touches], 0, atol=1e-6), "and is centred"


def test_views_look_the_way_their_names_say():
    scene = scenes.scene_of(scenes.box((0, 0, 0), (1, 2, 3)))
    looks = {name: camera_for_view(scene, (64, 64), name).direction_ws for name in VIEWS}
    for name, direction in {
        "front": (0, 1, 0),
        "back": (0, -1, 0),
        "left": (1, 0, 0),
        "right": (-1, 0, 0),
        "top": (0, 0, -1),
        "bottom": (0, 0, 1),
    }.items():
        assert np.allclose(looks[name], direction)
    assert looks["iso"][0] < 0 < looks["iso"][1] and looks["iso"][2] < 0
    x, y, z = np.abs(looks["iso"] @ np.eye(3))
    assert np.isclose(x, y) and np.isclose(z, np.sqrt(0.25), atol=0.01), "30 degrees above the horizon"


def test_an_eye_is_where_the_user_put_it_whatever_the_scenes_origin(rng):
    scene = replace(scenes.scene_of(scenes.box((0, 0, 0), (1, 1, 1))), origin_ws=np.array([1000.0, -500.0, 64.0]))
    camera = camera_from_eye(scene, (100, 50), (1005, -505, 70), (1000, -500, 64))
    assert np.allclose(camera.eye_ws + scene.origin_ws, (1005, -505, 70))
    assert np.allclose(projected(camera, np.zeros((1, 3)))[0, :2], 0, atol=1e-9)
    ndc = projected(camera, outline_points(scene))
    assert np.abs(ndc[:, 2]).max() < 1


def test_an_eye_inside_the_scene_still_has_a_depth_range():
    scene = scenes.scene_of(scenes.box((-5, -5, -5), (5, 5, 5)))
    camera = camera_from_eye(scene, (100, 50), (0, 0, 0), (1, 0, 0))
    assert np.isclose(camera.near, 0.5) and 5 < camera.far < 6


@pytest.mark.parametrize("make", [scenes.staircase, scenes.closed_box, scenes.chair, scenes.railing])
def test_an_eye_inside_the_scene_loses_nothing_by_the_near_plane(make, rng):
    """Whatever it looks at: rays through a picture 100° wide. Near is no nearer than that asks for by more than twenty times."""
    scene = make()
    bounds = scene.bounds_ws()
    for _ in range(8):
        eye = bounds[0] + rng.uniform(0.1, 0.9, 3) * (bounds[1] - bounds[0])
        camera = camera_from_eye(scene, (40, 30), eye, eye + rng.normal(size=3), fov_y_rad=1.7)
        points, _, objects = oracle.surface_points(scene, camera, (40, 30))
        depths = (points[objects >= 0] - camera.eye_ws) @ camera.direction_ws
        assert (depths > camera.near).all()
        assert camera.near >= 0.05 * nearest_surface_m(scene, camera.eye_ws)


def test_a_part_before_the_eye_on_a_site_of_ten_kilometres_is_not_cut_away():
    scene = scenes.scene_of(scenes.floor(5000.0), scenes.box((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)))
    camera = camera_from_eye(scene, (100, 50), (0.4, -0.4, 0.3), (0.05, 0.05, 0.05))
    assert 0.005 < camera.near < 0.05 and camera.far > 5000.0


def test_looking_straight_down_is_no_special_case():
    scene = scenes.scene_of(scenes.box((0, 0, 0), (1, 1, 1)))
    camera = camera_from_eye(scene, (64, 64), (0.5, 0.5, 5), (0.5, 0.5, 0))
    assert np.allclose(camera.direction_ws, (0, 0, -1))


def test_nonsense_is_refused_in_one_line():
    scene = scenes.scene_of(scenes.box((0, 0, 0), (1, 1, 1)))
    for call in (
        lambda: camera_for_view(scene, (64, 64), "askew"),
        lambda: camera_from_eye(scene, (64, 64), (1, 1, 1), (1, 1, 1)),
        lambda: camera_for_view(scene, (64, 64), "iso", 4.0),
    ):
        with pytest.raises(SettingsError) as raised:
            call()
        assert "\n" not in str(raised.value)


@pytest.mark.parametrize("name", VIEWS)
def test_the_default_sun_stands_to_the_upper_left_and_above_the_horizon(name):
    camera = camera_for_view(scenes.scene_of(scenes.box((0, 0, 0), (1, 1, 1))), (64, 64), name)
    light = default_sun(camera)
    assert np.isclose(np.linalg.norm(light.direction_ws), 1) and light.direction_ws[2] >= np.sin(np.radians(24.9))
    if name not in ("top", "bottom"):
        x, y, _ = camera.view_from_world[:3, :3] @ light.direction_ws
        assert x < 0 < y


def test_the_sun_that_stands_in_the_world_is_that_of_the_isometric_view():
    camera = camera_for_view(scenes.scene_of(scenes.box((2, -3, 1), (9, 1, 2))), (64, 64), "iso")
    assert np.allclose(world_sun().direction_ws, default_sun(camera).direction_ws, atol=1e-12)


@pytest.mark.parametrize("name", VIEWS)
@pytest.mark.parametrize("size", [(64, 64), (120, 40), (40, 120)])
def test_parallel_views_frame_the_scene_just_so(name, size):
    scene = scenes.scene_of(scenes.box((2, -3, 1), (9, 1, 2)))
    camera = camera_for_view(scene, size, name, is_orthographic=True)
    assert camera.is_orthographic
    clip = outline_points(scene) @ camera.clip_from_world[:3, :3].T + camera.clip_from_world[:3, 3]
    assert np.abs(clip[:, :2]).max() == pytest.approx(1.0 - BORDER, abs=1e-9)
    assert np.abs(clip[:, 2]).max() < 1.0
    assert camera.clip_from_view[1, 1] / camera.clip_from_view[0, 0] == pytest.approx(size[0] / size[1])
