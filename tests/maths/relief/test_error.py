"""The predictors against their definitions: RI's formulas in plain loops, projected polygons, and pixels that a capture never saw."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.errors import SceneError, SettingsError
from addon.maths.relief.edges import EdgeChoice, relief_edges
from addon.maths.relief.error import EXACT, PREDICTORS, predict, predict_one, relief_set
from addon.maths.relief.frame import capture_frame
from addon.maths.relief.outline import hull_pieces
from addon.maths.relief.warp import eye_in_plane, relief_warp
from tests.margins import agree, at_most
from tests.maths.relief.rigs import (
    IMAGE,
    apply_homography,
    capture_of,
    chosen,
    corners,
    homography_of_quad,
    hull_of,
    look_at,
    ortho_at,
    project_texels,
    random_eye,
)
from tests.maths.relief.scenes import Solids, capture, machine, orbit, unseen_pixels

SMALL = chosen(max_texels=24)


def _relief_map(rng: np.random.Generator, perspective: bool, ortho_view: bool = False):
    """A small frame with random blocky depths, and an eye elsewhere."""
    hull = hull_of(rng)
    _, capture_camera = capture_of(rng, hull, perspective)
    frame = capture_frame(hull, capture_camera, IMAGE, chosen(perspective=perspective, max_texels=24))
    shape = (frame.height, frame.width)
    depth = np.kron(rng.uniform(0, 1, (8, 8)), np.ones((4, 4)))[: shape[0], : shape[1]] * frame.depth_m
    mask = np.kron(rng.uniform(0, 1, (8, 8)) < 0.8, np.ones((4, 4), bool))[: shape[0], : shape[1]]
    mask[1, 1] = True
    back = np.minimum(depth + 0.2 * frame.depth_m, frame.depth_m)
    return frame, depth, mask, back, random_eye(rng, hull, capture_camera, ortho_view)


def _written_by_hand(frame, camera, depth, first, second):
    """RI 5-5…5-7 with 5-3, 5-4 for the texels (column, row) `first` and `second`, orthographic capture."""
    e_u, e_v, e_d = eye_in_plane(frame, camera)[:3]
    h = -e_d
    total = 0.0
    for axis, epipole in ((0, e_u), (1, e_v)):
        shift = []
        for texel in (first, second):
            d = depth[texel[1], texel[0]]
            shift.append((epipole - (texel[axis] + 0.5)) * d / (h + d))
        total += (1.0 + shift[0] - shift[1]) ** 2
    return total


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_critical_is_ri_5_7_at_the_neighbours_with_the_largest_step(seed):
    frame, depth, mask, back, camera = _relief_map(np.random.default_rng(seed), False)
    best, errors = -1.0, []
    for row in range(frame.height):
        for column in range(frame.width):
            for other in ((column + 1, row), (column, row + 1)):
                if other[0] < frame.width and other[1] < frame.height and mask[row, column] and mask[other[1], other[0]]:
                    step = abs(depth[row, column] - depth[other[1], other[0]])
                    if step >= best - 1e-12:
                        errors = errors if step < best + 1e-12 else []
                        best = max(best, step)
                        errors.append(_written_by_hand(frame, camera, depth, other, (column, row)))
    found = predict_one(relief_edges(frame, depth, mask, back), camera, IMAGE)["critical"]
    at_most(min(abs(found - e) for e in errors), 1e-6 * max(1.0, found))


def test_the_closed_form_of_ri_5_5_holds_for_a_horizontal_pair():
    """E_u = |h (K + Δh (u_e − u₁)) / ((K − Δh) K)|, K = h + ∂₁, Δh = ∂₁ − ∂₂ (method §7)."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        frame, _, _, _, camera = _relief_map(rng, False)
        depth, mask = np.zeros((frame.height, frame.width)), np.zeros((frame.height, frame.width), bool)
        depth[5, 6:8], mask[5, 6:8] = rng.uniform(0, frame.depth_m, 2), True
        e_u, e_v, e_d = eye_in_plane(frame, camera)[:3]
        h, first, second = -e_d, depth[5, 7], depth[5, 6]
        big_k, step = h + first, first - second
        error_u = abs(h * (big_k + step * (e_u - 7.5)) / ((big_k - step) * big_k))
        error_v = 1.0 + (e_v - 5.5) * (first / (h + first) - second / (h + second))
        found = predict_one(relief_edges(frame, depth, mask, depth), camera, IMAGE)["critical"]
        assert found == pytest.approx(error_u**2 + error_v**2, rel=1e-9)


