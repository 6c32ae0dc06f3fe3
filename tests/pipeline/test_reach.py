"""Sums over many lights against rays through every triangle in float64."""

import numpy as np
import pytest

from addon.maths.light_set import LightSet, all_round
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.pipeline.reach_choice import COSINES, ReachChoice
from addon.pipeline.reach_tasks import sums_at_places, sums_of_pixels
from addon.settings.groups import Settings, ShadowTestChoice
from tests import scenes
from tests.margins import at_most
from tests.pipeline.oracle import is_blocked, surface_points

SIZE = 96, 54
SUNS = np.stack([scenes.sun(e, a).direction_ws for e in (15, 40, 70) for a in (10, 130, 250)])
TIMES = LightSet(SUNS, np.linspace(0.5, 1.5, len(SUNS)))


def asked(renderer, scene, task, *arguments, camera=None, size=SIZE):
    job = Job(scene, camera or scenes.look_at((6, -5, 4), (0, 0, 1)), None, Settings(), size)
    return renderer.submit(job, task, *arguments)[0].result()


def seen_of(scene):
    points, normals, objects = surface_points(scene, scenes.look_at((6, -5, 4), (0, 0, 1)), SIZE)
    return points[objects >= 0], normals[objects >= 0], objects >= 0


def traced(scene, points, normals, lights, weigh):
    """(P,) the sum over lights that reach the points of weigh(light number, cosine)."""
    out = np.zeros(len(points))
    for k, direction in enumerate(lights.directions_ws):
        cosine = normals @ direction
        lit = cosine > 1e-6
        lit[lit] = ~is_blocked(scene, points[lit], normals[lit], Light("sun", direction))
        out += np.where(lit, weigh(k, np.maximum(cosine, 0.0)), 0.0)
    return out


@pytest.mark.parametrize("make", [scenes.closed_box, scenes.staircase, scenes.open_sheet], ids=lambda make: make.__name__)
def test_times_of_pixels_and_of_places_are_those_of_rays(renderer, make):
    scene = make()
    points, normals, seen = seen_of(scene)
    expected = traced(scene, points, normals, TIMES, lambda k, _: TIMES.weights[k])
    pixels = asked(renderer, scene, sums_of_pixels, TIMES, ReachChoice(512))
    places = asked(renderer, scene, sums_at_places, points, normals, TIMES, ReachChoice(512))
    for found in (pixels[seen][:, 0], places[:, 0]):
        at_most((np.abs(found - expected) > 1e-3).mean(), 0.004)
    assert (pixels[~seen] == 0.0).all()


def test_what_the_back_gets_is_what_the_front_of_a_turned_surface_gets(renderer):
    scene = scenes.open_sheet()
    points, normals, _ = seen_of(scene)
    front = asked(renderer, scene, sums_at_places, points, normals, TIMES, ReachChoice(256))
    turned = asked(renderer, scene, sums_at_places, points, -normals, TIMES, ReachChoice(256))
    np.testing.assert_array_equal(front, turned[:, [1, 0, 3, 2]])
    at_most(np.abs(front[:, 2] + front[:, 3] - TIMES.weights.sum()).max(), 1e-4)


def test_light_from_all_round_is_that_of_rays(renderer):
    scene = scenes.staircase()
    lights = all_round(96, "cie", scenes.sun(35).direction_ws)
    points, normals, _ = seen_of(scene)
    points, normals = points[::9], normals[::9]
    found = asked(renderer, scene, sums_at_places, points, normals, lights, ReachChoice(256, sums=COSINES))
    up = lights.directions_ws[:, 2] > 0.0
    for column, share in ((0, np.ones(96)), (1, lights.brightness * up), (2, 1.0 - up)):
        expected = traced(scene, points, normals, lights, lambda k, cosine, share=share: lights.weights[k] * share[k] * cosine)
        at_most(np.abs(found[:, column] - expected).mean(), 1e-3)
    at_most(np.abs(found[:, 3] - 1.0), 0.03)


def test_the_view_has_no_part_in_what_reaches_a_place(renderer):
    """SurfacePlaces given by hand are the same whoever looks; a pixel's sums are those of its place."""
    scene = scenes.closed_box()
    points, normals, seen = seen_of(scene)
    lights = all_round(64)
    places = asked(renderer, scene, sums_at_places, points, normals, lights, ReachChoice(512, sums=COSINES))
    pixels = asked(renderer, scene, sums_of_pixels, lights, ReachChoice(512, sums=COSINES))[seen]
    at_most(np.abs(places - pixels).max(axis=1).mean(), 1e-4)


def test_lights_in_several_batches_add_up(renderer):
    scene = scenes.closed_box()
    points, normals, _ = seen_of(scene)
    small = ReachChoice(64, ShadowTestChoice(kind="depth"))
    whole = asked(renderer, scene, sums_at_places, points, normals, all_round(130), small)
    parts = [LightSet(all_round(130).directions_ws[i::2], all_round(130).weights[i::2]) for i in (0, 1)]
    added = sum(asked(renderer, scene, sums_at_places, points, normals, lights, small) for lights in parts)
    at_most(np.abs(whole - added), 1e-5)


def test_a_large_world_far_from_its_origin_changes_nothing(renderer):
    scene, offset = scenes.closed_box(), np.array([3e6, -2e6, 1e4])
    points, normals, _ = seen_of(scene)
    here = asked(renderer, scene, sums_at_places, points, normals, TIMES, ReachChoice(256))
    moved = scene.moved_by(-offset)
    camera = scenes.look_at(tuple(offset + (6, -5, 4)), tuple(offset + (0, 0, 1)))
    there = asked(renderer, moved, sums_at_places, points + offset, normals, TIMES, ReachChoice(256), camera=camera)
    at_most((np.abs(here - there).max(axis=1) > 1e-3).mean(), 0.2)


def test_without_places_or_lights_nothing_is_asked_of_the_gpu(renderer):
    scene, nothing = scenes.closed_box(), np.zeros((0, 3))
    assert asked(renderer, scene, sums_at_places, nothing, nothing, TIMES, ReachChoice()).shape == (0, 4)
    none = LightSet(nothing, np.zeros(0))
    assert (asked(renderer, scene, sums_of_pixels, none, ReachChoice()) == 0.0).all()
