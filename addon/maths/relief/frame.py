"""The quad an impostor is captured on: facing the camera, through the front of the bounds, with RI 5-1's resolution. No GPU.

The plane touches the front of the bounds, so every point has d ≥ 0 and the warp's scale is at most 1 (method §7).
"""

from __future__ import annotations

import numpy as np

from ...errors import SceneError
from ..spaces import angle_between
from ..view import Camera
from .settings import USUAL, ImpostorSettings
from .warp import ORTHOGRAPHIC_SOURCE, CaptureFrame, eye_in_plane, pixel_from_clip

SMALLEST_DISTANCE = 0.05
"""The plane must be at least this share of the object's depth away from a perspective eye; nearer, the object surrounds the camera."""
MARGIN_TEXELS = 2
"""Empty border of a capture on every side."""


def capture_frame(
    hull_ws: np.ndarray, camera: Camera, size: tuple[int, int], settings: ImpostorSettings = USUAL, picture_samples: int = 1
) -> CaptureFrame:
    """The frame that captures the object inside the convex hull of `hull_ws` (n, 3) for `camera` with an image of `size` (w, h) pixels.

    A perspective capture lies parallel to the image, its texels on the pixels: from this eye it is the very picture, pixel by pixel. An
    orthographic one faces the eye, its normal the line through the hull's middle. One texel covers 1/`texels_per_pixel` pixel (at the
    quad's centre): RI 5-1 × D/(D − R) with the plane at D − R. `picture_samples` per pixel and side in the pictures to come: the grid is
    laid so that their samples fall on the texels' own.
    Raises `SceneError` for a hull without extent, with a vertex that is not finite, behind, or around the camera.
    """
    hull = np.asarray(hull_ws, dtype=np.float64)
    if hull.ndim != 2 or not len(hull) or not np.isfinite(hull).all():
        raise SceneError("The impostor's object has no finite bounds: check its mesh.")
    extent_m = float(np.linalg.norm(hull.max(axis=0) - hull.min(axis=0)))
    if not extent_m > 0.0:
        raise SceneError("The impostor's object is a single point: there is nothing to capture.")
    centre = (hull.max(axis=0) + hull.min(axis=0)) / 2.0
    eye, axes = camera.eye_ws, _axes(camera, centre, settings.is_perspective)
    depths = (hull - eye) @ axes[2]
    front, depth_m = float(depths.min()), float(np.ptp(depths))
    smallest = camera.near - depth_m if camera.is_orthographic else SMALLEST_DISTANCE * max(depth_m, 1e-3 * extent_m)
    if not front > smallest:
        raise SceneError("The impostor's object lies behind or around the camera: move the camera out of it or draw its geometry.")
    return _frame(hull - eye, axes, front, depth_m, camera, size, settings, picture_samples)


def _frame(
    hull: np.ndarray,
    axes: np.ndarray,
    front: float,
    depth_m: float,
    camera: Camera,
    size: tuple[int, int],
    settings: ImpostorSettings,
    picture_samples: int,
) -> CaptureFrame:
    """The frame from axes (rows: right, down, away) and the hull relative to the eye.

    Its corner is laid so that the first of a pixel's n samples per side, (1/2n) pixel from the pixel's corner, falls on one of the texel's
    two samples per side, 1/4 texel from the texel's: a shift of 1/4 − t/2n texels, t texels per pixel.
    """
    through_eye = settings.is_perspective and not camera.is_orthographic
    across = hull @ axes[:2].T
    if through_eye:
        across = across * (front / (hull @ axes[2]))[:, None]
    low, high = across.min(axis=0), across.max(axis=0)
    middle_ws = camera.eye_ws + (low + high) / 2.0 @ axes[:2] + front * axes[2]
    texel = 1.0 / (_pixels_per_metre(camera, size, middle_ws, axes) * settings.texels_per_pixel)
    room = settings.max_texels - 2 * MARGIN_TEXELS - 1
    texel = max(texel, float((high - low).max()) / room)
    count = np.clip(np.ceil((high - low) / texel - 1e-9), 1, room).astype(int) + 2 * MARGIN_TEXELS
    corner_ws = middle_ws - (count / 2.0 * texel) @ axes[:2]
    pixel = pixel_from_clip(size) @ camera.clip_from_world @ np.append(corner_ws, 1.0)
    shift = 0.25 - 0.5 * settings.texels_per_pixel / picture_samples
    beyond = np.mod(pixel[:2] / pixel[2] * settings.texels_per_pixel + shift + 1e-6, 1.0) - 1e-6
    world_from_plane = np.eye(4)
    world_from_plane[:3, :3] = (axes * [[texel], [texel], [1.0]]).T
    world_from_plane[:3, 3] = corner_ws - (beyond * texel) @ axes[:2]
    count = count + 1
    bare = CaptureFrame(world_from_plane, ORTHOGRAPHIC_SOURCE, ORTHOGRAPHIC_SOURCE, int(count[0]), int(count[1]), depth_m)
    eye = eye_in_plane(bare, camera)
    return CaptureFrame(world_from_plane, eye if through_eye else ORTHOGRAPHIC_SOURCE, eye, bare.width, bare.height, depth_m)


