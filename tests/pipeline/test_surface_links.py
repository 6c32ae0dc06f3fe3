"""What lies across each edge, against the definition, and a walk over slivers that win no cell."""

from collections import defaultdict

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from addon.pipeline.surface_links import BORDER, SEVERAL, across_edges
from tests import scenes
from tests.pipeline.test_shadow_tests import misclassified, settings


def by_definition(positions, triangles):
    """Edge by edge, by positions."""
    users = defaultdict(list)
    for t, triangle in enumerate(triangles):
        for k in range(3):
            users[frozenset(tuple(positions[triangle[i]] + 0.0) for i in (k, (k + 1) % 3))].append((t, k))
    out = np.full((len(triangles), 3), SEVERAL, np.uint32)
    for edge, corners in users.items():
        if len(edge) == 2 and len(corners) <= 2:
            for t, k in corners:
                others = [other for other, _ in corners if other != t]
                out[t, k] = others[0] if others else BORDER
    return out


@given(st.lists(st.tuples(*[st.integers(0, 8)] * 3).filter(lambda t: len(set(t)) == 3), min_size=1, max_size=12), st.randoms())
def test_links_are_the_other_triangle_of_each_edge(triples, random):
    """Vertices 0…5 are points, 6…8 doubles of 0…2, as where normals split; −0 is 0."""
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
