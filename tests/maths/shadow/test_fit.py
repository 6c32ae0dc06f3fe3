"""`plan_shadows` by its promises: receivers inside, w > 0, casters kept, depth in order, counts constant, nothing singular."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths import spaces
from addon.maths.choices import WARPS, FitChoice, PartitionChoice, WarpChoice
from addon.maths.frusta import frustum_corners
from addon.maths.shadow import lookup
from addon.maths.shadow.crop import HIGHEST
from addon.maths.shadow.fit import plan_shadows
from addon.maths.view import Light
from addon.maths.warping.formulas import lispsm_general_parameter
from tests.margins import agree, at_most
from tests.maths.shadow.fit_rigs import IMAGE, camera_at, casters_round, plan_of, receivers_on, sun_at, texel_sizes, unit

BOUNDS = np.array([[-20.0, -20.0, 0.0], [20.0, 40.0, 8.0]])
FITS = ("frustum", "scene", "samples")
SPLIT = ("none", "z-log", "z-linear", "z-pssm", "z-pseudo-near", "z-adaptive")
BENT = tuple(WarpChoice("logpsm", log_bend=bend) for bend in (-0.95, 2.0, 300.0))


def light_depth(light: Light, points_ws: np.ndarray) -> np.ndarray:
    """Light depth (…,) in metres, growing away from the light: −y_ls of the sun (zero at the world's origin), the distance otherwise."""
    if light.kind == "sun":
        return -(np.asarray(points_ws, np.float64) @ light.direction_ws)
    return np.linalg.norm(np.asarray(points_ws, np.float64) - light.position_ws, axis=-1)


def _random_view(seed, kind="sun", offset=0.0):
    """A camera outside, inside or above the scene and a light from anywhere, with receivers; all moved by `offset` metres."""
    rng = np.random.default_rng(seed)
    bounds = BOUNDS + offset
    inside = bounds[0] + rng.random(3) * (bounds[1] - bounds[0])
    eye = inside if seed % 3 == 0 else inside + rng.uniform(10, 40) * unit(rng.normal(size=3) + [0, 0, 1.0])
    target = bounds[0] + rng.random(3) * (bounds[1] - bounds[0])
    camera = camera_at(eye, target, near=10.0 ** rng.uniform(-2, 0), far=10.0 ** rng.uniform(2, 4), phi_deg=rng.uniform(5, 50))
    if kind == "sun":
        light = Light("sun", unit(rng.normal(size=3)))
    else:
        position = bounds.mean(axis=0) + rng.uniform(-30, 30, 3)
        light = Light(kind, unit(position - bounds.mean(axis=0)) if kind == "spot" else None, position, cone_rad=rng.uniform(0.2, 1.2))
    return camera, light, receivers_on(camera, bounds, seed=seed), bounds


def _served(plan, camera, light, points):
    """(index, projection, its points) of each map that serves some; a finite light's own pyramid counts."""
    index = lookup.partition_index(plan, camera, points)
    if light.kind == "spot":
        cosine = lookup.towards_light(light, points) @ light.direction_ws
        index = np.where(cosine > np.cos(light.cone_rad), index, -2)
    return index, [(i, p, points[index == i]) for i, p in enumerate(plan.projections) if (index == i).any()]


@pytest.mark.parametrize("kind", FITS)
@pytest.mark.parametrize("light_kind", ["sun", "spot", "point"])
@given(seed=st.integers(0, 100_000), warp=st.sampled_from((*WARPS, *BENT)), partition=st.sampled_from(SPLIT))
@settings(max_examples=12)
def test_every_receiver_falls_inside_its_map_with_positive_w_and_depth_in_range(kind, light_kind, seed, warp, partition):
    camera, light, points, bounds = _random_view(seed, light_kind)
    plan = plan_of(camera, light, points, bounds, warp, partition, kind)
    index, served = _served(plan, camera, light, points)
    assert (index != -1).all()
    for _, p, own in served:
        assert not p.is_empty
        s, t, depth, w = lookup.project(p, own)
        assert (w > 0.0).all()
        at_most(max(np.abs(s).max(), np.abs(t).max(), np.abs(depth).max()) - 1.0, 1e-5)


@given(seed=st.integers(0, 100_000), warp=st.sampled_from(WARPS))
@settings(max_examples=20)
def test_samples_far_from_the_origin_fit_as_well_as_near_it(seed, warp):
    moved = np.array([3000.0, -2000.0, 100.0])
    camera, light, points, bounds = _random_view(seed)
    far_camera, far_light, far_points, far_bounds = _random_view(seed, offset=moved)
    near_plan = plan_of(camera, light, points, bounds, warp, "z-log")
    far_plan = plan_of(far_camera, far_light, points + moved, far_bounds, warp, "z-log", casters=casters_round(points) + moved)
    for p, q in zip(near_plan.projections, far_plan.projections, strict=True):
        back = q.clip_from_world @ spaces.translation(moved)
        agree(p.clip_from_world, back, rel=1e-4, abs=1e-4 * np.abs(back).max())


@given(seed=st.integers(0, 100_000), warp=st.sampled_from((*WARPS, *BENT)), light_kind=st.sampled_from(["sun", "spot"]))
@settings(max_examples=30)
def test_unproject_inverts_project(seed, warp, light_kind):
    camera, light, points, bounds = _random_view(seed, light_kind)
    plan = plan_of(camera, light, points, bounds, warp, "z-log")
    for _, p, own in _served(plan, camera, light, points)[1]:
        s, t, depth, _ = lookup.project(p, own)
        agree(lookup.unproject(p, s, t, depth), own, abs=1e-5)


@given(seed=st.integers(0, 100_000), warp=st.sampled_from(WARPS), light_kind=st.sampled_from(["sun", "spot", "point"]))
@settings(max_examples=30)
def test_points_of_one_ray_share_a_texel_and_depth_grows_away_from_the_light(seed, warp, light_kind):
    camera, light, points, bounds = _random_view(seed, light_kind)
    plan = plan_of(camera, light, points, bounds, warp, "z-log")
    for _, p, own in _served(plan, camera, light, points)[1]:
        own = own[:20]
        step = -lookup.towards_light(light, own) * 0.01
        here, there = lookup.project(p, own), lookup.project(p, own + step)
        agree(here[0], there[0], abs=1e-6)
        agree(here[1], there[1], abs=1e-6)
        assert (there[2] > here[2]).all()
        assert (light_depth(light, own + step) > light_depth(light, own)).all()


@given(seed=st.integers(0, 100_000), warp=st.sampled_from(WARPS), kind=st.sampled_from(FITS))
@settings(max_examples=30)
def test_no_caster_over_the_map_is_nearer_than_its_near_plane_unless_it_is_flattened(seed, warp, kind):
    """Those more than `HIGHEST` footprints above the highest receiver are: the depth clamp lays them onto the near plane."""
    camera, light, points, bounds = _random_view(seed)
    tops = points + lookup.towards_light(light, points) * np.random.default_rng(seed).uniform(0, 60, (len(points), 1))
    casters = np.stack([tops - 0.2, tops + 0.2], axis=1)
    plan = plan_of(camera, light, points, bounds, warp, "z-log", kind, casters=casters)
    axes = plan.light_from_world[:3, :3]
    for _, p, own in _served(plan, camera, light, points)[1]:
        before_the_apex = tops[spaces.transform(p.clip_from_world, tops)[:, 3] > 0.0]
        s, t, depth, _ = lookup.project(p, before_the_apex)
        over = (np.abs(s) <= 1.0) & (np.abs(t) <= 1.0)
        corners = lookup.unproject(p, np.array([-1.0, -1.0, 1.0, 1.0]), np.array([-1.0, 1.0, -1.0, 1.0]), np.zeros(4)) @ axes.T
        height = before_the_apex @ axes[1] - (own @ axes[1]).max()
        kept = height <= 0.999 * HIGHEST * np.ptp(corners[:, [0, 2]], axis=0).max()
        assert (depth[over & kept] >= -1.0 - 1e-9).all()


@pytest.mark.parametrize("warp", WARPS)
def test_the_light_depth_range_is_that_of_the_maps_central_ray(warp):
    for kind in ("sun", "spot"):
        camera, light, points, bounds = _random_view(7, kind)
        p = plan_of(camera, light, points, bounds, warp).projections[0]
        ends = lookup.unproject(p, np.zeros(2), np.zeros(2), np.array([-1.0, 1.0]))
        wanted = light_depth(light, ends)
        assert np.allclose(p.light_depth_range[0], wanted[0], rtol=1e-6)
        assert np.isinf(p.light_depth_range[1]) or np.allclose(p.light_depth_range[1], wanted[1], rtol=1e-6)


@pytest.mark.parametrize("warp", WARPS)
@pytest.mark.parametrize("margin", [0.0, 1.0, 8.0])
def test_samples_are_cropped_to_the_margin_and_half_a_pixel(warp, margin):
    camera = camera_at((0, -30, 15), (0, 5, 0))
    light, points = sun_at(camera, 70.0), receivers_on(camera, BOUNDS, 20_000)
    p = plan_of(camera, light, points, BOUNDS, warp, margin=margin).projections[0]
    inner = 1.0 - 2.0 * margin / 512
    for ndc in lookup.project(p, points)[:2]:
        assert ndc.min() >= -inner - 1e-4 and ndc.max() <= inner + 1e-4
        assert ndc.min() < -0.93 * inner and ndc.max() > 0.93 * inner  # a pixel is up to 1/90 of the picture's side here


def test_the_warp_is_the_texts_for_the_tight_range_from_gamma_lim_up():
    camera = camera_at((0, -30, 15), (0, 5, 0))
    light, points = sun_at(camera, 70.0), receivers_on(camera, BOUNDS, 20_000)
    plan = plan_of(camera, light, points, BOUNDS, "lispsm-general")
    p, depth = plan.projections[0], -spaces.transform(camera.view_from_world, points)[:, 2]
    assert np.allclose(p.fitted_range, (depth.min(), depth.max()), rtol=1e-6)
    wanted = lispsm_general_parameter(*p.fitted_range, camera.half_fov_rad, plan.gamma_rad)
    assert np.isclose(p.warp_parameter, wanted, rtol=1e-9)


@pytest.mark.parametrize("kind", FITS)
@pytest.mark.parametrize("light_kind", ["sun", "spot", "point"])
def test_counts_do_not_depend_on_the_view_and_empty_maps_are_harmless(kind, light_kind):
    counts = set()
    for seed in range(6):
        camera, light, points, bounds = _random_view(seed, light_kind)
        for receivers in (points, points[:1], points[:0]):
            plan = plan_of(camera, light, receivers, bounds, "lispsm-general", "z-adaptive", kind, casters=np.zeros((0, 2, 3)))
            counts.add(len(plan.projections))
            assert all(np.isfinite(p.clip_from_world).all() for p in plan.projections)
            for p in plan.projections:
                assert np.linalg.matrix_rank(p.clip_from_world / np.abs(p.clip_from_world).max(axis=1, keepdims=True)) == 4
            if kind == "samples" and not len(receivers):
                assert all(p.is_empty for p in plan.projections)
    assert len(counts) == 1


def test_a_scene_behind_the_camera_gives_empty_maps():
    camera = camera_at((0, 60, 3), (0, 100, 3), far=50.0)
    plan = plan_of(camera, sun_at(camera, 60.0), np.zeros((0, 3)), BOUNDS, partition="z-log", kind="scene")
    assert len(plan.projections) == 4 and all(p.is_empty for p in plan.projections)


def test_depth_bounds_join_without_gap_and_a_point_lights_faces_do_not_overlap():
    camera, light, points, bounds = _random_view(4, "point")
    sun_plan = plan_of(camera, Light("sun", unit([1, 2, 3])), points, bounds, partition="z-adaptive", cut="view")
    assert all(a.far == b.near for a, b in zip(sun_plan.projections, sun_plan.projections[1:], strict=False))
    plan = plan_of(camera, light, points, bounds)
    inside = np.zeros(len(points), int)
    for p in plan.projections:
        inside += (points @ p.region_planes_ws[:, :3].T + p.region_planes_ws[:, 3] > 0.0).all(axis=1)
    assert (inside == 1).all() and [p.face for p in plan.projections] == list(range(6))


@pytest.mark.parametrize("warp", WARPS)
def test_an_orthographic_view_is_mapped_uniformly(warp):
    camera = camera_at((0, -30, 15), (0, 5, 0), near=-50.0, far=120.0, orthographic=12.0)
    points = receivers_on(camera, BOUNDS)
    for kind in FITS:
        plan = plan_of(camera, sun_at(camera, 50.0), points, BOUNDS, warp, "z-adaptive", kind)
        for _, p, own in _served(plan, camera, sun_at(camera, 50.0), points)[1]:
            w = lookup.project(p, own)[3]
            assert np.ptp(w) <= 0.02  # a log map keeps the last 1.6 %
            assert p.log is not None or p.warp_parameter == np.inf


@pytest.mark.parametrize("azimuth", [0.0, 37.0, 90.0])
@pytest.mark.parametrize("gamma", [0.0, 1e-7, 1e-3, 0.3, 89.9999999, 90.0, 179.9999999, 180.0])
def test_hostile_angles_and_ratios_give_finite_matrices(gamma, azimuth):
    for near, far in ((1e-3, 1e5), (1.0, 1.0001), (0.1, 1000.0)):
        camera = camera_at((0, -30, 15), (0, 5, 0), near=near, far=far)
        light = sun_at(camera, gamma, azimuth)
        for warp in WARPS:
            for kind in ("frustum", "scene"):
                for p in plan_of(camera, light, np.zeros((0, 3)), BOUNDS, warp, "none", kind).projections:
                    assert np.isfinite(p.clip_from_world).all() and np.isfinite(p.light_depth_range).all() and p.warp_parameter > 0.0


def _worst_jump(warp, kind, beside_deg, azimuth_deg=0.0, step_deg=1.0, ahead=False):
    """Largest ratio of texel sizes from frame to frame of an orbit about z on which the light passes the view axis at `beside_deg`."""
    light_axis = unit([np.cos(0.5), 0.0, -np.sin(0.5)])
    right, up, a = np.array([0, 1, 0]), np.array([np.sin(0.5), 0, np.cos(0.5)]), np.radians(azimuth_deg)
    passing = light_axis + np.radians(beside_deg) * (np.sin(a) * right + np.cos(a) * up)
    light = Light("sun", unit(passing * (1.0 if ahead else -1.0)))
    grid = np.stack(np.meshgrid(np.linspace(-15, 15, 61), np.linspace(-15, 15, 61), [0.0, 3.0]), axis=-1).reshape(-1, 3)
    bounds = np.array([[-15.0, -15.0, 0.0], [15.0, 15.0, 3.0]])
    last, worst = None, 1.0
    for angle in np.radians(np.arange(-18.0, 18.0 + step_deg, step_deg)):
        c, s = np.cos(angle), np.sin(angle)
        camera = camera_at(-45.0 * np.array([c * light_axis[0], s * light_axis[0], light_axis[2]]), (0, 0, 0), near=1.0, far=100.0)
        sizes = texel_sizes(plan_of(camera, light, grid, bounds, warp, "z-adaptive", kind, casters=np.zeros((0, 2, 3)), count=2), light)
        assert np.isfinite(sizes).all()
        if last is not None:
            worst = max(worst, np.exp(np.abs(np.log(sizes / last))).max())
        last = sizes
    return worst


@pytest.mark.parametrize("warp", WARPS)
@pytest.mark.parametrize("kind", FITS)
def test_texel_sizes_are_steady_while_the_light_passes_through_the_view_axis(warp, kind):
    assert _worst_jump(warp, kind, 0.0) < 1.25
    assert _worst_jump(warp, kind, 0.3) < 1.25


@pytest.mark.parametrize("beside", [0.3, 1.5, 4.0])
def test_texel_sizes_are_steady_at_other_distances_and_for_a_light_ahead(beside):
    for kind in ("frustum", "scene"):
        assert _worst_jump("lispsm-general", kind, beside, azimuth_deg=30.0, ahead=True) < 1.25


def test_samples_fit_without_samples_is_refused():
    camera = camera_at((0, -30, 15), (0, 5, 0))
    with pytest.raises(ValueError, match="receivers_ws"):
        plan_shadows(
            camera,
            sun_at(camera, 50.0),
            WarpChoice(),
            PartitionChoice(),
            FitChoice("samples"),
            receivers_ws=None,
            scene_bounds_ws=BOUNDS,
            caster_bounds_ws=np.zeros((0, 2, 3)),
            image_size=IMAGE,
        )


def test_a_frustum_fit_covers_the_corners_of_every_slab_exactly():
    camera = camera_at((0, -30, 15), (0, 5, 0))
    plan = plan_of(camera, sun_at(camera, 65.0), np.zeros((0, 3)), BOUNDS, "lispsm", "z-log", "frustum", margin=0.0, cut="view")
    for p in plan.projections:
        s, t, *_ = lookup.project(p, frustum_corners(camera, *p.fitted_range) + camera.eye_ws)
        assert np.allclose([s.min(), s.max(), t.min(), t.max()], [-1, 1, -1, 1], atol=1e-9)
