"""The capture's quad: it faces the eye, touches the front of the object, holds all of it, and its texels are pixels."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.errors import SceneError
from addon.maths.relief.frame import BOX_FACES, MARGIN_TEXELS, box_area, box_section, capture_frame, tilt_rad, visible_extent
from addon.maths.relief.warp import relief_warp
from tests.margins import agree, at_most
from tests.maths.relief.rigs import (
    HALF_FOV,
    IMAGE,
    capture_of,
    chosen,
    corners,
    homography_of_quad,
    hull_of,
    look_at,
    ortho_at,
    project_texels,
    random_eye,
)


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=80)
def test_the_quad_faces_the_camera_and_touches_the_front_of_the_object(seed, perspective):
    rng = np.random.default_rng(seed)
    hull = hull_of(rng)
    frame, camera = capture_of(rng, hull, perspective)
    a, b, f, _ = frame.world_from_plane[:3].T
    agree([a @ b, a @ f, b @ f], 0.0, abs=1e-12)
    agree(np.linalg.norm([a, b], axis=1), frame.texel_m, rel=1e-7)
    assert np.linalg.det(frame.world_from_plane) > 0.0
    towards = hull.mean(axis=0) - camera.eye_ws
    agree(f, camera.direction_ws if perspective else towards / np.linalg.norm(towards), abs=1e-12)
    depth = (np.column_stack([hull, np.ones(8)]) @ frame.plane_from_world.T)[:, 2]
    agree([depth.min(), depth.max()], [0.0, frame.depth_m], abs=1e-9)
    assert a @ camera.world_from_view[:3, 0] > 0.0


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=80)
def test_the_quad_holds_the_whole_object_within_its_margin(seed, perspective):
    rng = np.random.default_rng(seed)
    hull = hull_of(rng)
    frame, _ = capture_of(rng, hull, perspective)
    inside = hull.mean(axis=0) + rng.uniform(-1, 1, (50, 3)) * np.ptp(hull, axis=0) / 2
    uv, _ = frame.texels(np.concatenate([hull, inside]))
    assert (uv.min(axis=0) >= 2 - 1e-6).all()
    assert (uv.max(axis=0) <= [frame.width - 2 + 1e-6, frame.height - 2 + 1e-6]).all()
    assert (uv[:8].min(axis=0) < 4).all() or max(frame.width, frame.height) == 1024


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.5, 1.0, 2.0]))
@settings(max_examples=60)
def test_a_texel_covers_the_asked_share_of_a_pixel_at_the_quads_middle(seed, texels_per_pixel):
    rng = np.random.default_rng(seed)
    hull = hull_of(rng)
    _, camera = capture_of(rng, hull, True)
    frame = capture_frame(hull, camera, IMAGE, chosen(texels_per_pixel=texels_per_pixel, max_texels=8192))
    middle = frame.centre_uv + np.array([[0, 0], [1, 0], [0, 1], [0.7, 0.7]])
    pixels = project_texels(frame, camera, IMAGE, middle, np.zeros(4))
    steps = np.linalg.norm(pixels[1:] - pixels[0], axis=1)
    at_most(steps.max(), 1.02 / texels_per_pixel)
    assert steps.max() >= 0.7 / texels_per_pixel


def test_the_resolution_is_ri_5_1_at_the_front_of_the_object():
    """A box on the camera's axis, seen along one of its sides: texels across = 5-1 × D/(D − R) with R half the box's depth."""
    hull = corners([-1.0, -1.0, -1.5], [1.0, 1.0, 1.5])
    camera = look_at([0.0, -10.0, 0.0], [0.0, 0.0, 0.0])
    frame = capture_frame(hull, camera, IMAGE, chosen(perspective=False))
    ri_5_1 = IMAGE[1] * 3.0 / (2.0 * 10.0 * np.tan(HALF_FOV))
    assert frame.height == np.ceil(ri_5_1 * 10.0 / (10.0 - 1.0)) + 2 * MARGIN_TEXELS + 1


def test_the_texture_never_exceeds_its_upper_bound():
    rng = np.random.default_rng(3)
    for limit in (16, 100):
        hull = hull_of(rng)
        _, camera = capture_of(rng, hull, True)
        frame = capture_frame(hull, camera, (8000, 6000), chosen(max_texels=limit))
        assert limit - 1 <= max(frame.width, frame.height) <= limit
        uv, _ = frame.texels(hull)
        assert uv.min() >= 2 - 1e-9
        assert (uv.max(axis=0) <= np.array([frame.width, frame.height]) - 2 + 1e-9).all()


@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
@settings(max_examples=60)
def test_the_visible_extent_holds_every_warped_point_of_the_hull(seed, perspective, ortho_view):
    rng = np.random.default_rng(seed)
    hull = hull_of(rng)
    frame, capture_camera = capture_of(rng, hull, perspective)
    camera = random_eye(rng, hull, capture_camera, ortho_view)
    inside = hull.mean(axis=0) + rng.uniform(-1, 1, (50, 3)) * np.ptp(hull, axis=0) / 2
    warped = relief_warp(frame, camera).forward(*frame.texels(inside))
    low, high = visible_extent(frame, hull, camera)
    assert (warped >= low - 1e-6).all()
    assert (warped <= high + 1e-6).all()
    at_corners = relief_warp(frame, camera).forward(*frame.texels(hull))
    agree([at_corners.min(axis=0), at_corners.max(axis=0)], [low, high], abs=1e-6)


def test_the_tilt_is_zero_at_the_capture_and_the_angle_of_the_orbit_elsewhere():
    hull = corners([-1, -1, -1], [1, 1, 1])
    frame = capture_frame(hull, look_at([0, -10, 0], [0, 0, 0]), IMAGE)
    assert tilt_rad(frame, look_at([0, -10, 0], [3, 0, 0])) == pytest.approx(0.0, abs=1e-12)
    middle = (frame.world_from_plane @ [*frame.centre_uv, 0.0, 1.0])[:3]
    for angle in (0.1, 0.8, 2.5, pi):
        capture_eye = np.array([0, -10.0, 0]) - middle
        eye = middle + np.cos(angle) * capture_eye + np.sin(angle) * np.cross([0, 0, 1], capture_eye)
        assert tilt_rad(frame, look_at(eye, middle)) == pytest.approx(angle)
        assert tilt_rad(frame, ortho_at(eye, middle)) == pytest.approx(angle)


def test_a_flat_object_is_captured_from_the_front_and_edge_on():
    hull = corners([-1, 0, -1], [1, 0, 1])
    for eye in ([0, -10, 0], [10, 0, 0], [5, -5, 1]):
        frame = capture_frame(hull, look_at(eye, [0, 0, 0]), IMAGE)
        uv, relief = frame.texels(hull)
        assert np.isfinite(uv).all()
        assert np.isfinite(relief).all()
        assert min(frame.width, frame.height) >= 5
        frame.camera()


@pytest.mark.parametrize(
    ("hull", "message"),
    [
        (np.zeros((8, 3)), "single point"),
        (np.full((8, 3), np.nan), "finite"),
        (np.empty((0, 3)), "finite"),
        (corners([-1, -14, -1], [1, -12, 1]), "behind the camera"),
        (corners([-20, -20, -20], [20, 20, 20]), "around the camera"),
        (corners([-1, -10.05, -1], [1, 5, 1]), "around the camera"),
    ],
)
def test_an_object_that_cannot_be_captured_is_refused_with_the_reason(hull, message):
    with pytest.raises(SceneError, match=message):
        capture_frame(hull, look_at([0, -10, 0], [0, 0, 0]), IMAGE)


def test_an_object_behind_an_orthographic_camera_is_refused():
    with pytest.raises(SceneError, match="behind"):
        capture_frame(corners([-1, -14, -1], [1, -12, 1]), ortho_at([0, -10, 0], [0, 0, 0]), IMAGE)


def test_the_captured_quad_is_seen_upright_and_not_mirrored():
    """u grows to the right and v downwards in the image of the capturing camera."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        frame, camera = capture_of(rng, hull_of(rng), True)
        homography = homography_of_quad(frame, camera, IMAGE)
        origin, right, down = (homography @ [u, v, 1] for u, v in ((0, 0), (frame.width, 0), (0, frame.height)))
        origin, right, down = (p[:2] / p[2] for p in (origin, right, down))
        assert (right - origin)[0] > 0.0
        assert np.linalg.det(np.stack([right - origin, down - origin])) > 0.0