@pytest.mark.parametrize("ortho_view", [False, True])
def test_at_the_eye_of_the_capture_nothing_opens_and_ri_reports_two(ortho_view):
    rng = np.random.default_rng(3)
    for _ in range(5):
        solids = machine(rng)
        camera = ortho_at([2.0, -9.0, 1.0], [0, 0, 0]) if ortho_view else orbit([0, 0, 0], 9.0, 0.4)
        seen = capture(solids, camera, (96, 72))
        found = predict_one(relief_edges(seen.frame, seen.depth, seen.mask, seen.back), camera, IMAGE)
        assert found["critical"] == pytest.approx(2.0)
        assert found["regions_max"] == pytest.approx(2.0)
        for name in ("critical_px", "regions_sum_px", "regions_max_px", "regions_share", "edge_sum_px", "edge_fast_px"):
            assert found[name] == pytest.approx(0.0, abs=1e-6)


@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
@settings(max_examples=60)
def test_the_corrected_critical_point_is_its_gap_in_the_picture(seed, perspective, ortho_view):
    """From the warp and the homography of `relief.py`: pixels from one texel beyond the warped background to the warped foreground."""
    frame, depth, mask, back, camera = _relief_map(np.random.default_rng(seed), perspective, ortho_view)
    edges = relief_edges(frame, depth, mask, back)
    u, v, n_u, n_v, near, far = edges.whole_corrected
    middle, normal = np.array([u, v]), np.array([n_u, n_v])
    warp = relief_warp(frame, camera)
    foreground, background = warp.forward(middle + normal / 2, near), warp.forward(middle - normal / 2, far)
    stretch = max(0.0, (foreground - background) @ normal - 1.0)
    ends = apply_homography(homography_of_quad(frame, camera, IMAGE), background + normal * np.array([[1.0], [1.0 + stretch]]))
    agree(predict_one(edges, camera, IMAGE)["critical_px"], np.linalg.norm(ends[1] - ends[0]), rel=1e-6, abs=1e-9)


def test_shear_and_folds_are_not_counted_by_the_corrected_forms():
    """A step across u seen from above or below only shears; seen from the foreground's side it folds. RI's form reports both."""
    camera = ortho_at([0, -10, 0], [0, 0, 0])
    frame = capture_frame(corners([-1, -1, -1], [1, 1, 1]), camera, IMAGE)
    depth = np.zeros((frame.height, frame.width))
    depth[:, frame.width // 2 :] = 1.5
    edges = relief_edges(frame, depth, np.ones(depth.shape, bool), depth)
    opens, folds, shears = (predict_one(edges, ortho_at(eye, [0, 0, 0]), IMAGE) for eye in ([4, -10, 0], [-4, -10, 0], [0, -10, 4]))
    assert opens["critical_px"] > 10.0
    assert opens["edge_sum_px"] > 1000.0
    for found in (folds, shears):
        assert found["critical"] > 10.0
        assert max(found[n] for n in ("critical_px", "regions_sum_px", "edge_sum_px", "edge_fast_px")) == pytest.approx(0.0, abs=1e-9)


@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
@settings(max_examples=60)
def test_an_edges_opening_is_the_area_between_its_two_warped_images(seed, perspective, ortho_view):
    """Against the signed area of the projected strip between its near and its far end, one texel long; of steps and of walls."""
    rng = np.random.default_rng(seed)
    frame, depth, mask, back, camera = _relief_map(rng, perspective, ortho_view)
    edges = relief_edges(frame, depth, mask, back)
    chosen = rng.integers(0, len(edges.edges), 20)
    alone = [replace(edges, edges=np.append(edges.edges[i, :7], 1.0)[None]) for i in chosen]
    found = predict(relief_set(alone), camera, IMAGE)["edge_sum_px"]
    u, v, n_u, n_v, near, far, rest = edges.edges[chosen, :7].T
    middle, tangent = np.stack([u, v], axis=-1), np.stack([-n_v, n_u], axis=-1)
    apart = np.stack([n_u, n_v], axis=-1) * rest[:, None] / 2
    strip = np.stack(
        [
            project_texels(frame, camera, IMAGE, middle + side * tangent + end * apart, relief)
            for side, end, relief in ((-0.5, 1, far), (-0.5, -1, near), (0.5, -1, near), (0.5, 1, far))
        ]
    )
    x, y = strip[..., 0] - strip[0, :, 0], strip[..., 1] - strip[0, :, 1]
    area = 0.5 * (x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0)).sum(axis=0)
    agree(found, np.maximum(0.0, area), rel=0.05, abs=0.02 * np.abs(area).max())


