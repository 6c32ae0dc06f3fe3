"""Samples of a regular grid are drawn as one picture, others one by one; either way they are the same samples."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.spaces import orthographic
from addon.pipeline import shading, stages
from addon.pipeline.job import Job
from addon.pipeline.passes.samples import grid_side, moved, pictures, regular_grid
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes

CAMERA = scenes.look_at((14.0, -16.0, 9.0), (0.0, 0.0, 0.7), fov_y_deg=35.0, near=1.0, far=80.0)
PARALLEL = replace(CAMERA, clip_from_view=orthographic(4.0, 3.0, 1.0, 80.0))
SIZE = (96, 64)
PLENTY = 2**30


@pytest.mark.parametrize("samples", [1, 4, 9, 16])
def test_a_grid_is_known_in_any_order(samples, rng):
    grid = rng.permutation(regular_grid(samples))
    assert grid_side(grid) == round(samples**0.5)
    assert np.abs(grid).max() < 0.5 and np.allclose(grid.mean(axis=0), 0.0)


def test_another_pattern_is_no_grid():
    rotated = np.array([[0.125, 0.375], [0.375, -0.125], [-0.125, -0.375], [-0.375, 0.125]])
    assert grid_side(rotated) is None and grid_side(rotated[:3]) is None
    assert [side for _, side in pictures(CAMERA, SIZE, rotated, 16384, PLENTY)] == [1, 1, 1, 1]


def places(shots, size):
    """Where on the picture the pixels' centres of all shots lie, in pixels, by the camera's own clip space."""
    out = []
    for camera, side in shots:
        x, y = np.meshgrid((np.arange(size[0] * side) + 0.5) / side, (np.arange(size[1] * side) + 0.5) / side)
        shift = (camera.clip_from_view @ np.linalg.inv(CAMERA.clip_from_view))[:2, 3]
        out.append(np.stack([x, y], axis=-1).reshape(-1, 2) - 0.5 * shift * size)
    return np.concatenate(out)


@pytest.mark.parametrize(
    ("samples", "longest", "most_bytes", "sides"),
    [
        (4, 16384, PLENTY, [2]),
        (4, 191, PLENTY, [1] * 4),
        (4, 16384, 36 * 96 * 64 * 4 - 1, [1] * 4),
        (9, 16384, PLENTY, [3]),
        (9, 200, PLENTY, [1] * 9),
        (16, 16384, PLENTY, [4]),
        (16, 300, PLENTY, [2] * 4),
        (16, 16384, 0, [1] * 16),
        (1, 16384, 0, [1]),
    ],
)
def test_pictures_of_any_side_are_together_the_grids_samples(samples, longest, most_bytes, sides):
    shots = pictures(CAMERA, SIZE, regular_grid(samples), longest, most_bytes)
    assert [side for _, side in shots] == sides
    step = round(samples**0.5)
    cells = np.rint(places(shots, SIZE) * step - 0.5).astype(int)
    assert np.allclose(places(shots, SIZE) * step - 0.5, cells, atol=1e-6)
    assert len(np.unique(cells, axis=0)) == samples * SIZE[0] * SIZE[1]


@pytest.mark.parametrize("camera", [CAMERA, PARALLEL])
@pytest.mark.parametrize("more", [{}, {"test": {"pcf": 9, "filter_unit": "pixel"}}, {"shading": {"display": "aliasing"}}])
def test_one_picture_of_the_samples_is_the_mean_of_a_picture_a_sample(renderer, monkeypatch, camera, more):
    """But where a fragment's edge passes within 1/256 pixel of a sample. Softness and error stay those of the picture's own pixels."""
    chosen = Settings().replaced(fit={"size": 128}).replaced(**more).replaced(shading={"samples": 4})
    job = Job(scenes.staircase(), camera, scenes.sun(40.0), chosen, SIZE)
    one = run(job, on=renderer).frame.passes["combined"]
    monkeypatch.setattr(shading, "spare_bytes", lambda *_: 0)
    each = run(job, on=renderer).frame.passes["combined"]
    assert np.mean(np.abs(one - each).max(axis=-1) > 2e-3) < 0.02
    assert abs(float(one.mean() - each.mean())) < 1e-4


@pytest.mark.parametrize("samples", [1, 4])
def test_asked_again_with_the_same_surfaces_nothing_is_drawn_but_light(renderer, monkeypatch, samples):
    drawn = []
    draw = stages.draw_gbuffer
    monkeypatch.setattr(stages, "draw_gbuffer", lambda *a: (drawn.append(a[2].size), draw(*a))[1])
    chosen = Settings().replaced(fit={"size": 64}, shading={"samples": samples})
    job = Job(scenes.chair(), CAMERA, scenes.sun(40.0), chosen, (40 + samples, 30))  # a size that no other test has drawn
    first = run(job, on=renderer).frame.passes["combined"]
    assert len(drawn) == (1 if samples == 1 else 2)
    run(replace(job, light=scenes.sun(20.0)), on=renderer)
    assert np.array_equal(first, run(job, on=renderer).frame.passes["combined"])
    assert len(drawn) == (1 if samples == 1 else 2)


def test_a_moved_camera_sees_at_its_pixels_centres_what_the_other_sees_beside_them():
    offset = np.array([0.25, -0.4])
    point = CAMERA.eye_ws + 7.0 * CAMERA.direction_ws + [0.3, 0.2, -0.1]
    clip = [c.clip_from_world @ np.append(point, 1.0) for c in (CAMERA, moved(CAMERA, SIZE, offset))]
    pixels = [0.5 * (c[:2] / c[3] + 1.0) * SIZE for c in clip]
    assert np.allclose(pixels[0] - pixels[1], offset)
