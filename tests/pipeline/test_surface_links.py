"""What lies across each edge, against the definition, and a walk over slivers that win no cell."""

from collections import defaultdict

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from addon.pipeline.geometry.surface_links import BORDER, SEVERAL, across_edges
from tests import scenes
from tests.pipeline.test_shadow_tests import misclassified, settings


def by_definition(positions, triangles):
    """Edge by edge, by positions."""
    places = [[tuple(positions[i] + 0.0) for i in triangle] for triangle in triangles]
    first = {}
    for t, three in enumerate(places):
        first.setdefault(frozenset(three), t)
    users = defaultdict(set)
    for three in places:
        for k in range(3):
            users[frozenset((three[k], three[(k + 1) % 3]))].add(first[frozenset(three)])
    out = np.full((len(triangles), 3), SEVERAL, np.uint32)
    for t, three in enumerate(places):
        for k in range(3):
            edge = frozenset((three[k], three[(k + 1) % 3]))
            if len(edge) == 2 and len(users[edge]) <= 2:
                others = users[edge] - {first[frozenset(three)]}
                out[t, k] = others.pop() if others else BORDER
    return out


@given(st.lists(st.tuples(*[st.integers(0, 8)] * 3).filter(lambda t: len(set(t)) == 3), min_size=1, max_size=12), st.randoms())
def test_links_are_the_other_triangle_of_each_edge(triples, random):
    """Vertices 0…5 are points, 6…8 doubles of 0…2, as where normals split; −0 is 0. Triangles come twice, too, wound either way."""
    positions = np.array([[-0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [2, 0, 1], [0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    triples = [t for t in triples if len({tuple(positions[i] + 0.0) for i in t}) == 3]
    triangles = np.array([random.sample(t, 3) for t in triples], dtype=np.int64).reshape(-1, 3)
    expected = by_definition(positions, triangles)
    assert np.array_equal(across_edges(positions, triangles), expected)


def test_an_edge_without_length_leads_nowhere():
    found = across_edges(np.array([[0, 0, 0], [1, 0, 0], [0, 0, 0]], np.float32), np.array([[0, 1, 2]]))
    assert found[0, 2] == SEVERAL


def test_a_shadow_of_slivers_thinner_than_a_cell_is_as_sharp_as_one_of_wide_faces(renderer):
    """A mast of 96 faces a tenth of a texel wide: few win a cell, the walk finds the others. (Without it: no better than depth.)"""
    mast = scenes.rod((0.0, 0.3, -0.1), (0.0, 0.3, 9.0), 0.25, 96)
    scene = scenes.scene_of(scenes.floor(8.0), mast)
    camera = scenes.look_at((1.5, -7.0, 5.0), (1.5, 1.0, 0.0), near=0.3, far=60.0)
    light = scenes.sun(35.0, 200.0)
    for warp in ("uniform", "logpsm"):
        depth, _ = misclassified(renderer, scene, settings(warp, size=96), light, camera)
        exact, acne = misclassified(renderer, scene, settings(warp, size=96, kind="triangle"), light, camera)
        assert depth > 0.002
        assert exact <= 0.1 * depth
        assert acne <= 2e-4


def test_both_sides_of_a_sheet_count_once():
    """A strip of four slivers written twice, the copies wound and begun otherwise: the walk goes along it as along one."""
    positions = np.array([[x, y, 0] for x in range(3) for y in range(2)], np.float32)
    strip = np.array([[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]])
    found = across_edges(positions, np.concatenate([strip, np.roll(strip[:, ::-1], 1, axis=1)]))
    assert np.array_equal(found[:4], across_edges(positions, strip))
    assert np.array_equal(np.sort(found[4:], axis=1), np.sort(found[:4], axis=1))
    assert (found != SEVERAL).all()


def test_a_larger_map_is_no_worse_on_long_slivers(renderer):
    """On faces thousands of texels long and a few wide the rasteriser's float32 depth is out by a texel's tilt: 2 % acne without `blur`.

    Mean of three eyes, each with about 970 pixels that count: one of them more or less says nothing.
    """
    tubes = [scenes.rod((x, -2.2, 0.6), (x + 3.0, 2.2, 1.2), 0.03, 48) for x in np.arange(-1.5, 1.0, 0.5)]
    scene, light = scenes.scene_of(scenes.joined(*tubes)), scenes.sun(30.0, -60.0)
    cameras = [scenes.look_at((x, -3.0, 2.6), (0.3, 0.0, 0.6), near=0.3, far=60.0) for x in (0.29, 0.3, 0.31)]
    small, large = (
        np.mean([misclassified(renderer, scene, settings("uniform", size=size), light, camera)[0] for camera in cameras])
        for size in (2048, 8192)
    )
    assert large <= small + 0.002
