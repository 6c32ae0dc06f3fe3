"""A camera orbits the model once; the sun passes through its view axis, behind it and ahead of it (issue 3): nothing jumps, no NaN."""

import numpy as np
import pytest

from addon.maths.choices import WARPS
from addon.maths.fit import plan_shadows
from addon.maths.spaces import look_at, perspective
from addon.maths.view import Camera, Light
from addon.pipeline.settings import Settings
from tests import scenes
from tests.maths.fit_rigs import texel_sizes

SIZE, MAP = (64, 36), 512
NEAR, FAR = 1.0, 100.0
LARGEST_JUMP = 1.25
STEP_DEG = 1.0


def camera_at(angle_deg):
    """The orbit: level round the scene's middle, so that the sun, level too, is on the view axis at 0° (behind) and 180° (ahead)."""
    a = np.radians(angle_deg)
    eye = 30.0 * np.array([np.cos(a), np.sin(a), 0.0]) + [0.0, 0.0, 1.0]
    return Camera(look_at(eye, (0.0, 0.0, 1.0)), perspective(np.radians(25.0), SIZE[0] / SIZE[1], NEAR, FAR), NEAR, FAR)


SUN = Light("sun", -camera_at(0.0).direction_ws)
NEAR_THE_AXIS = (*np.arange(-7.0, 7.0), *np.arange(173.0, 187.0))
EDGE_ON = np.arange(36.0, 58.0)  # the near side of the frustum is edge-on to the light at 40°
ALL_ROUND = np.arange(0.0, 360.0, 30.0)


@pytest.fixture(scope="module")
def scene():
    """A floor with three boxes: about as deep as the view, f/n = 100."""
    boxes = (((-1, -1, 0), (1, 1, 2)), ((4, -9, 0), (6, -7, 5)), ((-12, 3, 0), (-11, 14, 3)))
    return scenes.scene_of(scenes.floor(20.0), *(scenes.box(*corners) for corners in boxes))


def plan_at(scene, angle_deg, warp, fit, sun=SUN, **partition):
    """The default partitioning, or another, at one place of the orbit."""
    s = Settings().replaced(warp={"kind": warp}, fit={"kind": fit, "size": MAP}, partition=partition)
    return plan_shadows(camera_at(angle_deg), sun, s.warp, s.partition, s.fit, receivers_ws=None, scene_bounds_ws=scene.bounds_ws(),
                        caster_bounds_ws=scene.instance_bounds_ws(), image_size=SIZE)


def sizes_at(scene, angle_deg, warp, fit, sun=SUN, **partition):
    """(K, 3) texel sizes of the maps that are not empty."""
    sizes = texel_sizes(plan_at(scene, angle_deg, warp, fit, sun, **partition), sun, MAP)
    return sizes[~np.isnan(sizes[:, 0])]


def jump(before, after):
    """The largest ratio of a partition's texel sizes."""
    assert np.isfinite(before).all() and np.isfinite(after).all()
    return float(np.exp(np.abs(np.log(after / before)).max()))


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
    e = np.radians(elevation_deg)
    sun = Light("sun", np.cos(e) * SUN.direction_ws + [0.0, 0.0, np.sin(e)])
    last = sizes_at(scene, 0.0, "lispsm-general", fit, sun)
    for angle in np.arange(STEP_DEG, 32.0, STEP_DEG):
        sizes = sizes_at(scene, angle, "lispsm-general", fit, sun)
        assert jump(last, sizes) < LARGEST_JUMP, f"at {angle}°"
        last = sizes


@pytest.mark.parametrize("warp", WARPS)
def test_one_degree_never_changes_a_texel_by_a_quarter_in_any_warp(scene, warp):
    for angle in (*NEAR_THE_AXIS, *ALL_ROUND, *EDGE_ON[::2]):
        step = jump(sizes_at(scene, angle, warp, "frustum"), sizes_at(scene, angle + STEP_DEG, warp, "frustum"))
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
        plan, found = plan_at(scene, angle, "lispsm-general", "scene", **partition), {}
        for i, (p, size) in enumerate(zip(plan.projections, texel_sizes(plan, SUN, MAP), strict=True)):
            if not np.isnan(size[0]):
                found.setdefault((p.face, i % partition.get("count", 1)), []).append(size)
        return found

    last = sizes(0.0)
    for angle in np.arange(STEP_DEG, 181.0, STEP_DEG):
        now = sizes(angle)
        for key in now.keys() & last.keys():
            assert max(min(jump(before, after) for before in last[key]) for after in now[key]) < LARGEST_JUMP, f"{key} at {angle}°"
        last = now


@pytest.mark.parametrize("fit", ["frustum", "scene", "samples"])
@pytest.mark.parametrize("warp", WARPS)
def test_no_picture_of_the_orbit_holds_a_nan(renderer, scene, warp, fit):
    settings = Settings().replaced(warp={"kind": warp}, fit={"kind": fit, "size": 128}, shading={"samples": 1})
    for angle in (0.0, 1e-6, 2.0, 90.0, 180.0, 181.0):
        frame = renderer.render(scene, camera_at(angle), SUN, settings, SIZE, ("combined", "shadow", "aliasing", "partition"))
        assert np.isfinite(frame.passes["combined"]).all()
        assert np.isfinite(frame.passes["shadow"]).all()
        assert (frame.passes["aliasing"][frame.passes["partition"] >= 0] > 0.0).all()
        assert all(np.isfinite(p.clip_from_world).all() for p in frame.plan.projections)
        assert all(v is None or np.isfinite(v) for k, v in frame.measured.items() if k != "perspective")
