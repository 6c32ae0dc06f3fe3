"""The overlay's lines lie where the maps and the splits are: every end projects to the edge it stands for."""

import numpy as np
import pytest

from addon.maths import spaces
from addon.maths.shadow import lookup
from addon.studies.map_outlines import frustum_sides, map_color, map_volumes, section, split_sections
from tests.maths.shadow.fit_rigs import camera_at, plan_of, receivers_on, sun_at

BOUNDS = np.array([[-20.0, -20.0, 0.0], [20.0, 40.0, 6.0]])
CAMERA = camera_at((3.0, -30.0, 12.0), (0.0, 5.0, 0.0))


def plan(warp="lispsm-general", partition="z-adaptive", gamma=60.0, **more):
    points = receivers_on(CAMERA, BOUNDS)
    return plan_of(CAMERA, sun_at(CAMERA, gamma), points, BOUNDS, warp, partition, **more)


@pytest.mark.parametrize("depth", [0.5, 7.0, 199.0])
@pytest.mark.parametrize("orthographic", [None, 10.0])
def test_a_section_is_the_pictures_border_at_its_depth(depth, orthographic):
    camera = camera_at((3.0, -30.0, 12.0), (0.0, 5.0, 0.0), orthographic=orthographic)
    ring = section(camera, depth)
    ndc = spaces.divide(spaces.transform(camera.clip_from_world, ring))
    assert np.allclose(np.abs(ndc[..., :2]), 1.0, atol=1e-5)
    assert np.allclose(-spaces.transform(camera.view_from_world, ring)[..., 2], depth, rtol=1e-5, atol=1e-5)
    assert np.allclose(ring[:, 1], np.roll(ring[:, 0], -1, axis=0)), "the four segments close a ring"


def test_sides_run_along_the_frustums_edges():
    sides = frustum_sides(CAMERA, 2.0, 50.0)
    ndc = spaces.divide(spaces.transform(CAMERA.clip_from_world, sides))
    assert np.allclose(np.abs(ndc[..., :2]), 1.0)
    assert np.allclose(ndc[:, 0, :2], ndc[:, 1, :2])


@pytest.mark.parametrize("warp", ["uniform", "psm", "log", "logpsm"])
def test_a_volumes_corners_are_the_maps_own(warp):
    made = plan(warp)
    volumes = map_volumes(made)
    assert volumes
    for index, segments in volumes:
        corners = np.stack(lookup.project(made.projections[index], segments)[:3], axis=-1)
        assert np.allclose(np.abs(corners), 1.0, atol=1e-6)
        assert (np.count_nonzero(np.abs(corners[:, 0] - corners[:, 1]) > 1.0, axis=-1) == 1).all(), "each edge follows one axis"
        assert len(np.unique(np.round(segments.reshape(-1, 3), 6), axis=0)) == 8


def test_each_used_map_has_its_own_split_and_empty_ones_none():
    made = plan(cut="view")
    used = [i for i, p in enumerate(made.projections) if not p.is_empty]
    found = split_sections(CAMERA, made)
    assert [i for i, _ in found] == used
    for index, segments in found:
        depth = -spaces.transform(CAMERA.view_from_world, segments)[..., 2]
        assert depth.max() == pytest.approx(made.projections[index].far, rel=1e-4)
        assert depth.min() == pytest.approx(made.projections[index].near, rel=1e-4)


def test_parts_along_the_light_share_their_borders_and_leave_none_of_the_view_out():
    made = plan(cut="light")
    for index, segments in split_sections(CAMERA, made):
        ends = segments.reshape(-1, 3)
        for plane in made.projections[index].region_planes_ws:
            heights = ends @ plane[:3] + plane[3]
            assert heights.min() == pytest.approx(0.0, abs=1e-6) and heights.max() > 0.1
    corners = np.concatenate([segments.reshape(-1, 3) for _, segments in split_sections(CAMERA, made)])
    ndc = spaces.divide(spaces.transform(CAMERA.clip_from_world, corners))
    assert np.allclose([ndc[:, :2].min(axis=0), ndc[:, :2].max(axis=0)], [[-1, -1], [1, 1]])


def test_maps_have_colours_of_their_own():
    colors = [map_color(i) for i in range(8)]
    distances = [np.abs(np.subtract(a, b)).max() for i, a in enumerate(colors) for b in colors[:i]]
    assert min(distances) > 0.08
    assert all(0.0 <= c <= 1.0 for color in colors for c in color)
