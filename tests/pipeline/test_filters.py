"""Filters keep to the surface that is seen: what is lit has no dark rim along the feet of walls, steps, flush panels and pipes."""

from functools import cache

import numpy as np
import pytest

from addon.pipeline.job import Job
from addon.settings.groups import TESTS, Settings
from addon.studies.run import run
from tests import scenes
from tests.pipeline import oracle

SIZE = (160, 90)
CAMERA = scenes.look_at((0.4, -4.6, 2.9), (0.0, 0.0, 0.3), near=0.3, far=60.0)
BEHIND_THE_VIEWER = scenes.sun(42.0, 262.0)
FILTERS = (
    *({"pcf": k} for k in (4, 9, 16, 25)),
    {"pcf": 9, "filter_unit": "pixel", "filter_width": 3.0},
    {"pcf": 25, "filter_unit": "pixel", "filter_width": 5.0},
    {"pcf": 9, "filter_unit": "metre", "filter_width": 0.1},
    *({"depths": n} for n in (2, 3, 4, 8)),
    {"pcf": 9, "depths": 3},
)

PIXEL_FILTERS = (
    {"pcf": 16, "filter_unit": "pixel", "filter_width": 1.0},
    {"pcf": 9, "filter_unit": "pixel", "filter_width": 3.0},
)


@cache
def room():
    """A floor, a wall behind it, a panel of a millimetre and one of 6 cm on both, a step and a pipe along the wall's foot."""
    floor = scenes.floor(4.0)
    wall = scenes.box((-3.0, 1.5, 0.0), (3.0, 1.7, 2.5))
    panels = [scenes.box((x, -0.6, 0.0), (x + 0.5, 0.2, h)) for x, h in ((-1.6, 0.001), (-0.5, 0.06))]
    signs = [scenes.box((x, 1.5 - h, 0.8), (x + 0.6, 1.5, 1.3)) for x, h in ((-1.5, 0.001), (0.3, 0.06))]
    step = scenes.box((0.8, 0.0, 0.0), (2.6, 1.5, 0.15))
    pipe = scenes.rod((-2.8, 1.38, 0.12), (0.7, 1.38, 0.12), 0.12, 24)
    return scenes.scene_of(floor, wall, *panels, *signs, step, pipe)


def kept_away(mask, radius):
    """Pixels with none of `mask` within `radius`."""
    padded = np.pad(mask, radius)
    return ~np.lib.stride_tricks.sliding_window_view(padded, (2 * radius + 1, 2 * radius + 1)).any(axis=(2, 3))


def lit_and_shown(renderer, kind, filtered, size, scene):
    """Where all is lit for as far as the filter reaches (h, w), and the light shown; truth by rays."""
    light = BEHIND_THE_VIEWER
    chosen = Settings().replaced(partition={"kind": "none"}, fit={"size": size}, test={"kind": kind, **filtered})
    frame = run(Job(scene, CAMERA, light, chosen, SIZE, ("shadow", "object")), on=renderer).frame
    points, normals, objects = oracle.surface_points(scene, CAMERA, SIZE)
    facing = (objects >= 0) & (normals @ light.direction_ws > 0.01)
    lit = facing.copy()
    lit[facing] = ~oracle.is_blocked(scene, points[facing], normals[facing], light)
    return lit & (objects == frame.passes["object"]) & kept_away(facing & ~lit, 6), frame.passes["shadow"]


@pytest.mark.parametrize("kind", TESTS)
@pytest.mark.parametrize("filtered", FILTERS, ids=lambda f: "-".join(map(str, f.values())))
def test_a_filter_darkens_nothing_that_is_lit_as_far_as_it_reaches(renderer, kind, filtered):
    if kind == "triangle" and "depths" in filtered:
        pytest.skip("the exact test has no depths")
    for size in (256, 1024):
        clear, shown = lit_and_shown(renderer, kind, filtered, size, room())
        assert clear.sum() > 3000
        assert (shown[clear] < 0.9).mean() <= 1e-4, (size, (shown[clear] < 0.9).mean())


@cache
def lit_by_sixteen_rays(scene):
    """(h, w) pixels that four by four rays find lit, and those round them too: thin shadows that no centre meets count as shadows."""
    many = SIZE[0] * 4, SIZE[1] * 4
    points, normals, objects = oracle.surface_points(scene, CAMERA, many)
    facing = (objects >= 0) & (normals @ BEHIND_THE_VIEWER.direction_ws > 0.01)
    lit = facing.copy()
    lit[facing] = ~oracle.is_blocked(scene, points[facing], normals[facing], BEHIND_THE_VIEWER)
    by_pixel = [mask.reshape(SIZE[1], 4, SIZE[0], 4).swapaxes(1, 2).reshape(SIZE[1], SIZE[0], 16) for mask in (lit, facing & ~lit)]
    return by_pixel[0].all(axis=2) & kept_away(by_pixel[1].any(axis=2), 1)


