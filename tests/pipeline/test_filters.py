"""Filters keep to the surface that is seen: what is lit has no dark rim along the feet of walls, steps, flush panels and pipes."""

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


def lit_and_shown(renderer, kind, filtered, size):
    """Where all is lit for as far as the filter reaches (h, w), and the light shown; truth by rays."""
    scene, light = room(), BEHIND_THE_VIEWER
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
        clear, shown = lit_and_shown(renderer, kind, filtered, size)
        assert clear.sum() > 3000
        assert (shown[clear] < 0.9).mean() <= 1e-4, (size, (shown[clear] < 0.9).mean())


@pytest.mark.parametrize("kind", TESTS)
def test_a_filter_still_softens_shadows_on_open_ground(renderer, kind):
    cover = scenes.sheet((-6.0, 0.0, 1.0), (6.0, 0.3, 1.0), (6.0, 6.0, 1.0), (-6.0, 6.0, 1.0))
    chosen = Settings().replaced(partition={"kind": "none"}, fit={"size": 256}, test={"kind": kind, "pcf": 9})
    frame = run(Job(scenes.scene_of(scenes.floor(6.0), cover), CAMERA, scenes.sun(60.0), chosen, SIZE, ("shadow",)), on=renderer).frame
    assert len(np.unique(np.round(frame.passes["shadow"] * 9.0))) == 10
