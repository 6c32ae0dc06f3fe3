"""The metrics against their definitions, by brute force on small random images, and on drawings whose answer is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.error import comparison
from addon.maths.error.comparison import Cracks
from tests.margins import agree

seeds = st.integers(0, 2**32 - 1)


def is_uniform(edges, texel_px):
    """For every pixel, as an image."""
    shape = edges.across.shape[0], edges.down.shape[1]
    return comparison.is_uniform(edges, np.argwhere(np.ones(shape, dtype=bool)), texel_px).reshape(shape)


def random_image(seed, shape=(9, 13), share=0.05):
    rng = np.random.default_rng(seed)
    return rng.random(shape) < rng.uniform(0.0, 4.0 * share)


@settings(max_examples=60)
@given(seeds, st.integers(1, 20))
def test_distances_are_euclidean_distances_to_the_nearest_mark_up_to_the_limit(seed, limit):
    marks = random_image(seed)
    cells, marked = np.argwhere(np.ones_like(marks)), np.argwhere(marks)
    expected = np.full(len(cells), float(limit))
    if len(marked):
        expected = np.minimum(np.sqrt(((cells[:, None] - marked[None]) ** 2).sum(axis=-1)).min(axis=1), limit)
    agree(comparison.distances(marks, cells, limit), expected, abs=1e-12)


@settings(max_examples=40)
@given(seeds)
def test_cracks_lie_between_neighbours_that_differ(seed):
    labels = np.random.default_rng(seed).integers(0, 3, (6, 7))
    grid = comparison.changes(labels).on_half_pixels()
    for y, x in np.argwhere(np.ones_like(grid)):
        between = y % 2 != x % 2
        assert grid[y, x] == (between and labels[y // 2, x // 2] != labels[(y + 1) // 2, (x + 1) // 2])


@settings(max_examples=40)
@given(seeds, st.floats(0.0, 6.0))
def test_uniform_means_no_crack_and_no_border_within_two_pixels_or_a_texel(seed, texel_px):
    labels = random_image(seed, (17, 19), 0.004)
    edges = comparison.changes(labels)
    cracks = np.argwhere(edges.on_half_pixels()) / 2.0
    uniform = is_uniform(edges, texel_px)
    radius = max(2.0, texel_px)
    for y, x in np.argwhere(np.ones_like(labels)):
        border = min(x + 0.5, y + 0.5, 19 - 0.5 - x, 17 - 0.5 - y)
        nearest = min([border, *np.hypot(cracks[:, 0] - y, cracks[:, 1] - x)])
        assert uniform[y, x] == (nearest > radius)


def test_a_footprint_beyond_the_longest_distance_is_never_uniform():
    calm = comparison.changes(np.zeros((200, 200), dtype=bool))
    assert is_uniform(calm, 63.0)[100, 100]
    assert not is_uniform(calm, 1000.0).any()


def half_plane(shift=0, shape=(40, 60)):
    return np.broadcast_to(np.arange(shape[1])[None, :] < 30 + shift, shape).copy()


@pytest.mark.parametrize("shift", [-5, -1, 0, 2, 9])
def test_a_shifted_edge_is_displaced_by_its_shift_and_is_no_acne(shift):
    truth, preview = half_plane(), half_plane(shift)
    everything = np.ones_like(truth)
    edges = comparison.changes(truth)
    displacement, where = comparison.edge_displacements_px(edges, comparison.changes(preview))
    assert len(where) == 40 and (displacement == abs(shift)).all()
    uniform = is_uniform(edges, abs(shift))
    classes = comparison.classify(truth, preview.astype(np.float32), everything, np.ones(truth.shape), uniform)
    result = comparison.statistics(classes, displacement)
    assert result["misclassified_pct"] == pytest.approx(100.0 * abs(shift) / 60)
    assert result["acne_pct"] == result["leak_pct"] == 0.0
    assert result["edge_px_median"] == result["edge_px_p95"] == abs(shift)


def test_a_shift_beyond_a_texel_is_acne_or_leak_from_the_reach_of_the_edge_on():
    truth, edges = half_plane(), comparison.changes(half_plane())
    uniform = is_uniform(edges, 3.0)
    for shift, key in ((9, "leak_pct"), (-9, "acne_pct")):
        classes = comparison.classify(truth, half_plane(shift).astype(float), np.ones_like(truth), np.ones(truth.shape), uniform)
        result = comparison.statistics(classes, np.empty(0))
        excused_columns, border_rows = 3, 2 * 3
        assert result[key] == pytest.approx(100.0 * (9 - excused_columns) * (40 - border_rows) / (40 * 60))


@settings(max_examples=40)
@given(seeds)
def test_the_classes_are_what_their_names_say(seed):
    rng = np.random.default_rng(seed)
    lit, counted, uniform = rng.random((3, 8, 9)) < 0.5
    shadow, facing = rng.random((8, 9)), rng.uniform(0.0, 0.03, (8, 9))
    classes = comparison.classify(lit, shadow, counted, facing, uniform)
    partition = rng.integers(0, 3, (8, 9))
    whole = comparison.statistics(classes, np.array([1.0, 3.0]))
    wrong = [(y, x) for y in range(8) for x in range(9) if counted[y, x] and (shadow[y, x] >= 0.5) != lit[y, x]]
    acne = [p for p in wrong if lit[p] and uniform[p] and facing[p] > comparison.ACNE_THRESHOLD]
    leak = [p for p in wrong if not lit[p] and uniform[p]]
    assert whole["pixels"] == counted.sum()
    for key, pixels in (("misclassified_pct", wrong), ("acne_pct", acne), ("leak_pct", leak)):
        agree(whole[key], 100.0 * len(pixels) / counted.sum(), rel=1e-6)
        parts = [comparison.statistics(classes, np.empty(0), partition == k) for k in range(3)]
        agree(sum(part[key] * part["pixels"] for part in parts if part["pixels"]), whole[key] * whole["pixels"], rel=1e-6)
    image = comparison.difference_image(classes, lit, np.zeros_like(lit))
    colored = {
        tuple(np.float32(c)): [tuple(p) for p in np.argwhere((image == np.float32(c)).all(axis=-1))]
        for c in (comparison.ACNE_COLOR, comparison.LEAK_COLOR, comparison.EDGE_COLOR)
    }
    assert list(colored.values()) == [acne, leak, [p for p in wrong if p not in acne + leak]]


def test_nothing_counted_gives_none_not_zero():
    nothing = np.zeros((4, 5), dtype=bool)
    result = comparison.statistics(comparison.classify(nothing, np.ones((4, 5)), nothing, np.ones((4, 5)), nothing), np.empty(0))
    assert result == {"pixels": 0, **dict.fromkeys(("misclassified_pct", "acne_pct", "leak_pct", "edge_px_median", "edge_px_p95"))}


def test_edges_missing_from_the_preview_count_as_the_longest_distance():
    edges = comparison.changes(half_plane())
    none = Cracks(np.zeros_like(edges.across), np.zeros_like(edges.down))
    displacement, _ = comparison.edge_displacements_px(edges, none)
    assert (displacement == comparison.LARGEST_DISTANCE_PX).all() and len(displacement) == 40


def test_creases_are_no_depth_breaks_but_steps_between_parallel_planes_are():
    x, y = np.meshgrid(np.arange(30) * 0.1, np.arange(20) * 0.5)
    flat = np.stack([x, y, np.zeros_like(x)], axis=-1)
    up, pixel = np.broadcast_to([0.0, 0.0, 1.0], flat.shape), np.full(x.shape, 0.1)
    calm = comparison.depth_breaks(flat, up, pixel)
    assert not calm.across.any() and not calm.down.any(), "a plane seen at a grazing angle has no step"
    stepped = flat.copy()
    stepped[:, 15:, 2] -= 0.3
    broken = comparison.depth_breaks(stepped, up, pixel)
    assert broken.across[:, 14].all() and broken.across.sum() == 20 and not broken.down.any()
    creased, normals = flat.copy(), up.copy()
    creased[:, 15:, 0], creased[:, 15:, 2] = 1.45, 0.1 * (np.arange(15) + 0.5)
    normals[:, 15:] = [-1.0, 0.0, 0.0]
    assert not comparison.depth_breaks(creased, normals, pixel).across.any(), "floor and wall meet: one surface"
