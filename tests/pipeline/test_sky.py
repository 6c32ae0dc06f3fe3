"""Ambient light from the whole sky: what stands in its way, against rays through every triangle."""

from dataclasses import replace

import numpy as np
import pytest

from addon.errors import Cancelled
from addon.maths.light_set import all_round
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.pipeline.sky import sky_map_size
from addon.settings.groups import Settings
from tests import scenes
from tests.margins import agree, at_most
from tests.pipeline.oracle import is_blocked, surface_points

SIZE = 96, 54
CAMERA = scenes.look_at((6, -5, 4), (0, 0, 1))


def drawn(renderer, scene, passes=("combined",), kind="uniform", count=64, light=None, camera=CAMERA, size=SIZE, **shading):
    settings = Settings().replaced(sky={"kind": kind, "samples": count}, shading={"samples": 1, **shading})
    return renderer.submit(Job(scene, camera, light, settings, size, passes, measure=False))[0].result().passes


def traced_ao(scene, count):
    points, normals, objects = surface_points(scene, CAMERA, SIZE)
    seen, lights = objects >= 0, all_round(count)
    total = np.zeros(int(seen.sum()))
    for direction in lights.directions_ws:
        cosine = np.maximum(normals[seen] @ direction, 0.0)
        lit = cosine > 1e-6
        lit[lit] = ~is_blocked(scene, points[seen][lit], normals[seen][lit], Light("sun", direction))
        total += np.where(lit, 4.0 / count * cosine, 0.0)
    return seen, total


def test_the_pass_is_the_light_that_rays_find_and_1_in_the_open(renderer):
    scene = scenes.closed_box()
    ao = drawn(renderer, scene, ("ao",), kind="off")["ao"]
    seen, expected = traced_ao(scene, 64)
    at_most(np.abs(ao[seen] - expected).mean(), 0.01)
    assert (ao[~seen] == 1.0).all() and ao[seen].min() < 0.75


def test_the_pass_is_the_same_whatever_the_sky_of_the_picture(renderer):
    scene = scenes.closed_box()
    off, clear = (drawn(renderer, scene, ("combined", "ao"), kind=kind, light=scenes.sun(40))["ao"] for kind in ("off", "cie"))
    np.testing.assert_allclose(off, clear, atol=1e-6)


def test_where_nothing_stands_in_the_way_every_sky_that_is_even_is_the_flat_one(renderer):
    scene = scenes.scene_of(scenes.ball((0.0, 0.0, 1.0), 1.0))
    flat, sky = (drawn(renderer, scene, kind=kind, count=256)["combined"] for kind in ("off", "uniform"))
    at_most(np.abs(flat - sky).max(), 0.02)


def test_corners_get_less_and_the_rest_what_it_got(renderer):
    scene = scenes.closed_box()
    flat, sky = (drawn(renderer, scene, kind=kind, count=128)["combined"][..., 0] for kind in ("off", "uniform"))
    seen, open_share = traced_ao(scene, 64)
    assert (sky <= flat * 1.03).all()
    dark = np.zeros_like(seen)
    dark[seen] = open_share < 0.8
    assert (sky[dark] < 0.92 * flat[dark]).mean() > 0.95