def _sums(seed: int, perspective: bool) -> Iterator[tuple[float, float, float]]:
    """(fast, exact, covered) of a random machine from two eyes: one elsewhere, one ahead, with the epipole in the texture's middle."""
    rng = np.random.default_rng(seed)
    solids = machine(rng)
    middle = solids.hull.mean(axis=0)
    seen = capture(solids, orbit(middle, 9.0, 0.3), (96, 72), chosen(perspective=perspective))
    edges = relief_edges(seen.frame, seen.depth, seen.mask, seen.back)
    ahead = seen.camera.eye_ws + rng.uniform(-0.4, 1) * (seen.camera.eye_ws - middle)
    for camera in (random_eye(rng, solids.hull, seen.camera, False), look_at(ahead, middle)):
        found = predict_one(edges, camera, IMAGE)
        yield found["edge_fast_px"], found["edge_sum_px"], found["covered_px"]


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=40)
def test_the_directional_sums_are_the_edge_sum(seed, perspective):
    """They differ by what the edges of one strip differ: in one of 500 textures by more than 25 %, in none by 2 % of its pixels as well."""
    for fast, exact, covered in _sums(seed, perspective):
        agree(fast, exact, rel=0.25, abs=0.02 * covered)


def test_nine_in_ten_directional_sums_are_within_a_tenth_of_the_edge_sum():
    sums = np.array([row for seed in range(40) for perspective in (False, True) for row in _sums(seed, perspective)])
    fast, exact, _ = sums[np.isfinite(sums[:, 0]) & (sums[:, 1] > 100.0)].T
    assert len(exact) > 80
    assert np.quantile(np.abs(fast / exact - 1.0), 0.9) < 0.1


def test_the_directional_sums_are_exact_for_orthographic_captures_of_orthographic_views():
    rng = np.random.default_rng(6)
    solids = machine(rng)
    seen = capture(solids, ortho_at([2.0, -9.0, 1.0], [0, 0, 0]), (96, 72))
    edges = relief_edges(seen.frame, seen.depth, seen.mask, None)
    for _ in range(10):
        found = predict_one(edges, ortho_at([2.0, -9.0, 1.0] + rng.uniform(-3, 3, 3), [0, 0, 0]), IMAGE)
        assert found["edge_fast_px"] == pytest.approx(found["edge_sum_px"], rel=1e-9)


def test_the_edge_sum_of_a_box_is_the_side_it_uncovers():
    """A box seen straight on: from any other side the capture lacks the side walls, whose pixels are counted exactly by casting rays."""
    box, size = Solids(np.array([[[-0.5, -0.8, -0.6], [0.5, 0.8, 0.6]]]), np.empty((0, 4))), (320, 240)
    for perspective in (False, True):
        seen = capture(box, look_at([0, -9, 0], [0, 0, 0]), size, chosen(perspective=perspective, texels_per_pixel=2.0))
        edges = relief_edges(seen.frame, seen.depth, seen.mask, seen.back)
        for eye in ([2, -9, 0], [-3, -8, 0], [2, -8, 3], [0, -14, 4], [1.5, -5, 0.5]):
            camera = look_at(eye, [0, 0, 0])
            truth = int(unseen_pixels(box, seen, camera, size).sum())
            assert predict_one(edges, camera, size)["edge_sum_px"] == pytest.approx(truth, rel=0.1)


