"""The edge sum as written, Σ max(0, (s_fg − s_bg)(p − e)·n) over the stored depth edges in pixels, against loops over the texels."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.relief.edges import EdgeChoice, relief_edges
from addon.maths.relief.error import EXACT, predict, predict_one, relief_set
from addon.maths.relief.frame import capture_frame
from addon.maths.relief.warp import relief_from_depth, relief_warp
from tests.margins import agree
from tests.maths.relief.rigs import IMAGE, capture_of, chosen, hull_of, ortho_at, project_texels, random_eye
from tests.maths.relief.scenes import capture, machine, orbit


def _blocks(rng: np.random.Generator, perspective: bool):
    """A small frame, random depths in blocks of 4 × 4 texels with a back, and an eye elsewhere."""
    hull = hull_of(rng)
    _, camera = capture_of(rng, hull, perspective)
    frame = capture_frame(hull, camera, IMAGE, chosen(perspective=perspective, max_texels=24))
    cut = np.s_[: frame.height, : frame.width]
    depth = np.kron(rng.uniform(0, 1, (8, 8)), np.ones((4, 4)))[cut] * frame.depth_m
    mask = np.kron(rng.uniform(0, 1, (8, 8)) < 0.8, np.ones((4, 4), bool))[cut]
    mask[1, 1] = True
    back = np.minimum(depth + 0.2 * frame.depth_m * rng.uniform(0, 1, depth.shape), frame.depth_m)
    return frame, depth, mask, back, random_eye(rng, hull, camera, False)


def _by_hand(frame, camera, depth, mask, back) -> float:
    """Pair by pair: opens in the plane by the warp's scales; a texel wide and so much long, its parallelogram is projected."""
    warp, total = relief_warp(frame, camera), 0.0
    for row in range(frame.height):
        for column in range(frame.width):
            for du, dv in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                u, v = column + du, row + dv
                if not mask[row, column] or not (0 <= u < frame.width and 0 <= v < frame.height):
                    continue
                far = depth[v, u] if mask[v, u] else back[row, column]
                if mask[v, u] and far - depth[row, column] <= EdgeChoice().edge_texels * frame.texel_m:
                    continue
                near_relief, far_relief = relief_from_depth(frame.source, np.array([depth[row, column], far]))
                n, place = -np.array([du, dv]), np.array([column + 0.5 + du / 2, row + 0.5 + dv / 2])
                opens = (warp.forward(place, near_relief) - warp.forward(place, far_relief)) @ n
                if opens > 0.0:
                    side = 0.5 * np.array([-n[1], n[0]])
                    ends = [(side, near_relief), (side, far_relief), (-side, far_relief), (-side, near_relief)]
                    x, y = np.array([project_texels(frame, camera, IMAGE, place + s, r) for s, r in ends]).T
                    x, y = x - x[0], y - y[0]
                    total += abs(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    return total


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=15, deadline=None)
def test_it_is_the_sum_over_steps_and_outline_of_what_opens(seed, perspective):
    frame, depth, mask, back, camera = _blocks(np.random.default_rng(seed), perspective)
    found = predict_one(relief_edges(frame, depth, mask, back), camera, IMAGE)["edge_written_px"]
    agree(found, _by_hand(frame, camera, depth, mask, back), rel=0.03, abs=1.0)


def test_it_knows_no_last_surface_and_takes_nothing_off():
    """What lies behind the part seen changes the edge sum, not the written one; a rod's own width bounds only the former."""
    solids = machine(np.random.default_rng(3))
    seen = capture(solids, orbit([0, 0, 0], 9.0, 0.2), (96, 72))
    with_last, without = (relief_edges(seen.frame, seen.depth, seen.mask, seen.back, last_m=last) for last in (seen.last, None))
    assert (with_last.depth_edges[:, 6] == 0.0).all()
    assert (with_last.depth_edges[:, 7] == 1.0).all()
    np.testing.assert_array_equal(with_last.depth_edges, without.depth_edges)
    camera = orbit([0, 0, 0], 9.0, 0.5)
    a, b = (predict_one(edges, camera, IMAGE) for edges in (with_last, without))
    assert a["edge_written_px"] == b["edge_written_px"] > 0.0
    assert a["edge_sum_px"] > 1.01 * b["edge_sum_px"]


def test_without_hulls_and_hidden_ends_the_two_edge_sums_are_one():
    """A step on a plate that fills the texture: nothing lies behind an outline, and what is hidden goes on."""
    camera = ortho_at([0, -10, 0], [0, 0, 0])
    frame = capture_frame(np.array([[-1.0, -1, -1], [1, 1, 1], [-1, 1, 1], [1, -1, -1]]), camera, IMAGE)
    depth = np.zeros((frame.height, frame.width))
    depth[:, frame.width // 2 :] = 0.7
    edges = relief_edges(frame, depth, np.ones(depth.shape, bool), None)
    found = predict_one(edges, ortho_at([3, -10, 1], [0, 0, 0]), IMAGE)
    assert found["edge_written_px"] == pytest.approx(found["edge_sum_px"], rel=1e-12)
    assert found["edge_written_px"] > 100.0


def test_it_is_computed_only_when_asked_for():
    members = []
    for seed in (0, 1):
        seen = capture(machine(np.random.default_rng(seed)), orbit([0, 0, 0], 9.0, 0.2), (64, 48))
        members.append(relief_edges(seen.frame, seen.depth, seen.mask, seen.back))
    textures, camera = relief_set(members), orbit([0, 0, 0], 10.0, 0.3)
    quick = predict(textures, camera, IMAGE, exact=False)
    assert not set(EXACT) & set(quick)
    assert not {"edges", "depth_edges"} & set(vars(textures)), "what only the exact predictors need is not even put together"
    together = predict(textures, camera, IMAGE)["edge_written_px"]
    for value, member in zip(together, members, strict=True):
        assert value == pytest.approx(predict_one(member, camera, IMAGE)["edge_written_px"])