def test_light_from_above_and_below_is_stopped_separately(renderer):
    """Under a wide plate the floor loses the sky and the plate's underside the ground."""
    plate = scenes.sheet((-4, 4, 0.5), (4, 4, 0.5), (4, -4, 0.5), (-4, -4, 0.5))
    camera = scenes.look_at((0, -3, 0.3), (0, 0, 0.2))
    sky = drawn(renderer, scenes.scene_of(scenes.floor(), plate), camera=camera, ambient_sky=(1, 0, 0), ambient_ground=(0, 0, 1))[
        "combined"
    ]
    floor, under = sky[-2, SIZE[0] // 2], sky[1, SIZE[0] // 2]
    assert floor[2] == 0.0 and floor[0] < 0.3 and under[0] < 0.01 and under[2] < 0.3


def test_what_a_place_gets_does_not_depend_on_who_looks(renderer):
    """The pass of two views, at the places that both see."""
    scene, other = scenes.closed_box(), scenes.look_at((5, -7, 3), (0.3, 0, 0.8))
    one = drawn(renderer, scene, ("ao",), kind="off", size=(192, 108))["ao"]
    two = drawn(renderer, scene, ("ao",), kind="off", camera=other, size=(192, 108))["ao"]
    points, _, objects = surface_points(scene, CAMERA, (192, 108))
    clip = np.concatenate([points, np.ones((*points.shape[:2], 1))], axis=-1) @ other.clip_from_world.T
    ndc = clip[..., :2] / np.where(clip[..., 3:] > 0.0, clip[..., 3:], 1.0)
    column, row = np.rint((ndc[..., 0] + 1) * 96 - 0.5).astype(int), np.rint((1 - ndc[..., 1]) * 54 - 0.5).astype(int)
    inside = (objects >= 0) & (column >= 0) & (column < 192) & (row >= 0) & (row < 108)
    there, _, seen_there = surface_points(scene, other, (192, 108))
    r, c = row[inside], column[inside]
    same = (seen_there[r, c] >= 0) & (np.linalg.norm(there[r, c] - points[inside], axis=1) < 0.06)
    assert same.sum() > 2000
    at_most(np.abs(one[inside][same] - two[r, c][same]).mean(), 0.006)


@pytest.mark.parametrize("samples", [4, 9])
def test_camera_samples_get_the_light_of_the_pixels_round_them(renderer, samples):
    scene, size = scenes.staircase(), (128, 72)
    one = drawn(renderer, scene, size=size)["combined"]
    many = drawn(renderer, scene, size=size, samples=samples)["combined"]
    truth = drawn(renderer, scene, size=(128 * 3, 72 * 3))["combined"].reshape(72, 3, 128, 3, 4).mean(axis=(1, 3))
    assert np.abs(many - truth).mean() < 0.6 * np.abs(one - truth).mean()


def test_what_did_not_change_is_not_counted_again(renderer):
    scene, stages = scenes.closed_box(), []
    settings = Settings().replaced(sky={"kind": "uniform", "samples": 16}, shading={"samples": 1})
    job = Job(scene, CAMERA, scenes.sun(40), settings, SIZE, measure=False)
    renderer.submit(job)[0].result()
    brighter = replace(job, settings=settings.replaced(shading={"light_strength": 2.0}))

    def noted(device, job, ticket):
        from addon.pipeline.renderer import render_frame

        enter = ticket.enter
        ticket.enter = lambda fraction, stage: (stages.append(stage), enter(fraction, stage))
        return render_frame(device, job, ticket)

    renderer.submit(brighter, noted)[0].result()
    assert stages and not any(stage.startswith("sky") for stage in stages)
    renderer.submit(replace(job, settings=settings.replaced(sky={"samples": 24})), noted)[0].result()
    assert any(stage.startswith("sky") for stage in stages)


def test_it_can_be_given_up_between_its_maps(renderer):
    settings = Settings().replaced(sky={"kind": "uniform", "samples": 2048}, shading={"samples": 1})

    def given_up(device, job, ticket):
        from addon.pipeline.renderer import render_frame

        enter = ticket.enter

        def watched(fraction, stage):
            ticket.is_cancelled = stage.startswith("sky")
            enter(fraction, stage)

        ticket.enter = watched
        return render_frame(device, job, ticket)

    with pytest.raises(Cancelled):
        renderer.submit(Job(scenes.closed_box(), CAMERA, None, settings, SIZE), given_up)[0].result()


def test_more_samples_need_smaller_maps():
    sizes = [sky_map_size(n, (1920, 1080)) for n in (4, 16, 64, 256, 1024)]
    assert sizes == sorted(sizes, reverse=True) and all(s % 64 == 0 for s in sizes)
    agree(sky_map_size(64, (1920, 1080)), 1358, abs=64)
