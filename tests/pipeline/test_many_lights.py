"""Several lights and lights with a size: the picture is the sum of the pictures of hard lights, to the last digits of a float."""

from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest

from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.pipeline.render_passes import DATA_PASSES
from addon.scene.looks import CATCHER
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes

SIZE = (96, 64)
CAMERA = scenes.look_at((14.0, -16.0, 9.0), (0.0, 0.0, 0.7), fov_y_deg=35.0, near=1.0, far=80.0)
SUN = scenes.sun(40.0)
LAMP = Light("point", None, np.array([2.0, -2.5, 4.0]), color=(9.0, 8.0, 6.0), name="lamp")
SPOT = Light("spot", np.array([0.0, 0.0, 1.0]), np.array([-2.5, 1.0, 5.0]), 0.6, 0.2, color=(4.0, 9.0, 20.0), name="spot")
PANEL = Light(
    "spot",
    np.array([0.0, 0.0, 1.0]),
    np.array([1.0, 2.0, 4.0]),
    1.5,
    0.0,
    color=(9.0, 9.0, 9.0),
    name="panel",
    spread_rad=pi / 2.0,
    half_axes_ws=np.array([[0.6, 0.0, 0.0], [0.0, 0.3, 0.0]]),
)
BLACK = {"ambient_sky": (0.0, 0.0, 0.0), "ambient_ground": (0.0, 0.0, 0.0), "background": (0.0, 0.0, 0.0, 1.0)}
WORLD = {"ambient_sky": (0.3, 0.4, 0.5), "ambient_ground": (0.1, 0.1, 0.1), "background": (0.2, 0.3, 0.4, 1.0)}


def settings(samples=1, light_samples=0, world=WORLD, **shading):
    return Settings().replaced(fit={"size": 256}, shading={"samples": samples, **world, **shading}, lights={"samples": light_samples})


def picture(renderer, lights, chosen, scene=None, passes=("combined",), **more):
    job = Job(scene or scenes.closed_box(), CAMERA, lights[0], chosen, SIZE, passes, others=tuple(lights[1:]), **more)
    return run(job, on=renderer).frame.passes


@pytest.mark.parametrize("samples", [1, 4])
@pytest.mark.parametrize("test", ["triangle", "depth"])
def test_lights_add_up(renderer, samples, test):
    chosen, dark = (settings(samples, world=world).replaced(test={"kind": test}) for world in (WORLD, BLACK))
    together = picture(renderer, [SUN, LAMP, SPOT], chosen)["combined"]
    alone = [picture(renderer, [light], dark)["combined"] for light in (LAMP, SPOT)]
    expected = picture(renderer, [SUN], chosen)["combined"][..., :3] + sum(image[..., :3] for image in alone)
    assert np.abs(together[..., :3] - expected).max() < 2e-5
    assert (together[..., 3] == 1.0).all()
    assert np.abs(alone[0]).max() > 0.1 and np.abs(alone[1][..., :3]).max() > 0.1


def test_the_order_of_the_lights_does_not_matter(renderer):
    one, other = (picture(renderer, lights, settings())["combined"] for lights in ([SUN, LAMP, SPOT], [SPOT, LAMP, SUN]))
    assert np.abs(one - other).max() < 2e-5


def test_a_soft_light_is_the_mean_of_its_samples(renderer):
    sun = replace(SUN, half_angle_rad=radians(3.0))
    sampled, plain = (settings(light_samples=n).replaced(test={"smoothing": 1}) for n in (5, 0))  # soft shadows are not smoothed besides
    for light in (sun, replace(LAMP, radius=0.4), replace(SPOT, radius=0.3), PANEL):
        soft = picture(renderer, [light], sampled)["combined"]
        mean = np.mean([picture(renderer, [light.sample(k)], plain)["combined"] for k in range(5)], axis=0)
        assert np.abs(soft - mean).max() < 2e-5, light.name


@pytest.mark.parametrize("passes", [("combined",), ("combined", *DATA_PASSES)])
def test_without_samples_or_without_a_size_a_light_is_hard_to_the_last_bit(renderer, passes):
    hard = picture(renderer, [SUN], settings(4), passes=passes)
    soft = replace(SUN, half_angle_rad=radians(2.0))
    for lights, chosen in (([soft], settings(4)), ([SUN], settings(4, light_samples=64))):
        images = picture(renderer, lights, chosen, passes=passes)
        assert all(np.array_equal(image, hard[name], equal_nan=True) for name, image in images.items())
    chosen = settings(4, light_samples=64).replaced(lights={"softness": 0.0})
    assert np.array_equal(picture(renderer, [soft], chosen, passes=passes)["combined"], hard["combined"])


