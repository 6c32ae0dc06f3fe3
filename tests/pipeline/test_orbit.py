"""A camera orbits the model once; the sun passes through its view axis, behind it and ahead of it: nothing jumps, no NaN."""

import numpy as np
import pytest

from addon.maths.choices import WARPS
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.run import run
from tests.maths.shadow.fit_rigs import texel_sizes
from tests.orbit import MAP, SIZE, STEP_DEG, SUN, camera_at, jump, largest_jump, orbited_scene, plan_at, sizes_by_face, sun_at

LARGEST_JUMP = 1.25
NEAR_THE_AXIS = (*np.arange(-7.0, 7.0), *np.arange(173.0, 187.0))
EDGE_ON = np.arange(36.0, 58.0)  # the near side of the frustum is edge-on to the light at 40°
ALL_ROUND = np.arange(0.0, 360.0, 30.0)


@pytest.fixture(scope="module")
def scene():
    return orbited_scene()


def sizes_at(scene, angle_deg, warp, fit, sun=SUN, **partition):
    """(K, 3) texel sizes of the maps that are not empty."""
    sizes = texel_sizes(plan_at(scene, angle_deg, warp, fit, sun, **partition), sun, MAP)
    return sizes[~np.isnan(sizes[:, 0])]


def test_one_degree_never_changes_a_texel_by_a_quarter_in_the_default_warp_and_partition(scene):
    last = sizes_at(scene, -STEP_DEG, "lispsm-general", "scene")
    for angle in np.arange(0.0, 360.0, STEP_DEG):
        sizes = sizes_at(scene, angle, "lispsm-general", "scene")
        assert jump(last, sizes) < LARGEST_JUMP, f"at {angle}°"
        last = sizes


@pytest.mark.parametrize("fit", ["frustum", "scene"])
@pytest.mark.parametrize("elevation_deg", [-3.0, 1.5, 8.0, 20.0])
def test_nor_with_a_sun_that_passes_beside_the_axis(scene, elevation_deg, fit):
    """There the line between halves turns; past 30° it is the map's own again."""
    sun = sun_at(elevation_deg)
    last = sizes_at(scene, 0.0, "lispsm-general", fit, sun)
    for angle in np.arange(STEP_DEG, 32.0, STEP_DEG):
        sizes = sizes_at(scene, angle, "lispsm-general", fit, sun)
        assert jump(last, sizes) < LARGEST_JUMP, f"at {angle}°"
        last = sizes


@pytest.mark.parametrize("fit", ["frustum", "scene"])
@pytest.mark.parametrize("warp", WARPS)
def test_one_degree_never_changes_a_texel_by_a_quarter_in_any_warp(scene, warp, fit):
    for angle in (*NEAR_THE_AXIS, *ALL_ROUND, *EDGE_ON[::2], *(180.0 - EDGE_ON[::2])):
        step = jump(sizes_at(scene, angle, warp, fit), sizes_at(scene, angle + STEP_DEG, warp, fit))
        assert step < LARGEST_JUMP, f"at {angle}°"


@pytest.mark.parametrize("fit", ["frustum", "scene"])
@pytest.mark.parametrize("warp", WARPS)
def test_one_degree_never_changes_a_texel_by_a_quarter_in_one_map_either(scene, warp, fit):
    for angle in (*np.arange(0.0, 8.0), *EDGE_ON):
        sizes = [sizes_at(scene, a, warp, fit, kind="none") for a in (angle, angle + STEP_DEG)]
        assert jump(*sizes) < LARGEST_JUMP, f"at {angle}°"


@pytest.mark.parametrize("partition", [{"kind": "faces"}, {"kind": "faces-z", "count": 2}], ids=lambda p: p["kind"])
def test_nor_in_the_maps_of_a_face(scene, partition):
    """A wide face has two: then every map has one of that face and slice before it with nearly its texels; one without a sector none."""

    def sizes(angle):
        return sizes_by_face(plan_at(scene, angle, "lispsm-general", "scene", **partition), SUN, partition.get("count", 1))

    last = sizes(0.0)
    for angle in np.arange(STEP_DEG, 181.0, STEP_DEG):
        now = sizes(angle)
        assert largest_jump(last, now) < LARGEST_JUMP, f"at {angle}°"
        last = now


@pytest.mark.parametrize("fit", ["frustum", "scene", "samples"])
@pytest.mark.parametrize("warp", WARPS)
def test_no_picture_of_the_orbit_holds_a_nan(renderer, scene, warp, fit):
    settings = Settings().replaced(warp={"kind": warp}, fit={"kind": fit, "size": 128}, shading={"samples": 1})
    for angle in (0.0, 1e-6, 2.0, 90.0, 180.0, 181.0):
        frame = run(Job(scene, camera_at(angle), SUN, settings, SIZE, ("combined", "shadow", "aliasing", "partition")), on=renderer).frame
        assert np.isfinite(frame.passes["combined"]).all()
        assert np.isfinite(frame.passes["shadow"]).all()
        assert (frame.passes["aliasing"][frame.passes["partition"] >= 0] > 0.0).all()
        assert all(np.isfinite(p.clip_from_world).all() for p in frame.plan.projections)
        assert all(v is None or np.isfinite(v) for k, v in frame.measured.items() if k not in ("perspective", "precision"))