def _rank_correlation(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.corrcoef(*(np.argsort(np.argsort(x)) for x in (a, b)))[0, 1])


def test_the_edge_sum_ranks_the_unseen_pixels_and_bounds_them():
    size, ranks, ratios = (128, 96), [], []
    for seed in (0, 2, 4):
        rng = np.random.default_rng(seed)
        solids, table = machine(rng), []
        middle = solids.hull.mean(axis=0)
        seen = capture(solids, orbit(middle, 12.0, 0.3, zoom=2.5), size)
        edges = relief_edges(seen.frame, seen.depth, seen.mask, seen.back, last_m=seen.last)
        for _ in range(20):
            distance = rng.uniform(5, 20)
            camera = orbit(middle, distance, 0.3 + rng.uniform(-0.6, 0.6), 0.2 + rng.uniform(-0.3, 0.3), zoom=distance / 4.8)
            found = predict_one(edges, camera, size)
            unseen = unseen_pixels(solids, seen, camera, size).sum()
            table.append([unseen, found["edge_sum_px"], found["edge_fast_px"]])
        truth, *predicted = np.array(table, float).T
        ranks.append([_rank_correlation(truth, p) for p in predicted])
        ratios.extend(predicted[0] / truth)
    exact, fast = np.mean(ranks, axis=0)
    assert exact > 0.8
    assert fast > 0.8
    assert min(ratios) > 0.7
    assert np.median(ratios) < 3.0


def test_many_textures_at_once_give_what_each_gives_alone():
    rng = np.random.default_rng(10)
    members, camera = [], orbit([0, 0, 0], 11.0, 0.1)
    for perspective in (False, True, True, False):
        seen = capture(machine(rng), orbit([0, 0, 0], 9.0, rng.uniform(-0.5, 0.5)), (96, 72), chosen(perspective=perspective))
        members.append(relief_edges(seen.frame, seen.depth, seen.mask, seen.back))
    together = predict(relief_set(members), camera, IMAGE)
    assert set(together) == {*PREDICTORS, "covered_px"}
    assert set(predict(relief_set(members), camera, IMAGE, exact=False)) == {*PREDICTORS, "covered_px"} - {*EXACT}
    for index, member in enumerate(members):
        for name, value in predict_one(member, camera, IMAGE).items():
            assert together[name][index] == pytest.approx(value, rel=1e-9, abs=1e-12)


def test_an_eye_behind_the_plane_or_among_the_bounds_predicts_infinity():
    seen = capture(machine(np.random.default_rng(11)), orbit([0, 0, 0], 9.0, 0.0), (96, 72))
    edges = relief_edges(seen.frame, seen.depth, seen.mask, seen.back)
    inside = (seen.frame.world_from_plane @ [*seen.frame.centre_uv, 0.5 * seen.frame.depth_m, 1.0])[:3]
    for camera in (orbit([0, 0, 0], 9.0, np.pi), look_at(inside, [0, 0, 9.0], up=(0, 1.0, 0)), look_at([0, -9, 0], [0, -18, 0])):
        assert all(np.isinf(value) for value in predict_one(edges, camera, IMAGE).values())


def test_a_smooth_slope_has_no_depth_edges_and_a_step_on_it_has_one_per_row():
    frame = capture_frame(corners([-1, -1, -1], [1, 1, 1]), ortho_at([0, -10, 0], [0, 0, 0]), IMAGE)
    columns = np.broadcast_to(np.arange(frame.width) * 6 * frame.texel_m, (frame.height, frame.width))
    everywhere = np.ones(columns.shape, bool)
    assert len(relief_edges(frame, columns, everywhere, columns).edges) == 0
    stepped = columns + np.where(np.arange(frame.width) >= 40, 9 * frame.texel_m, 0.0)
    edges = relief_edges(frame, stepped, everywhere, stepped).edges
    steps = edges[edges[:, 6] == 0.0]
    assert len(steps) == frame.height
    np.testing.assert_array_equal(steps[:, 0], 40.0)
    np.testing.assert_array_equal(steps[:, 2], -1.0)


