"""The measured error against finite differences, an explicit mid plane and numpy's SVD, and the texts' curves on the view axis."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths import spaces
from addon.maths.choices import WARPS
from addon.maths.error import measure
from addon.maths.shadow import lookup
from addon.maths.view import Light
from addon.maths.warping.formulas import warp_depth
from tests.margins import agree
from tests.maths.shadow.fit_rigs import IMAGE, camera_at, plan_of, receivers_on, sun_at, unit

BOUNDS = np.array([[-20.0, -20.0, 0.0], [20.0, 40.0, 8.0]])
SIZE = 512
NONE = np.zeros((0, 3))
BOX = np.array([[-500.0] * 3, [500.0] * 3])
no_casters = np.zeros((0, 2, 3))


def _rig(seed, warp, light_kind="sun", orthographic=None):
    rng = np.random.default_rng(seed)
    camera = camera_at((rng.uniform(-10, 10), -35, rng.uniform(5, 25)), (0, 5, 0), orthographic=orthographic)
    light = Light("sun", unit([rng.normal(), rng.normal(), 1.5]))
    if light_kind == "spot":
        light = Light("spot", unit([0.2, -0.3, 1.0]), np.array([8.0, -10.0, 45.0]), cone_rad=1.0)
    points = receivers_on(camera, BOUNDS, 400, seed)
    normals = rng.normal(size=points.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return camera, light, plan_of(camera, light, points, BOUNDS, warp, "z-log", "scene"), points, normals


def _on_plane(camera, pixel, origin, normal):
    """The point of a plane that a pixel (x, y; y up) sees, by the inverse of the camera's matrix."""
    ndc = 2.0 * pixel / np.array(IMAGE) - 1.0
    a, b = spaces.divide(spaces.transform(np.linalg.inv(camera.clip_from_world), np.array([[*ndc, -1.0], [*ndc, 0.5]])))
    return a + (b - a) * ((origin - a) @ normal) / ((b - a) @ normal)


def _numeric_jacobian(camera, projection, point, normal, h=1e-3):
    """∂(texel s, t)/∂(pixel x, y) by central differences through the plane."""
    pixel = 0.5 * (spaces.divide(spaces.transform(camera.clip_from_world, point[None]))[0, :2] + 1.0) * IMAGE
    columns = []
    for step in np.eye(2) * h:
        ends = np.array([_on_plane(camera, pixel + sign * step, point, normal) for sign in (1.0, -1.0)])
        s, t, *_ = lookup.project(projection, ends)
        columns.append([(s[0] - s[1]) / (2 * h), (t[0] - t[1]) / (2 * h)])
    return 0.5 * SIZE * np.array(columns).T


@pytest.mark.parametrize("light_kind", ["sun", "spot"])
@pytest.mark.parametrize("orthographic", [None, 14.0])
@given(seed=st.integers(0, 100_000), warp=st.sampled_from(WARPS))
@settings(max_examples=8)
def test_errors_are_those_of_the_finite_difference_jacobian(light_kind, orthographic, seed, warp):
    camera, light, plan, points, normals = _rig(seed, warp, light_kind, orthographic)
    got = measure.aliasing(camera, light, plan, points, normals, IMAGE, SIZE)
    index = lookup.partition_index(plan, camera, points)
    to_light, to_eye = lookup.towards_light(light, points), measure.towards_eye(camera, points)
    clear = (np.abs((normals * to_light).sum(1)) > 0.2) & (np.abs((normals * to_eye).sum(1)) > 0.2) & ((to_light * to_eye).sum(1) > -0.7)
    for k in np.flatnonzero(clear & (index >= 0))[:6]:
        projection = plan.projections[index[k]]
        j = _numeric_jacobian(camera, projection, points[k], normals[k])
        agree(got[k, 0], 1.0 / abs(np.linalg.det(j)), rel=1e-4)
        u, sigma, _ = np.linalg.svd(_numeric_jacobian(camera, projection, points[k], unit(to_light[k] + to_eye[k])))
        large_is_s = abs(u[0, 0]) >= abs(u[1, 0])
        if abs(abs(u[0, 0]) - abs(u[1, 0])) > 1e-3:
            agree(got[k, 1:], 1.0 / (sigma if large_is_s else sigma[::-1]), rel=1e-3)


@given(seed=st.integers(0, 100_000), warp=st.sampled_from(WARPS))
@settings(max_examples=20)
def test_on_cards_that_face_the_mid_direction_the_total_is_the_product_of_the_perspective_errors(seed, warp):
    camera, light, plan, points, _ = _rig(seed, warp)
    mid = lookup.towards_light(light, points) + measure.towards_eye(camera, points)
    mid /= np.linalg.norm(mid, axis=1, keepdims=True)
    m = measure.aliasing(camera, light, plan, points, mid, IMAGE, SIZE)
    m = m[~np.isnan(m[:, 0])]
    assert len(m)
    agree(m[:, 0], m[:, 1] * m[:, 2], rel=1e-6)


