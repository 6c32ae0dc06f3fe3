"""Matrices between spaces: rigid, inverse to each other, OpenGL's ends of depth; light space as CONVENTIONS has it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths import spaces
from addon.maths.shadow.light_space import cone_space, round_core, roundness, sun_space
from tests.margins import agree, at_most
from tests.maths.shadow.fit_rigs import camera_at, sun_at, unit
from tests.maths.views import reals

coordinate = st.floats(-1e3, 1e3).map(lambda v: round(v, 6))  # denormal numbers underflow
angle = st.floats(0.0, 360.0).map(lambda v: round(v, 6))
point = st.tuples(coordinate, coordinate, coordinate)


@given(eye=point, target=point, up=st.sampled_from([(0, 0, 1), (0, 1, 0), (1, 1, 1)]))
def test_look_at_is_rigid_and_puts_the_target_on_the_axis(eye, target, up):
    if np.linalg.norm(np.subtract(target, eye)) < 1e-3:
        return
    m = spaces.look_at(eye, target, up)
    agree(m[:3, :3] @ m[:3, :3].T, np.eye(3), abs=1e-12)
    agree(np.linalg.det(m[:3, :3]), 1.0, rel=1e-5, abs=1e-8)
    seen = spaces.transform(m, np.array([eye, target]))[:, :3]
    agree(seen[0], 0.0, abs=1e-9)
    agree(seen[1], [0, 0, -np.linalg.norm(np.subtract(target, eye))], abs=1e-9)


def test_look_at_along_up_is_still_rigid_and_coincident_points_are_refused():
    m = spaces.look_at((0, 0, 5), (0, 0, 0))
    assert np.allclose(m[:3, :3], np.eye(3), atol=1e-12), "straight down: world Y is up in the picture"
    assert np.allclose(spaces.look_at((0, 5, 0), (0, 0, 0), (0, 1, 0))[0, :3], (0, 0, 1), atol=1e-12)
    with pytest.raises(SettingsError):
        spaces.look_at((1, 2, 3), (1, 2, 3))


@given(phi=st.floats(0.05, 1.4), aspect=st.floats(0.3, 3.0), near=st.floats(0.01, 10.0), ratio=st.floats(1.5, 1e4))
def test_perspective_sends_the_frustums_corners_to_the_cube(phi, aspect, near, ratio):
    far = near * ratio
    corners = [[s * d * np.tan(phi) * aspect, t * d * np.tan(phi), -d] for d in (near, far) for t in (-1, 1) for s in (-1, 1)]
    ndc = spaces.divide(spaces.transform(spaces.perspective(phi, aspect, near, far), np.array(corners)))
    agree(ndc, [[s, t, d] for d in (-1, 1) for t in (-1, 1) for s in (-1, 1)], abs=1e-9)


def test_orthographic_sends_the_boxs_corners_to_the_cube():
    ndc = spaces.divide(spaces.transform(spaces.orthographic(3.0, 2.0, -5.0, 7.0), np.array([[6.0, 3.0, 5.0], [-6.0, -3.0, -7.0]])))
    assert np.allclose(ndc, [[1, 1, -1], [-1, -1, 1]])


@given(gamma=angle.map(lambda v: v / 2.0), azimuth=angle)
def test_sun_space_has_wimmers_axes(gamma, azimuth):
    camera = camera_at((3, -4, 5), (0, 0, 1))
    light = sun_at(camera, gamma, azimuth)
    x, y, z = sun_space(light, camera).from_eye[:3, :3]
    agree(np.stack([x, y, z]) @ np.stack([x, y, z]).T, np.eye(3), abs=1e-9)
    agree(np.cross(y, z), x, rel=1e-5, abs=1e-8)
    agree(y, light.direction_ws, rel=1e-5, abs=1e-8)
    sin = np.sin(np.radians(gamma))
    if sin > 1e-6:  # z lies in the plane of y and the view, and points its way
        agree(z @ camera.direction_ws, sin, abs=1e-9)
        at_most(abs(x @ camera.direction_ws), 1e-9)


@given(seed=st.integers(0, 10_000))
def test_a_finite_light_sees_its_rays_as_lines_along_y(seed):
    rng = np.random.default_rng(seed)
    camera = camera_at((3, -4, 5), (0, 0, 1))
    position, travel = rng.uniform(-5, 5, 3), unit(rng.normal(size=3))
    space = cone_space(position, travel, 0.7, 50.0, camera)
    ray = unit(travel + 0.5 * rng.uniform(-1, 1, 3))
    distance = np.sort(rng.uniform(1.0, 30.0, 5))
    seen = space.points(position + distance[:, None] * ray)
    at_most(np.ptp(seen[:, 0]), 1e-9)
    at_most(np.ptp(seen[:, 2]), 1e-9)
    assert (np.diff(seen[:, 1]) < 0.0).all()  # y grows towards the light


def test_a_finite_lights_view_axis_runs_along_z_at_apex_x():
    camera = camera_at((3, -4, 5), (0, 0, 1))
    space = cone_space(np.array([2.0, 3.0, 6.0]), unit([0.1, 0.3, -1.0]), 1.2, 50.0, camera)
    seen = space.points(np.linspace(2.0, 9.0, 6)[:, None] * camera.direction_ws)
    assert np.allclose(seen[:, 0], space.apex_x) and (np.diff(seen[:, 2]) > 0.0).all()


@given(gamma_lim=reals(0.0, 1.6))
def test_roundness_is_one_in_the_core_zero_from_gamma_lim_and_falls_between(gamma_lim):
    gammas = np.linspace(0.0, np.pi / 2, 400)
    share = np.array([roundness(g, gamma_lim) for g in gammas])
    assert (np.diff(share) <= 0.0).all() and share[0] == 1.0 and share[-1] == 0.0
    assert (share[gammas <= round_core(gamma_lim)] == 1.0).all()
    assert (share[gammas >= max(gamma_lim, np.radians(4.0))] == 0.0).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_linear_is_the_matrix_product(rng, dtype):
    """Of rows and of matrices with many columns."""
    matrix, columns = rng.normal(size=(4, 3)).astype(dtype), rng.normal(size=(3, 5000)).astype(dtype)
    expected = [matrix @ columns, matrix[0] @ columns]
    found = [spaces.linear(matrix, columns), spaces.linear(matrix[0], columns)]
    for a, b in zip(found, expected, strict=True):
        assert a.dtype == dtype and a.shape == b.shape
        assert np.allclose(a, b, rtol=0.0, atol=1e-5 if dtype == np.float32 else 1e-12)