def _hollow(side: float, depth: float, wall: float) -> Solids:
    """Four thin walls round an empty shaft that opens sideways: a wheel's rim, roughly, seen edge-on."""
    low, high = np.array([-side, -depth, -depth]), np.array([side, depth, depth])
    boxes = []
    for axis in (1, 2):
        for towards in (-1, 1):
            box = np.stack([low, high])
            box[:, axis] = sorted((towards * depth, towards * (depth - wall)))
            boxes.append(box)
    return Solids(np.array(boxes), np.empty((0, 4)))


@pytest.mark.parametrize("perspective", [False, True])
@pytest.mark.parametrize(
    "solids",
    [
        _hollow(0.15, 0.9, 0.05),
        Solids(np.array([[[-0.1, -0.9, -0.7], [0.1, 0.9, 0.7]]]), np.empty((0, 4))),
        Solids(np.empty((0, 2, 3)), np.array([[0.0, 0.0, 0.0, 0.9]])),
    ],
    ids=["hollow", "slab", "ball"],
)
def test_a_face_that_turns_up_from_behind_the_outline_is_counted(solids, perspective):
    """What no texel of the capture holds and no texel lies before: predicted from the last surfaces, counted by casting rays."""
    size = (200, 200)
    seen = capture(solids, orbit([0, 0, 0], 9.0, 0.0, 0.0, zoom=2.5), size, chosen(perspective=perspective))
    edges = relief_edges(seen.frame, seen.depth, seen.mask, seen.back, last_m=seen.last)
    for angle, elevation in ((0.1, 0.0), (-0.25, 0.0), (0.4, 0.1)):
        camera = orbit([0, 0, 0], 9.0, angle, elevation, zoom=2.5)
        truth = int(unseen_pixels(solids, seen, camera, size).sum())
        found = predict_one(edges, camera, size)
        assert found["edge_sum_px"] == pytest.approx(truth, rel=0.2, abs=0.02 * seen.mask.sum())
        assert found["edge_fast_px"] == pytest.approx(found["edge_sum_px"], rel=0.15, abs=30)


def test_what_is_hollow_turns_up_as_far_as_its_last_surface_and_not_its_first_back():
    rim, size = _hollow(0.15, 0.9, 0.05), (200, 200)
    seen = capture(rim, orbit([0, 0, 0], 9.0, 0.0, 0.0, zoom=2.5), size)
    camera = orbit([0, 0, 0], 9.0, 0.25, 0.0, zoom=2.5)
    last, first = (
        predict_one(relief_edges(seen.frame, seen.depth, seen.mask, seen.back, last_m=m), camera, size)["edge_sum_px"]
        for m in (seen.last, None)
    )
    assert last > 5.0 * first > 0.0


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60)
def test_the_hulls_pieces_open_as_far_as_the_farthest_of_all_that_lies_behind(seed):
    """Σ max(0, y·ΔL − Δx) over the pieces = max over x of y·(L(x) − L(0)) − x, for every turn y up to 45°."""
    rng = np.random.default_rng(seed)
    deep = np.cumsum(rng.choice([0.0, 0.0, 1.0, 5.0, -3.0], (7, 30)), axis=1)
    deep[:, 1:][rng.random((7, 29)) < 0.1] = -np.inf
    line, along = np.nonzero(np.isfinite(deep))
    points = deep[line, along]
    begin, end = hull_pieces(line, along.astype(float), points)
    for y in rng.uniform(0.0, 1.0, 5):
        opens = np.zeros(7)
        np.add.at(opens, line[begin], np.maximum(0.0, y * (points[end] - points[begin]) - (along[end] - along[begin])))
        agree(opens, (y * (deep - deep[:, :1]) - np.arange(30)).max(axis=1), abs=1e-9)


