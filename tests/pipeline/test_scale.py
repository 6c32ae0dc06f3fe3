"""Small parts on grounds of any size against exact truth: a subset of `benchmarks.scale`, and the same without the mends."""

from contextlib import closing
from math import inf

import numpy as np
import pytest

pytest.importorskip("bpy")
from addon.maths.shadow import crop, cut  # noqa: E402
from addon.pipeline.gl.context import GpuWorker  # noqa: E402
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer  # noqa: E402
from addon.scene.local_origin import FARTHEST, based_near, nearest_m  # noqa: E402
from addon.studies.run import run
from benchmarks.scale import METHODS, rows_of  # noqa: E402
from benchmarks.scale_scenes import SIZE, scale_scene  # noqa: E402

# by what failed once: quads of 10,000 and more times the part, level and tilted, off the middle; a point and a spot on a large ground
CASES = (3, 16, 21, 24, 42, 43, 51, 55, 144)
HUGE = (3, 21, 24, 144)


@pytest.fixture(scope="module")
def renderer():
    return Renderer()


@pytest.mark.parametrize("number", CASES)
def test_shadows_are_right_whatever_the_size_of_the_ground(renderer, number):
    methods = {name: METHODS[name] for name in ("defaults", "triangle", "psm", "logpsm")}
    for row in rows_of(scale_scene(number), methods, renderer):
        assert row["pixels"] > 4000
        assert row["misclassified_pct"] <= (0.2 if row["method"] == "triangle" else 0.6), row
        assert row["acne_pct"] <= 0.1, row
        assert row["precision"] < 0.1, row


@pytest.mark.parametrize("number", HUGE)
def test_without_cutting_the_report_warns_of_what_then_fails(monkeypatch, number):
    monkeypatch.setattr(cut, "LARGE", inf)
    monkeypatch.setattr(crop, "HIGHEST", inf)
    case = scale_scene(number)
    with closing(GpuWorker()) as worker:  # of its own: what was drawn with the mends is not drawn again
        job = Job(case.scene, case.camera, case.light, METHODS["defaults"], SIZE, ("combined", "shadow"))
        frame = run(job, on=Renderer(worker)).frame
    truth = case.heap.truth(case.camera, case.light, SIZE)
    wrong = np.mean((truth.lit != (frame.passes["shadow"] > 0.5)) & truth.lit_facing)
    assert wrong > 0.05
    assert frame.measured["precision"]["worst_ratio"] > 1.0
    assert frame.measured["precision"]["where"]["cause"] == "triangle"
    assert [line for line in frame.warnings if "may be wrong by" in line]


def test_what_is_right_is_not_warned_of(renderer):
    for number in (0, 3, 55):
        case = scale_scene(number)
        frame = run(Job(*based_near(case.scene, case.camera, case.light), METHODS["defaults"], SIZE, ("combined",)), on=renderer).frame
        assert not [line for line in frame.warnings if "may be wrong by" in line]


def test_the_local_origin_moves_only_where_float32_would_show():
    small, large = scale_scene(0), scale_scene(3)
    assert based_near(small.scene, small.camera, small.light)[0] is small.scene
    scene, camera, light = based_near(large.scene, large.camera, large.light)
    assert np.abs(camera.eye_ws).max() <= FARTHEST * nearest_m(scene, camera)
    assert np.allclose(camera.eye_ws + scene.origin_ws, large.camera.eye_ws + large.scene.origin_ws, rtol=0.0, atol=1e-6)
    assert based_near(large.scene, large.camera, large.light)[0] is scene
    assert based_near(scene, camera, light)[0] is scene