def _axes(camera: Camera, centre_ws: np.ndarray, is_perspective: bool) -> np.ndarray:
    """(3, 3) rows right, down, away: the image's own, or, for an orthographic capture, turned to face the eye."""
    right, up, back = camera.world_from_view[:3, :3].T
    if camera.is_orthographic:
        return np.stack([right, -up, -back])
    towards = centre_ws - camera.eye_ws
    distance = float(np.linalg.norm(towards))
    if not (distance > 0.0 and towards @ back < 0.0):
        raise SceneError("The impostor's object lies behind the camera: turn the camera towards it.")
    if is_perspective:
        return np.stack([right, -up, -back])
    away = towards / distance
    right = right - (right @ away) * away
    down = np.cross(away, right)
    return np.stack([right / np.linalg.norm(right), down / np.linalg.norm(down), away])


def _pixels_per_metre(camera: Camera, size: tuple[int, int], point_ws: np.ndarray, axes: np.ndarray) -> float:
    """Largest stretch of the projection of the plane at `point_ws` along `axes[:2]`: the largest singular value of its Jacobian."""
    projection = pixel_from_clip(size) @ camera.clip_from_world
    image = projection @ np.append(point_ws, 1.0)
    if not image[2] > 0.0:
        raise SceneError("The impostor's object lies beside the camera: turn the camera towards it.")
    along = projection[:, :3] @ axes[:2].T
    jacobian = (along[:2] - np.outer(image[:2] / image[2], along[2])) / image[2]
    return float(np.linalg.svd(jacobian, compute_uv=False)[0])


def visible_extent(frame: CaptureFrame, hull_ws: np.ndarray, camera: Camera) -> np.ndarray:
    """(2, 2) smallest and largest (u, v) on the plane under which `camera` can see the hull's content: the quad to draw.

    It reaches beyond the texture where the epipole lies outside it. The eye must stand before the plane (`relief_warp`).
    """
    hull = np.asarray(hull_ws, dtype=np.float64)
    points = np.concatenate([hull, np.ones((len(hull), 1))], axis=1) @ frame.plane_from_world.T
    eye = eye_in_plane(frame, camera)
    depth = np.maximum(points[:, 2:3], 0.0)
    on_plane = (points[:, :2] - depth / eye[2] * eye[:2]) / (1.0 - depth / eye[2] * eye[3])
    return np.stack([on_plane.min(axis=0), on_plane.max(axis=0)])


BOX_FACES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
"""The corners of a box, numbered x, y, z from the slowest to the fastest, round each of its faces."""


def box_area(corners: np.ndarray) -> np.ndarray:
    """(…) the area of a box's image from the images (…, 8, 2) of its corners, all before the eye.

    Half of its faces' areas: every ray that meets the box passes through two of them.
    """
    x, y = np.moveaxis(corners[..., BOX_FACES, :], -1, 0)
    faces = 0.5 * (x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)).sum(axis=-1)
    return 0.5 * np.abs(faces).sum(axis=-1)


NEAREST_SHARE = 0.05
"""Corners nearer to the eye than this share of the box's own distance count as being there."""


def box_section(corners: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """(…) square metres of boxes (…, 8, 3) as seen from `eye` (…, 4), homogeneous: of their images on the planes through their middles that
    face it. How near the eye is hardly matters, from where it looks does."""
    middle = corners.mean(axis=-2)
    towards = eye[..., :3] - eye[..., 3:] * middle
    distance = np.maximum(np.linalg.norm(towards, axis=-1, keepdims=True), 1e-30)
    axis = towards / distance
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis), axis=-1)])
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    basis = np.stack([across, np.cross(axis, across), axis], axis=-1)
    local = (corners - middle[..., None, :]) @ basis
    nearness = 1.0 - eye[..., 3:] * local[..., 2] / distance
    return box_area(local[..., :2] / np.maximum(nearness, NEAREST_SHARE)[..., None])


def tilt_rad(frame: CaptureFrame, camera: Camera) -> float:
    """The angle by which the view of the quad's centre has turned since the capture, 0…π."""
    middle = np.array([*frame.centre_uv, 0.0])
    metres = np.array([frame.texel_m, frame.texel_m, 1.0])
    then, now = ((eye[:3] - eye[3] * middle) * metres for eye in (frame.eye, eye_in_plane(frame, camera)))
    return float(angle_between(then, now))


def is_at_capture(frame: CaptureFrame, camera: Camera) -> bool:
    """Whether the eye is where it was at the capture, within a thousandth of a texel: a perspective capture is the picture then."""
    eye = eye_in_plane(frame, camera)
    return bool(eye[3] == frame.eye[3] and (np.abs(eye - frame.eye) * [1.0, 1.0, 1.0 / frame.texel_m, 1.0] < 1e-3).all())