@pytest.mark.parametrize("samples", [1, 4])
def test_going_on_gives_the_picture_of_beginning_with_as_many_samples(renderer, samples):
    lights = [replace(SUN, half_angle_rad=radians(2.0)), LAMP]
    whole = picture(renderer, lights, settings(samples, light_samples=12))["combined"]
    picture(renderer, [SUN], settings(samples))
    scene, chosen = scenes.closed_box(), settings(samples, light_samples=12)
    steps = [picture(renderer, lights, chosen, scene, rounds=n)["combined"] for n in (2, 5, 12)]
    assert np.abs(steps[-1] - whole).max() < 2e-5
    assert np.abs(steps[0] - whole).max() > 1e-3


def test_going_on_draws_only_the_samples_that_are_missing(renderer, worker, monkeypatch):
    from addon.pipeline import stages

    drawn = []
    draw = stages.draw_shadow_maps
    monkeypatch.setattr(stages, "draw_shadow_maps", lambda *a: (drawn.append(1), draw(*a))[1])
    lights, chosen = [replace(SUN, half_angle_rad=radians(2.5))], settings(light_samples=16)
    scene = scenes.closed_box()
    for rounds in (4, 16, 16):
        picture(renderer, lights, chosen, scene, rounds=rounds, measure=False)
    assert len(drawn) == 16


def test_another_view_begins_anew(renderer):
    lights, chosen = [replace(SUN, half_angle_rad=radians(2.0))], settings(light_samples=4)
    first = picture(renderer, lights, chosen)["combined"]
    moved = Job(
        scenes.closed_box(),
        replace(CAMERA, view_from_world=CAMERA.view_from_world @ scenes.spaces.translation([0.5, 0.0, 0.0])),
        lights[0],
        chosen,
        SIZE,
    )
    run(moved, on=renderer)
    assert np.array_equal(picture(renderer, lights, chosen)["combined"], first)


def test_the_shadow_pass_is_the_share_of_all_light_that_arrives(renderer):
    scene, passes = scenes.closed_box(), ("shadow", "object")
    lights = [
        replace(SUN, color=(1.0, 1.0, 1.0), is_physical=True),
        replace(scenes.sun(60.0, azimuth_deg=200.0), color=(1.0, 1.0, 1.0), is_physical=True),
    ]
    each = [picture(renderer, [light], settings(), scene, passes)["shadow"] for light in lights]
    both = picture(renderer, lights, settings(), scene, passes)
    floor = both["object"] == 0
    up = [light.direction_ws[2] for light in lights]
    expected = (each[0] * up[0] + each[1] * up[1]) / sum(up)
    assert np.abs(both["shadow"] - expected)[floor].max() < 1e-5
    assert ((both["shadow"] > 0.05) & (both["shadow"] < 0.95))[floor].any()
    assert (both["shadow"][both["object"] < 0] == 1.0).all()


def test_a_penumbra_lies_round_the_edge_of_the_hard_shadow(renderer):
    """A disc of half angle a before an edge at the distance d along the ray makes a penumbra of about 2 a d across it."""
    scene = scenes.scene_of(scenes.floor(), scenes.sheet((-4.0, 0.0, 4.0), (4.0, 0.0, 4.0), (4.0, 4.0, 4.0), (-4.0, 4.0, 4.0)))
    above = scenes.look_at((0.0, -3.0, 3.5), (0.0, 0.0, 0.0), fov_y_deg=40.0, near=0.5, far=80.0)
    sun = Light("sun", np.array([0.0, 0.0, 1.0]), half_angle_rad=radians(4.0), color=(1.0, 1.0, 1.0), is_physical=True)
    job = Job(scene, above, sun, settings(light_samples=256).replaced(fit={"size": 512}), (64, 96), ("shadow", "position", "object"))
    passes = run(job, on=renderer).frame.passes
    column = passes["object"][:, 32] == 0
    y, lit = passes["position"][:, 32, 1][column], passes["shadow"][:, 32][column]
    half = 4.0 * np.tan(radians(4.0))
    assert (lit[y < -1.02 * half] == 1.0).all() and (lit[y > 1.02 * half] == 0.0).all()
    x = np.clip(y / half, -1.0, 1.0)
    expected = (np.arccos(x) - x * np.sqrt(1.0 - x * x)) / np.pi  # the part of a disc beyond a chord
    assert np.abs(lit - expected).max() < 0.03


