"""What is gathered from a texture at capture against plain loops over its texels: critical pairs of regions, directional sums."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.relief.edges import SHIFTS, EdgeChoice, directional_sums, relief_edges
from addon.maths.relief.frame import capture_frame
from addon.maths.relief.warp import relief_from_depth, shift_unit
from tests.margins import agree
from tests.maths.relief.rigs import IMAGE, capture_of, chosen, hull_of


def _texture(rng: np.random.Generator):
    """A small frame with random blocky depths that repeat, a mask with holes, and backs."""
    hull = hull_of(rng)
    perspective = bool(rng.integers(2))
    _, camera = capture_of(rng, hull, perspective)
    frame = capture_frame(hull, camera, IMAGE, chosen(perspective=perspective, max_texels=24))
    shape = (frame.height, frame.width)
    depth = rng.choice([0.0, 0.3, 0.35, 0.9], shape) * frame.depth_m
    mask = rng.uniform(0, 1, shape) < 0.8
    mask[1, 1] = True
    return frame, depth, mask, np.minimum(depth + 0.05 * frame.depth_m, frame.depth_m)


@given(st.integers(0, 2**32 - 1), st.sampled_from([(1, 1), (4, 4), (3, 7), (30, 2)]), st.booleans())
@settings(max_examples=30, deadline=None)
def test_each_regions_critical_pair_has_the_largest_step_whose_middle_lies_in_it(seed, regions, with_outline):
    """`written` of pairs on the object; `corrected` also of those across its outline that are a depth edge."""
    frame, depth, mask, back = _texture(np.random.default_rng(seed))
    choice = EdgeChoice(regions=regions)
    largest: dict[int, float] = {}
    for row in range(frame.height):
        for column in range(frame.width):
            for du, dv in ((1, 0), (0, 1)):
                u, v = column + du, row + dv
                if u >= frame.width or v >= frame.height or not (mask[row, column] or mask[v, u]):
                    continue
                if mask[row, column] and mask[v, u]:
                    step = abs(depth[row, column] - depth[v, u])
                else:
                    here = (row, column) if mask[row, column] else (v, u)
                    step = back[here] - depth[here]
                    if not with_outline or step <= choice.edge_texels * frame.texel_m:
                        continue
                place = (column + 0.5 + du / 2) / frame.width, (row + 0.5 + dv / 2) / frame.height
                cell = [min(int(p * n), n - 1) for p, n in zip(place, regions, strict=True)]
                region = cell[1] * regions[0] + cell[0]
                largest[region] = max(largest.get(region, 0.0), step)
    edges = relief_edges(frame, depth, mask, back, choice)
    found = edges.corrected if with_outline else edges.written
    whole = edges.whole_corrected if with_outline else edges.whole_written
    reliefs = np.diff(found[:, 4:6], axis=1)[:, 0]
    for region, pair in enumerate(found):
        if region not in largest:
            np.testing.assert_array_equal(pair, np.zeros(6))
            continue
        near = pair[4] * frame.source[2] / (1.0 + pair[4] * frame.source[3])
        agree(abs(relief_from_depth(frame.source, near + largest[region]) - pair[4]), abs(reliefs[region]), rel=1e-9, abs=1e-12)
        cell = np.minimum((pair[:2] / [frame.width, frame.height] * regions).astype(int), np.array(regions) - 1)
        assert cell @ [1, regions[0]] == region
    assert any(np.array_equal(whole, pair) for pair in found)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_the_directional_sums_are_what_opens_at_each_shift_strip_by_strip(seed):
    rng = np.random.default_rng(seed)
    frame, depth, mask, back = _texture(rng)
    edges = relief_edges(frame, depth, mask, back).edges
    edges[:, 7] *= rng.uniform(0.5, 3.0, len(edges))
    bins, unit = 5, shift_unit(frame)
    sums, totals = directional_sums(frame, edges, bins)
    expected, mass = np.zeros_like(sums), np.zeros((4, bins))
    for u, v, n_u, n_v, near, far, rest, weight in edges:
        axis, opens = (0, n_u * (near - far)) if n_u else (1, n_v * (near - far))
        if opens == 0.0:
            continue
        strip = min(int((u, v)[axis] / (frame.width, frame.height)[axis] * bins), bins - 1)
        expected[2 * axis + (opens < 0.0), strip] += weight * np.maximum(0.0, abs(opens) * SHIFTS / unit - rest)
        mass[2 * axis + (opens < 0.0), strip] += weight * abs(opens)
    agree(sums, expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
    agree(totals[..., 0], mass, rel=1e-9, abs=1e-9 * np.abs(mass).max())


@given(st.integers(0, 2**32 - 1), st.integers(1, 12))
@settings(max_examples=20)
def test_rounding_moves_no_edge_over_the_border_of_its_strip(seed, bins):
    """Places that lie on borders too: a texture has them wherever a strip is a whole number of half texels wide."""
    rng = np.random.default_rng(seed)
    frame, depth, mask, back = _texture(rng)
    edges = relief_edges(frame, depth, mask, back).edges
    rounded = edges.copy()
    rounded[:, :2] += rng.uniform(-1e-10, 1e-10, (len(edges), 2))
    for before, after in zip(directional_sums(frame, edges, bins), directional_sums(frame, rounded, bins), strict=True):
        agree(after, before, rel=1e-9, abs=1e-9 * np.abs(before).max())