@pytest.mark.parametrize("smoothing", [5, 13])
def test_smooth_edges_darken_nothing_that_is_lit(renderer, smoothing):
    scene = room()
    clear = lit_by_sixteen_rays(scene)
    for size in (256, 1024):
        chosen = Settings().replaced(
            partition={"kind": "none"},
            fit={"size": size},
            test={"smoothing": smoothing},
            shading={"display": "shadow", "samples": 1},
        )
        shown = run(Job(scene, CAMERA, BEHIND_THE_VIEWER, chosen, SIZE), on=renderer).frame.passes["combined"][..., 0]
        assert clear.sum() > 3000
        assert (shown[clear] < 0.9).mean() <= 1e-4, (size, (shown[clear] < 0.9).mean())


def coverage_error(renderer, samples, smoothing, turn_deg=27.0):
    """Rms error of the shown light on the pixels that one straight edge of a shadow crosses, against the share of each that is lit."""
    a = np.radians(turn_deg)
    along, away, top = np.array([np.cos(a), np.sin(a), 0.0]), np.array([-np.sin(a), np.cos(a), 0.0]), np.array([0.0, 0.0, 2.0])
    corners = (top - 6.0 * along, top + 6.0 * along, top + 6.0 * along + 6.0 * away, top - 6.0 * along + 6.0 * away)
    scene = scenes.scene_of(scenes.floor(6.0), scenes.sheet(*(tuple(p) for p in corners)))
    camera = scenes.look_at((0.0, -0.2, 1.4), (0.0, 0.0, 0.0), near=0.2, far=20.0)
    chosen = Settings().replaced(test={"smoothing": smoothing}, shading={"display": "shadow", "samples": samples})
    shown = run(Job(scene, camera, scenes.sun(90.0), chosen, SIZE), on=renderer).frame.passes["combined"][..., 0]
    x, y = (np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1).reshape(-1, 2).T + 0.5) / 16.0
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    ndc = np.stack([2.0 * (columns[..., None] + x) / SIZE[0] - 1.0, 1.0 - 2.0 * (rows[..., None] + y) / SIZE[1]], axis=-1)
    world_from_clip = np.linalg.inv(camera.clip_from_view @ camera.view_from_world)
    near = ndc @ world_from_clip[:, :2].T + world_from_clip[:, 3] - world_from_clip[:, 2]
    far = ndc @ world_from_clip[:, :2].T + world_from_clip[:, 3] + world_from_clip[:, 2]
    near, far = near[..., :3] / near[..., 3:], far[..., :3] / far[..., 3:]
    on_floor = near + (far - near) * (near[..., 2] / (near[..., 2] - far[..., 2]))[..., None]
    truth = (on_floor @ away < 0.0).mean(axis=2)
    crossed = (truth > 0.0) & (truth < 1.0)
    assert crossed.sum() > 50
    return float(np.sqrt(np.mean((shown - truth)[crossed] ** 2)))


def test_the_edge_of_a_shadow_is_as_smooth_with_one_camera_sample_as_with_many(renderer):
    plain, smooth = (coverage_error(renderer, 1, k) for k in (1, 13))
    assert smooth < 0.2 * plain and smooth < 0.06
    assert coverage_error(renderer, 4, 5) < 0.4 * coverage_error(renderer, 4, 1)


def test_an_upright_edge_has_as_many_levels_as_a_slanted_one(renderer):
    assert max(coverage_error(renderer, 1, 13, turn) for turn in (3.0, 45.0, 87.0)) < 0.08


def test_data_passes_are_tested_at_pixel_centres_whatever_the_smoothing(renderer):
    passes = ("combined", "shadow")
    for samples in (1, 4):
        chosen = Settings().replaced(fit={"size": 256}, shading={"samples": samples})
        shown = run(Job(room(), CAMERA, BEHIND_THE_VIEWER, chosen, SIZE, passes), on=renderer).frame.passes["shadow"]
        assert set(np.unique(shown)) == {0.0, 1.0}


@pytest.mark.parametrize("kind", TESTS)
@pytest.mark.parametrize("filtered", PIXEL_FILTERS, ids=lambda f: f"{f['pcf']}-{f['filter_width']:g}px")
def test_beside_bars_that_pass_between_the_centres_of_pixels_hardly_a_pixel_is_darkened(renderer, kind, filtered):
    """What the bars shade they hide from the eye, most of them too thin for a pixel to show: else a tenth of the floor."""
    bars = [scenes.box((-3.0, y, 0.0), (3.0, y + 0.012, 0.03)) for y in np.linspace(-1.8, 2.0, 14)]
    clear, shown = lit_and_shown(renderer, kind, filtered, 2048, scenes.scene_of(scenes.floor(4.0), *bars))
    assert clear.sum() > 3000
    assert (shown[clear] < 0.9).mean() <= 5e-4, (shown[clear] < 0.9).mean()


@pytest.mark.parametrize("kind", TESTS)
def test_a_filter_still_softens_shadows_on_open_ground(renderer, kind):
    cover = scenes.sheet((-6.0, 0.0, 1.0), (6.0, 0.3, 1.0), (6.0, 6.0, 1.0), (-6.0, 6.0, 1.0))
    chosen = Settings().replaced(partition={"kind": "none"}, fit={"size": 256}, test={"kind": kind, "pcf": 9})
    frame = run(Job(scenes.scene_of(scenes.floor(6.0), cover), CAMERA, scenes.sun(60.0), chosen, SIZE, ("shadow",)), on=renderer).frame
    assert len(np.unique(np.round(frame.passes["shadow"] * 9.0))) == 10
