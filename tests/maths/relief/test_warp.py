"""The warp against its definition: the direct projection of the texel's world point, over random rigs of every kind."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.errors import SceneError
from addon.maths.relief.frame import capture_frame
from addon.maths.relief.warp import depth_from_relief, eye_in_plane, relief_from_depth, relief_warp
from tests.margins import agree, at_most
from tests.maths.relief.rigs import (
    IMAGE,
    apply_homography,
    capture_of,
    homography_of_quad,
    hull_of,
    look_at,
    ortho_at,
    project_texels,
    random_eye,
    random_texels,
)

RIGS = 2000


def _rig(rng: np.random.Generator, perspective_capture: bool, ortho_view: bool):
    hull = hull_of(rng)
    frame, capture_camera = capture_of(rng, hull, perspective_capture)
    camera = random_eye(rng, hull, capture_camera, ortho_view)
    return frame, camera, *random_texels(rng, frame, 16)


@pytest.mark.parametrize("perspective_capture", [False, True])
@pytest.mark.parametrize("ortho_view", [False, True])
def test_the_forward_warp_is_the_direct_projection_of_the_texels_point(perspective_capture, ortho_view):
    rng = np.random.default_rng(5)
    worst = 0.0
    for _ in range(RIGS // 4):
        frame, camera, uv, relief = _rig(rng, perspective_capture, ortho_view)
        warped = relief_warp(frame, camera).forward(uv, relief)
        pixels = apply_homography(homography_of_quad(frame, camera, IMAGE), warped)
        worst = max(worst, float(np.abs(pixels - project_texels(frame, camera, IMAGE, uv, relief)).max()))
        world = np.concatenate([frame.points_ws(uv, relief), np.ones((16, 1))], axis=1)
        clip = world @ camera.clip_from_world.T
        direct = (clip[:, :2] / clip[:, 3:] * [0.5, -0.5] + 0.5) * IMAGE
        worst = max(worst, float(np.abs(pixels - direct).max()))
    assert worst < 1e-6


@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
@settings(max_examples=60, deadline=None)
def test_the_warp_inverts_and_is_radial_about_the_epipole(seed, perspective_capture, ortho_view):
    frame, camera, uv, relief = _rig(np.random.default_rng(seed), perspective_capture, ortho_view)
    warp = relief_warp(frame, camera)
    warped = warp.forward(uv, relief)
    agree(warp.inverse(warped, relief), uv, abs=1e-7)
    e_u, e_v, e_w = warp.K
    if abs(e_w) > 1e-3 * np.hypot(e_u, e_v):
        epipole = np.array([e_u, e_v]) / e_w
        agree(warped, epipole + warp.scale(relief)[:, None] * (uv - epipole), abs=1e-6)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_the_inverse_lies_on_the_view_ray(seed):
    """The texel that `inverse` gives at a relief has its world point on the ray from the eye through the warped place."""
    frame, camera, uv, relief = _rig(np.random.default_rng(seed), bool(seed & 1), False)
    warp = relief_warp(frame, camera)
    on_ray = frame.points_ws(warp.inverse(uv, relief), relief) - camera.eye_ws
    on_plane = frame.points_ws(uv, np.zeros(len(uv))) - camera.eye_ws
    sine = np.linalg.norm(np.cross(on_ray, on_plane), axis=1) / np.linalg.norm(on_ray, axis=1) / np.linalg.norm(on_plane, axis=1)
    at_most(sine.max(), 1e-9)


def test_a_perspective_capture_is_the_identity_at_its_own_eye_however_the_camera_turns():
    rng = np.random.default_rng(7)
    for _ in range(50):
        hull = hull_of(rng)
        frame, camera = capture_of(rng, hull, True)
        uv, relief = random_texels(rng, frame, 16)
        turned = look_at(camera.eye_ws, camera.eye_ws + rng.normal(size=3), np.array([0.1, 0.2, 1.0]))
        np.testing.assert_allclose(relief_warp(frame, turned).forward(uv, relief), uv, atol=1e-9 * max(frame.width, frame.height))


def test_an_orthographic_capture_of_an_orthographic_view_is_the_identity_wherever_the_camera_slides():
    rng = np.random.default_rng(8)
    hull = hull_of(rng)
    camera = ortho_at(rng.normal(size=3) * 20, hull.mean(axis=0))
    frame = capture_frame(hull, camera, IMAGE)
    assert not frame.is_perspective
    uv, relief = random_texels(rng, frame, 16)
    slid = ortho_at(camera.eye_ws + 3 * camera.world_from_view[:3, 0], hull.mean(axis=0) + 3 * camera.world_from_view[:3, 0])
    np.testing.assert_allclose(relief_warp(frame, slid).forward(uv, relief), uv, atol=1e-9)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_texels_and_points_invert_each_other(seed):
    frame, _, uv, relief = _rig(np.random.default_rng(seed), bool(seed & 1), False)
    back_uv, back_relief = frame.texels(frame.points_ws(uv, relief))
    agree(back_uv, uv, abs=1e-7)
    agree(back_relief, relief, rel=1e-7, abs=1e-10 * max(frame.depth_m, 1.0))
    depth = depth_from_relief(frame.source, relief)
    agree(relief_from_depth(frame.source, depth), relief, rel=1e-9, abs=1e-15)
    assert depth.min() >= 0.0
    agree((frame.plane_from_world @ np.append(frame.points_ws(uv, relief)[0], 1.0))[2], depth[0], abs=1e-9)


def test_the_coefficients_are_the_triple_products_of_oliveira():
    rng = np.random.default_rng(11)
    for _ in range(50):
        frame, camera, _, _ = _rig(rng, False, False)
        a, b, f, c0 = frame.world_from_plane[:3].T
        c = c0 - camera.eye_ws
        triples = [(np.cross(b, c), a), (np.cross(c, a), b), (np.cross(a, b), c)]
        np.testing.assert_allclose(relief_warp(frame, camera).k, [f @ n / (d @ n) for n, d in triples], rtol=1e-8)


def test_the_displacement_is_ri_5_3():
    """Δu = (u_e − u_f)·∂/(h + ∂), h the eye's distance to the plane, ∂ positive away from it (orthographic capture)."""
    rng = np.random.default_rng(12)
    for _ in range(50):
        frame, camera, uv, relief = _rig(rng, False, False)
        e = eye_in_plane(frame, camera)
        expected = uv + (e[:2] - uv) * (relief / (-e[2] + relief))[:, None]
        np.testing.assert_allclose(relief_warp(frame, camera).forward(uv, relief), expected, atol=1e-9)


def test_the_captures_camera_puts_pixel_centres_on_texel_centres():
    rng = np.random.default_rng(14)
    for perspective in (False, True):
        for _ in range(20):
            frame, camera = capture_of(rng, hull_of(rng), perspective)
            uv, relief = random_texels(rng, frame, 16)
            own = frame.camera()
            clip = np.concatenate([frame.points_ws(uv, relief), np.ones((16, 1))], axis=1) @ own.clip_from_world.T
            pixel = (clip[:, :2] / clip[:, 3:] * [0.5, -0.5] + 0.5) * [frame.width, frame.height]
            np.testing.assert_allclose(pixel, uv, atol=1e-6)
            assert np.abs(clip[:, 2] / clip[:, 3]).max() <= 1.0
            if perspective:
                np.testing.assert_allclose(own.eye_ws, camera.eye_ws, atol=1e-9)


def test_an_eye_behind_the_plane_is_refused():
    rng = np.random.default_rng(15)
    hull = hull_of(rng)
    frame, camera = capture_of(rng, hull, True)
    behind = look_at(2 * hull.mean(axis=0) - camera.eye_ws, hull.mean(axis=0))
    with pytest.raises(SceneError, match="before the impostor's plane"):
        relief_warp(frame, behind)