@pytest.mark.parametrize("warp", WARPS)
@given(gamma=st.floats(40.0, 90.0), ratio=st.floats(3.0, 300.0))
@settings(max_examples=8)
def test_m_z_on_the_view_axis_is_the_texts_times_sin_gamma(warp, gamma, ratio):
    """T4 (37) measures a texel along the view axis, dz/dt; the beam across itself (T4 (12), method §1) is sin γ times that.

    The frustum fit without margin is the text's crop in t, so the agreement is exact, for every n' that the plan used.
    """
    near, far, phi = 1.0, ratio, np.radians(30.0)
    camera = camera_at((3, 4, 5), (13, 8, 2), near=near, far=far, phi_deg=30.0)
    light, g = sun_at(camera, gamma), np.radians(gamma)
    p = (plan := plan_of(camera, light, NONE, BOX, warp, "none", "frustum", casters=no_casters, size=SIZE, margin=0.0)).projections[0]
    z = np.geomspace(near, far * 0.999, 9)
    points = camera.eye_ws + z[:, None] * camera.direction_ws
    m_z = measure.aliasing(camera, light, plan, points, np.ones_like(points), IMAGE, SIZE)[:, 2]
    depth, along = warp_depth(near, far, phi, g), near * np.tan(phi) * np.cos(g) + (z - near) * np.sin(g)
    n = p.warp_parameter
    if p.log is not None:
        shape = np.log((n + depth) / n) * (n + along)  # LogPSM 5.40
    else:
        shape = depth * np.ones_like(z) if n == np.inf else depth / (n * (n + depth)) * (n + along) ** 2  # T4 (37)
    text = IMAGE[1] / SIZE / (2.0 * np.tan(phi)) * shape / (z * np.sin(g))
    agree(m_z, text * np.sin(g), rel=1e-9)


@pytest.mark.parametrize("warp", WARPS)
def test_m_x_and_m_z_follow_25_and_26_for_light_across_the_view(warp):
    near, far, phi = 1.0, 100.0, np.radians(30.0)
    camera = camera_at((3, 4, 5), (13, 8, 2), near=near, far=far, phi_deg=30.0)
    light = sun_at(camera, 90.0)
    p = (plan := plan_of(camera, light, NONE, BOX, warp, "none", "frustum", casters=no_casters, size=SIZE, margin=0.0)).projections[0]
    z = np.geomspace(near, far * 0.999, 9)
    points = camera.eye_ws + z[:, None] * camera.direction_ws
    m = measure.aliasing(camera, light, plan, points, np.ones_like(points), IMAGE, SIZE)
    n = p.warp_parameter
    uniform_s = n == np.inf or warp == "log"
    assert np.allclose(m[:, 1], IMAGE[0] / SIZE * far / z * (1.0 if uniform_s else (n + z - near) / (n + far - near)), rtol=1e-9)
    if p.log is not None:
        assert np.isclose(n, near) and np.ptp(m[:, 2]) < 1e-9 * m[0, 2]  # flat: LogPSM 5.42
    elif n < np.inf:
        scale = IMAGE[1] / SIZE * (far - near) / (2 * np.tan(phi))
        assert np.allclose(m[:, 2], scale * (n + z - near) ** 2 / (z * n * (n + far - near)), rtol=1e-9)


def test_a_margin_of_m_texels_scales_the_map_by_its_share():
    camera = camera_at((3, 4, 5), (13, 8, 2), near=1.0, far=100.0)
    light, points = sun_at(camera, 70.0), camera.eye_ws + np.array([[2.0], [30.0]]) * camera.direction_ws
    plans = [plan_of(camera, light, NONE, BOX, "uniform", "none", "frustum", no_casters, SIZE, margin) for margin in (0.0, 8.0)]
    bare, framed = (measure.aliasing(camera, light, plan, points, np.ones((2, 3)), IMAGE, SIZE) for plan in plans)
    assert np.allclose(framed[:, 1:] * (SIZE - 16) / SIZE, bare[:, 1:], rtol=1e-12)


def test_points_that_no_map_serves_are_nan_and_surfaces_along_the_light_are_unbounded():
    camera = camera_at((0, -35, 15), (0, 5, 0))
    light, points = sun_at(camera, 70.0), np.array([[0.0, 5.0, 0.0], [0.0, -100.0, 30.0]])
    plan = plan_of(camera, light, NONE, BOUNDS, kind="scene")
    along = np.cross(light.direction_ws, [1.0, 0.0, 0.0])
    m = measure.aliasing(camera, light, plan, points, np.stack([along, along]), IMAGE, SIZE)
    assert np.isnan(m[1]).all() and m[0, 0] > 1e12 and np.isfinite(m[0, 1:]).all()


@given(seed=st.integers(0, 100_000), warp=st.sampled_from(WARPS), light_kind=st.sampled_from(["sun", "spot"]))
@settings(max_examples=20)
def test_a_texels_footprint_is_one_step_in_s_and_one_in_t_across_the_ray(seed, warp, light_kind):
    camera, light, plan, points, _ = _rig(seed, warp, light_kind)
    index = lookup.partition_index(plan, camera, points)
    for i in np.unique(index[index >= 0]):
        p, own = plan.projections[i], points[index == i]
        steps = lookup.texel_footprint(p, own, light, SIZE)
        agree((steps * lookup.towards_light(light, own)[:, None]).sum(axis=-1), 0.0, abs=1e-9)
        h = 1e-4
        for axis in (0, 1):
            ahead, back = lookup.project(p, own + h * steps[:, axis]), lookup.project(p, own - h * steps[:, axis])
            for ndc in (0, 1):
                moved = (ahead[ndc] - back[ndc]) / (2 * h) * SIZE / 2
                agree(moved, float(ndc == axis), abs=1e-5)