@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 2.0, 4.0]), st.sampled_from([1, 2, 4]))
@settings(max_examples=60)
def test_the_pictures_samples_fall_on_a_perspective_captures_samples(seed, texels_per_pixel, picture_samples):
    """Over the whole quad, the first sample of every pixel lies a quarter texel from a half texel's border: from its own eye the capture is
    the picture. All samples do where the texels have as many."""
    rng = np.random.default_rng(seed)
    hull = hull_of(rng)
    _, camera = capture_of(rng, hull, True)
    frame = capture_frame(hull, camera, IMAGE, chosen(texels_per_pixel=texels_per_pixel, max_texels=8192), picture_samples)
    corner = rng.integers(0, [frame.width, frame.height], (20, 2)).astype(float)
    pixels = project_texels(frame, camera, IMAGE, corner, np.zeros(20))
    count = picture_samples if (2 * texels_per_pixel / picture_samples) % 1.0 == 0.0 else 1
    sample = (rng.integers(0, count, (20, 2)) + 0.5) / picture_samples
    quarters = (sample - pixels) * texels_per_pixel * 4.0
    at_most(np.abs(quarters / 2.0 - 0.5 - np.round(quarters / 2.0 - 0.5)).max(), 1e-4)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_half_of_the_faces_areas_is_the_area_of_a_boxs_image(seed):
    """Against the pixels whose centres lie within the image: within one of six triangle pairs."""
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1, 0.5, 3)
    box = corners(low, low + rng.uniform(0.2, 1.5, 3))
    camera = look_at(box.mean(axis=0) + 8.0 * _direction(rng), box.mean(axis=0))
    clip = np.column_stack([box, np.ones(8)]) @ camera.clip_from_world.T
    image = clip[:, :2] / clip[:, 3:] * 100.0
    first, last = np.floor(image.min(axis=0)), np.ceil(image.max(axis=0))
    steps = (last - first) / 200.0
    points = (first + (np.stack(np.meshgrid(*2 * [np.arange(200)], indexing="ij"), axis=-1) + 0.5) * steps).reshape(-1, 2)
    inside = np.zeros(len(points), bool)
    for face in BOX_FACES:
        side = np.array([_cross(image[face[k]] - image[face[k - 1]], points - image[face[k - 1]]) for k in range(4)])
        inside |= (side >= 0.0).all(axis=0) | (side <= 0.0).all(axis=0)
    agree(box_area(image), inside.sum() * steps.prod(), rel=0.02)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_a_box_seen_along_its_axis_has_the_section_of_its_face_whatever_the_distance(seed):
    """A flat box, so that no face is nearer than the middle; from infinity any box, turned as well."""
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1, 0.5, 3)
    size = rng.uniform(0.2, 1.5, 3)
    flat = corners(low, low + size * [1.0, 1.0, 1e-9])
    middle = flat.mean(axis=0)
    for distance in (0.5, 3.0, 100.0):
        agree(float(box_section(flat, np.append(middle + [0.0, 0.0, distance], 1.0))), float(size[0] * size[1]), rel=1e-6)
    direction = _direction(rng)
    faces = size[[1, 0, 0]] * size[[2, 2, 1]]
    agree(float(box_section(corners(low, low + size), np.append(direction, 0.0))), float(np.abs(direction) @ faces), rel=1e-9)


def _direction(rng: np.random.Generator) -> np.ndarray:
    out = rng.normal(size=3)
    return out / np.linalg.norm(out)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