@pytest.mark.parametrize("samples", [1, 4])
def test_what_only_catches_shadows_is_as_dark_as_all_lights_make_it(renderer, samples):
    """Two suns of half the strength in one place are one sun, also for what shows nothing but shadows, and holes."""
    scene = scenes.closed_box()
    flags = np.array([CATCHER, 0], np.uint8)
    scene = replace(scene, instances=replace(scene.instances, flags=flags))
    halves = [replace(SUN, color=(0.5, 0.5, 0.5)), replace(SUN, color=(0.5, 0.5, 0.5), name="other")]
    world = {**WORLD, "background": (0.1, 0.2, 0.3, 0.25)}
    one, two = (picture(renderer, lights, settings(samples, world=world), scene)["combined"] for lights in ([SUN], halves))
    assert np.abs(one - two).max() < 2e-5
    assert ((one[..., 3] > 0.3) & (one[..., 3] < 0.95)).any()


def test_a_light_that_stands_behind_nothing_casts_none(renderer):
    lights = [SUN, replace(LAMP, casts=False)]
    lit = picture(renderer, lights, settings(world=BLACK), passes=("combined",))["combined"]
    without = picture(renderer, [SUN, LAMP], settings(world=BLACK), passes=("combined",))["combined"]
    assert (lit[..., :3] >= without[..., :3] - 2e-5).all()
    assert (lit[..., :3] > without[..., :3] + 1e-3).any()


def test_data_colours_are_those_of_the_main_light_alone(renderer):
    chosen = settings(display="aliasing")
    one, many = (picture(renderer, lights, chosen)["combined"] for lights in ([SUN], [SUN, LAMP]))
    assert np.array_equal(one, many)


def test_the_maps_read_are_those_of_the_main_light(renderer):
    one, many = (
        picture(renderer, lights, settings(), passes=("texel", "combined"))["shadow_depth"] for lights in ([SUN], [SUN, LAMP, SPOT])
    )
    assert np.array_equal(one, many)


def frame_of(renderer, lights, light_samples, measure=True):
    chosen = settings(light_samples=light_samples)
    job = Job(scenes.closed_box(), CAMERA, lights[0], chosen, SIZE, others=tuple(lights[1:]), measure=measure)
    return run(job, on=renderer)


def test_the_report_tells_of_every_light(renderer):
    lights = [replace(SUN, half_angle_rad=radians(3.0), name="sun"), LAMP]
    rows = frame_of(renderer, lights, 8).report["lights"]
    assert [(row["name"], row["kind"], row["samples"]) for row in rows] == [("sun", "sun", 8), ("lamp", "point", 1)]
    assert sum(row["share_of_time"] for row in rows) == pytest.approx(1.0) and rows[0]["share_of_time"] > rows[1]["share_of_time"]
    assert rows[0]["error_estimate"] > 0.0 and rows[1]["error_estimate"] == 0.0
    alone = frame_of(renderer, [LAMP], 0).report["lights"]
    assert alone == [
        {"name": "lamp", "kind": "point", "strength": pytest.approx(23.0 / 3.0), "samples": 1, "share_of_time": 1.0, "error_estimate": 0.0}
    ]


def test_the_estimated_error_bounds_the_true_one(renderer):
    lights = [replace(SUN, half_angle_rad=radians(8.0)), LAMP]
    few, many = frame_of(renderer, lights, 16), frame_of(renderer, lights, 256)
    true = np.sqrt(((few.frame.passes["combined"] - many.frame.passes["combined"])[..., :3] ** 2).mean())
    estimated = few.report["lights"][0]["error_estimate"]
    assert true / 1.3 < estimated < 8.0 * true
    assert many.report["lights"][0]["error_estimate"] < 0.6 * estimated


def test_the_surfaces_are_read_back_once_however_many_samples_a_light_has(renderer, monkeypatch):
    from addon.pipeline import see_through

    read, worked_out = [], see_through.surface_points_ws
    monkeypatch.setattr(see_through, "surface_points_ws", lambda *given: read.append(given) or worked_out(*given))
    picture(renderer, [replace(LAMP, radius=0.31)], settings(light_samples=7))
    assert len(read) == 1