def test_a_rod_uncovers_no_more_than_its_own_width_and_side():
    """A thin rod far before a wall: however far the eye moves, what comes into view is as wide as the rod and its side."""
    rod = Solids(np.array([[[-0.05, -1.0, -0.6], [0.05, -0.9, 0.6]], [[-1.0, 0.9, -1.0], [1.0, 1.0, 1.0]]]), np.empty((0, 4)))
    size = (320, 240)
    seen = capture(rod, orbit([0, 0, 0], 9.0, 0.0, 0.0, zoom=2.0), size, chosen(texels_per_pixel=2.0))
    edges = relief_edges(seen.frame, seen.depth, seen.mask, seen.back)
    for angle in (0.1, 0.25, 0.4):
        camera = orbit([0, 0, 0], 9.0, angle, 0.0, zoom=2.0)
        truth = int(unseen_pixels(rod, seen, camera, size).sum())
        assert predict_one(edges, camera, size)["edge_sum_px"] == pytest.approx(truth, rel=0.25)


def test_the_outline_uses_the_back_and_without_it_the_bounds():
    frame = capture_frame(corners([-1, -1, -1], [1, 1, 1]), ortho_at([0, -10, 0], [0, 0, 0]), IMAGE)
    depth, mask = np.zeros((frame.height, frame.width)), np.zeros((frame.height, frame.width), bool)
    mask[10:20, 10:30] = True
    camera = ortho_at([3, -10, 1], [0, 0, 0])
    backs = (depth, depth + 0.5, depth + 2.0, None)
    sums = [predict_one(relief_edges(frame, depth, mask, back), camera, IMAGE)["edge_sum_px"] for back in backs]
    assert sums[0] == 0.0
    np.testing.assert_allclose(sums[2:], 4 * sums[1], rtol=1e-9)


@pytest.mark.parametrize("broken", ["empty", "nan depth", "nan back", "shape"])
def test_a_texture_that_says_nothing_is_refused(broken):
    frame, depth, mask, back, _ = _relief_map(np.random.default_rng(12), True)
    depth, back = depth.copy(), back.copy()
    if broken == "empty":
        mask = np.zeros_like(mask)
    depth[1, 1] = np.nan if broken == "nan depth" else depth[1, 1]
    back[1, 1] = np.nan if broken == "nan back" else back[1, 1]
    with pytest.raises(SceneError, match="impostor"):
        relief_edges(frame, depth[:-1] if broken == "shape" else depth, mask, back)


def test_the_covered_pixels_are_those_of_the_mask_seen_at_its_plane():
    ball = Solids(np.empty((0, 2, 3)), np.array([[0.0, 0.0, 0.0, 0.8]]))
    seen = capture(ball, orbit([0, 0, 0], 9.0, 0.0), IMAGE, chosen(texels_per_pixel=0.5))
    edges = relief_edges(seen.frame, seen.depth, seen.mask, seen.back)
    assert predict_one(edges, seen.camera, IMAGE)["covered_px"] == pytest.approx(4 * seen.mask.sum(), rel=0.02)


def test_what_lies_outside_the_mask_is_never_read():
    frame, depth, mask, back, camera = _relief_map(np.random.default_rng(13), True)
    torn, torn_back = np.where(mask, depth, np.nan), np.where(mask, back, -np.inf)
    whole, masked = relief_edges(frame, depth, mask, back), relief_edges(frame, torn, mask, torn_back)
    assert predict_one(masked, camera, IMAGE) == predict_one(whole, camera, IMAGE)


def test_a_single_texel_is_a_valid_texture():
    frame, depth, mask, back, camera = _relief_map(np.random.default_rng(14), True)
    alone = np.zeros_like(mask)
    alone[3, 3] = True
    found = predict_one(relief_edges(frame, depth, alone, back), camera, IMAGE)
    assert found["critical"] == 0.0
    assert np.isfinite(list(found.values())).all()


@pytest.mark.parametrize("wrong", [{"regions": (0, 4)}, {"edge_texels": 0.0}, {"edge_texels": float("nan")}, {"bins": 0}])
def test_an_edge_choice_outside_its_domain_is_refused(wrong):
    with pytest.raises(SettingsError):
        EdgeChoice(**wrong)
