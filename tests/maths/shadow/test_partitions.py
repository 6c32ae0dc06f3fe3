"""Split distances against the texts' definitions."""

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.choices import PARTITIONS, PartitionChoice
from addon.maths.error.aliasing import max_error_z
from addon.maths.error.warped_map import WarpedMap
from addon.maths.shadow.partitions import split_distances
from tests.margins import agree, at_most
from tests.maths.views import reals, views

counts = st.integers(1, 8)
kinds = st.sampled_from(PARTITIONS)


@given(views(max_ratio=1e7), kinds, counts, reals(0.0, 1.0), st.floats(1.01, 50.0), st.none() | st.floats(1e-3, 1e4))
def test_splits_increase_strictly_from_near_to_far_and_keep_their_count(view, kind, count, weight, alpha, pseudo_near):
    choice = PartitionChoice(kind, count, weight, (alpha,), pseudo_near)
    splits = split_distances(choice, view.near, view.far, view.gamma)
    assert splits.shape == (choice.z_count + 1,) and splits.dtype == np.float64
    assert splits[0] == view.near and splits[-1] == view.far
    assert (np.diff(splits) > 0.0).all()


@given(views(), counts)
def test_log_splits_are_self_similar(view, count):
    splits = split_distances(PartitionChoice("z-log", count), view.near, view.far, view.gamma)
    agree(splits[1:] / splits[:-1], view.ratio ** (1 / count), rel=1e-9)


@given(views(min_ratio=1.5), st.integers(2, 6), st.integers(0, 5), reals(-0.3, 0.3))
def test_no_other_splits_have_a_smaller_largest_error(view, count, which, shift):
    def worst(splits):
        return max(max_error_z(WarpedMap(a, b, view.phi)) for a, b in zip(splits[:-1], splits[1:], strict=True))

    splits = split_distances(PartitionChoice("z-log", count), view.near, view.far, view.gamma)
    moved = splits.copy()
    i = 1 + which % (count - 1)
    moved[i] *= (splits[i + 1] / splits[i]) ** shift
    at_most(worst(splits) / worst(moved) - 1.0, 1e-12)


@given(views(), counts, reals(0.0, 1.0))
def test_pssm_is_the_weighted_mean_of_log_and_linear(view, count, weight):
    log, linear, pssm = (
        split_distances(PartitionChoice(kind, count, weight), view.near, view.far, view.gamma) for kind in ("z-log", "z-linear", "z-pssm")
    )
    agree(pssm, weight * log + (1 - weight) * linear, rel=1e-12)
    agree(np.diff(linear), (view.far - view.near) / count, rel=1e-6)


@given(views(max_ratio=1e7), counts, st.floats(1.5, 6.0))
def test_adaptive_splits_are_self_similar_under_overhead_light(view, count, alpha):
    choices = (PartitionChoice(kind, count, alpha=(alpha,)) for kind in ("z-log", "z-adaptive"))
    log, adaptive = (split_distances(choice, view.near, view.far, pi / 2) for choice in choices)
    agree(adaptive, log, rel=1e-9)


@given(views(max_ratio=1e7), counts)
def test_without_alpha_the_cut_decides(view, count):
    """T4's slabs take its usual α = 3; planes along the light, which need no adapting to γ, self-similar splits."""

    def splits(kind, **choice):
        return split_distances(PartitionChoice(kind, count, **choice), view.near, view.far, view.gamma)

    assert np.array_equal(splits("z-adaptive", cut="view"), splits("z-adaptive", cut="view", alpha=(3.0,)))
    for cut in ("light", "halves"):
        assert np.array_equal(splits("z-adaptive", cut=cut), splits("z-log", cut=cut))
        assert np.array_equal(splits("z-adaptive", cut=cut, alpha=(3.0,)), splits("z-adaptive", cut="view"))


