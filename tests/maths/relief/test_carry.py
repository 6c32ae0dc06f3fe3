"""Edges carried over to a nearer capture: against themselves from the same eye, against edges gathered anew, and against what is unseen."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.errors import SceneError
from addon.maths.relief.carry import carried, carries
from addon.maths.relief.edges import ReliefEdges, relief_edges
from addon.maths.relief.error import EXACT, PREDICTORS, predict_one
from addon.maths.view import Camera
from tests.margins import agree
from tests.maths.relief.rigs import chosen, look_at, random_eye
from tests.maths.relief.scenes import Capture, Solids, capture, machine, orbit

SIZE = (200, 150)
ZOOM = 2.5


def _gathered(seen: Capture) -> ReliefEdges:
    return relief_edges(seen.frame, seen.depth, seen.mask, seen.back, last_m=seen.last)


def _over(edges: ReliefEdges, seen: Capture) -> ReliefEdges:
    return carried(edges, seen.frame, int(seen.mask.sum()))


def _from(solids: Solids, distance: float, turn: float = 0.0, **choice) -> tuple[Capture, object]:
    camera = orbit(solids.hull.mean(axis=0), distance, 0.3 + turn, zoom=ZOOM)
    return capture(solids, camera, SIZE, chosen(**choice)), camera


def _machine_seen(seed: int, perspective: bool) -> tuple[Solids, Capture, Iterator[Camera]]:
    """A random machine, a capture of it, and eyes to look at it from."""
    rng = np.random.default_rng(seed)
    solids = machine(rng)
    seen, camera = _from(solids, 12.0, perspective=perspective)
    return solids, seen, (random_eye(rng, solids.hull, camera, False) for _ in range(3))


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=5, deadline=None)
def test_in_the_same_frame_carried_edges_predict_what_they_did(seed, perspective):
    _, seen, eyes = _machine_seen(seed, perspective)
    edges = _gathered(seen)
    again = _over(edges, seen)
    for eye in eyes:
        before, after = predict_one(edges, eye, SIZE), predict_one(again, eye, SIZE)
        for name in (*PREDICTORS, "covered_px"):
            agree(after[name], before[name], rel=1e-9, abs=1e-9)
    assert again.contour == edges.contour


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=5, deadline=None)
def test_finer_texels_for_the_same_eye_change_no_prediction_in_pixels(seed, perspective):
    """The edges are the same pieces in space: only a pair's place, half a texel from the outline, moves."""
    solids, seen, eyes = _machine_seen(seed, perspective)
    fine, _ = _from(solids, 12.0, perspective=perspective, texels_per_pixel=1.7)
    edges, over = _gathered(seen), _over(_gathered(seen), fine)
    for eye in eyes:
        before, after = predict_one(edges, eye, SIZE), predict_one(over, eye, SIZE)
        if np.isfinite(before["covered_px"]):
            for name in EXACT:
                agree(after[name], before[name], rel=0.01, abs=1.0)
            agree(after["edge_fast_px"], before["edge_fast_px"], rel=0.1, abs=0.005 * before["covered_px"])


@pytest.mark.parametrize("perspective", [False, True])
def test_carried_edges_predict_what_edges_gathered_anew_do(perspective):
    """From 12 to 9 and 7 radii, and on the way a turn of a degree: the median within 6 %, nine tenths within 30 %."""
    ratios = []
    for seed in range(4):
        solids = machine(np.random.default_rng(seed))
        edges = _gathered(_from(solids, 12.0, perspective=perspective)[0])
        for distance, turn in ((9.0, 0.0), (7.0, 0.02)):
            near, _ = _from(solids, distance, turn, perspective=perspective)
            assert carries(edges, near.frame)
            fresh, over = _gathered(near), _over(edges, near)
            assert over.contour == pytest.approx(fresh.contour, rel=0.25)
            for angle in (-0.3, -0.1, 0.15):
                eye = orbit(solids.hull.mean(axis=0), 0.98 * distance, 0.3 + turn + angle, 0.2 + angle / 3, zoom=ZOOM)
                ratios.append(predict_one(over, eye, SIZE)["edge_fast_px"] / predict_one(fresh, eye, SIZE)["edge_fast_px"])
    ratios = np.array(ratios)
    assert np.median(ratios) == pytest.approx(1.0, abs=0.06)
    assert (np.abs(np.log(ratios)) < np.log(1.3)).mean() >= 0.9
    assert 0.6 < ratios.min() < ratios.max() < 1.7


def test_nothing_opens_at_the_new_eye_and_critical_pairs_stay_neighbours():
    solids = machine(np.random.default_rng(4))
    near, camera = _from(solids, 8.0)
    over = _over(_gathered(_from(solids, 12.0)[0]), near)
    found = predict_one(over, camera, SIZE)
    for name in ("critical_px", "regions_sum_px", "edge_written_px", "edge_sum_px", "edge_fast_px"):
        assert found[name] == pytest.approx(0.0, abs=1e-6)
    assert found["critical"] == pytest.approx(2.0)


def test_edges_carried_twice_are_those_carried_once_from_where_they_were_gathered():
    solids = machine(np.random.default_rng(5))
    edges = _gathered(_from(solids, 12.0)[0])
    (nearer, _), (near, _) = _from(solids, 10.0), _from(solids, 8.0)
    twice, once = _over(_over(edges, nearer), near), _over(edges, near)
    assert twice.gathered is edges
    np.testing.assert_array_equal(twice.edges, once.edges)
    assert carries(_over(edges, nearer), near.frame)


def test_edges_are_gathered_anew_once_the_resolution_is_another_or_the_view_has_turned():
    solids = machine(np.random.default_rng(0))
    edges = _gathered(_from(solids, 12.0)[0])
    refused = {
        "three times as fine": _from(solids, 4.2),
        "not finer": _from(solids, 11.9),
        "turned": _from(solids, 9.0, 0.25),
        "other projection": _from(solids, 9.0, perspective=False),
    }
    for why, (seen, _) in refused.items():
        assert not carries(edges, seen.frame), why
    near, camera = _from(solids, 9.0)
    assert carries(edges, near.frame)
    middle = solids.hull.mean(axis=0)
    rolled = look_at(camera.eye_ws, middle, up=(0.3, 0.0, 1.0))
    rolled = replace(rolled, clip_from_view=camera.clip_from_view)
    assert not carries(edges, capture(solids, rolled, SIZE).frame)


def test_steps_of_twice_the_resolution_are_twice_as_long_in_texels():
    box = Solids(np.array([[[-1.0, 0.5, -1.0], [1.0, 1.0, 1.0]], [[-0.3, -1.0, -0.4], [0.3, -0.9, 0.4]]]), np.empty((0, 4)))
    seen, _ = _from(box, 12.0)
    fine, _ = _from(box, 12.0, texels_per_pixel=2.0)
    edges, over = _gathered(seen), _over(_gathered(seen), fine)
    steps, moved = (e.edges[(e.edges[:, 6] == 0.0) & (e.edges[:, 7] > 0.0)] for e in (edges, over))
    np.testing.assert_allclose(moved[:, 7], 2.0 * steps[:, 7], rtol=1e-6)
    assert over.contour == 2 * edges.contour
    assert over.contour == pytest.approx(_gathered(fine).contour, rel=0.1)


def test_an_empty_texture_is_refused():
    seen, _ = _from(machine(np.random.default_rng(1)), 12.0)
    with pytest.raises(SceneError, match="empty"):
        carried(_gathered(seen), seen.frame, 0)
