"""The sample scene from 15 light/view pairs, against ray-traced truth: no acne, no detached shadows."""

import numpy as np
import pytest

pytest.importorskip("embreex")

from addon.scene.default_view import camera_for_view, camera_from_eye  # noqa: E402
from addon.scene.platform_deck import build  # noqa: E402
from addon.settings.groups import Settings  # noqa: E402
from addon.studies.truth import TruthTracer, compare_view  # noqa: E402
from benchmarks.views import lights  # noqa: E402
from tests.from_cad import scene_from_model  # noqa: E402

SIZE = (320, 180)
SMALL = Settings().replaced(fit={"size": 512})


@pytest.fixture(scope="module")
def deck():
    """The smallest deck, as a scene and its tracer."""
    scene = scene_from_model(build(10_000))
    return scene, TruthTracer(scene, backend="embree")


def cameras(scene):
    low, high = scene.bounds_ws() + scene.origin_ws
    middle = (low + high) / 2
    return {
        "iso": camera_for_view(scene, SIZE),
        "low": camera_from_eye(scene, SIZE, (high[0] + 14.0, low[1] - 6.0, 6.0), tuple(middle)),
        "on deck": camera_from_eye(scene, SIZE, (low[0] + 3.0, middle[1], 3.0), (high[0], middle[1] + 4.0, 1.0)),
    }


@pytest.mark.parametrize("view", ["iso", "low", "on deck"])
@pytest.mark.parametrize("light", ["high", "side", "behind", "ahead", "low"])
def test_no_acne_and_no_detached_shadow_without_any_number_from_the_user(renderer, deck, view, light):
    scene, tracer = deck
    camera = cameras(scene)[view]
    with np.errstate(all="ignore"):  # the tracer's own backend divides by zero on rays along axes
        _, truth, metrics, _ = compare_view(scene, camera, lights(camera)[light], SMALL, SIZE, renderer, tracer)
    assert truth.lit_facing.sum() > 800
    assert metrics["acne_pct"] <= 0.02
    assert metrics["leak_pct"] <= 0.1