@given(views(min_ratio=1e3, max_ratio=1e6), st.integers(2, 6), st.lists(st.floats(1.2, 3.5), min_size=1, max_size=5))
def test_adaptive_splits_are_the_text_s_recursion_where_it_stays_above_near(view, count, alphas):
    weight, n = view.gamma / (pi / 2), view.near
    f, expected, valid = view.far, [view.far], True
    for i in range(count, 1, -1):
        alpha = alphas[min(i - 2, len(alphas) - 1)]
        valid &= alpha ** (i - 0.5) <= f / n
        f = weight * n * (f / n) ** ((i - 1) / i) + (1 - weight) * f / alpha
        expected.append(f)
    splits = split_distances(PartitionChoice("z-adaptive", count, alpha=tuple(alphas)), view.near, view.far, view.gamma)
    if valid:
        agree(splits[1:][::-1], expected, rel=1e-9)


@given(views(), st.integers(2, 8))
def test_parallel_light_keeps_every_ratio_but_the_first_at_alpha_or_below(view, count):
    splits = split_distances(PartitionChoice("z-adaptive", count, alpha=(3.0,)), view.near, view.far, 0.0)
    ratios = splits[1:] / splits[:-1]
    assert (ratios[1:] <= 3.0 * (1 + 1e-12)).all()
    if view.ratio < 3.0 ** (count - 0.5):  # where the text would fall below near: the first partition gets half the others' log share
        agree(ratios[0], sqrt(ratios[1]), rel=1e-9)


@given(views(min_ratio=2.0), st.integers(2, 8))
def test_splits_move_without_a_jump_while_the_light_turns(view, count):
    angles = np.linspace(0.0, pi / 2, 181)
    splits = np.array([split_distances(PartitionChoice("z-adaptive", count, alpha=(3.0,)), view.near, view.far, float(g)) for g in angles])
    assert (splits[0] != splits[-1]).any()  # they do move
    at_most(np.abs(np.diff(np.log(splits), axis=0)).max(), 0.2)


@given(views(min_ratio=10.0), st.integers(2, 8), st.floats(0.1, 0.9))
def test_pseudo_near_splits_start_at_the_plane_and_go_on_self_similar(view, count, share):
    first = view.near * view.ratio ** (1 / count)
    plane = first + share * (view.far / view.ratio ** (0.25 / count) - first)
    splits = split_distances(PartitionChoice("z-pseudo-near", count, pseudo_near=plane), view.near, view.far, view.gamma)
    agree(splits[1], plane, rel=1e-12)
    agree(splits[2:] / splits[1:-1], (view.far / plane) ** (1 / (count - 1)), rel=1e-9)


@given(views(min_ratio=10.0), st.integers(3, 8))
def test_pseudo_near_splits_are_better_than_pssm_behind_the_first_partition(view, count):
    choices = (PartitionChoice(kind, count) for kind in ("z-pseudo-near", "z-pssm"))
    np_splits, pssm = (split_distances(choice, view.near, view.far, view.gamma) for choice in choices)
    agree(np_splits[1], pssm[1], rel=1e-12)
    at_most((np_splits[2:] / np_splits[1:-1]).max() / (pssm[2:] / pssm[1:-1]).max() - 1.0, 1e-12)


def test_a_pseudo_near_plane_before_near_asks_for_log_splits():
    plane, log = PartitionChoice("z-pseudo-near", 4, pseudo_near=0.5), PartitionChoice("z-log", 4)
    np.testing.assert_allclose(split_distances(plane, 1.0, 100.0, 1.0), split_distances(log, 1.0, 100.0, 1.0), rtol=1e-12)


def test_orthographic_views_are_divided_evenly_even_from_behind_the_eye():
    np.testing.assert_allclose(split_distances(PartitionChoice("z-log", 4), -10.0, 10.0, 1.0, orthographic=True), [-10, -5, 0, 5, 10])


@pytest.mark.parametrize(
    "near, far, gamma",
    [(0.0, 1.0, 0.0), (2.0, 1.0, 0.0), (1.0, float("nan"), 0.0), (1.0, 2.0, 3.0), (1.0, 2.0, float("nan")), (1.0, 1.0 + 8e-16, 1.0)],
)
def test_ranges_that_cannot_be_divided_are_refused(near, far, gamma):
    with pytest.raises(SettingsError):
        split_distances(PartitionChoice("z-log", 8), near, far, gamma)
