"""Random rigs for the tests of relief impostors: hulls, cameras that look at them, captures, texels."""

from math import tan

import numpy as np

from addon.maths.relief.frame import capture_frame
from addon.maths.relief.settings import ImpostorSettings
from addon.maths.relief.warp import CaptureFrame, pixel_from_clip, relief_from_depth
from addon.maths.view import Camera

IMAGE = (640, 480)
HALF_FOV = 0.35


def look_at(eye, target, up=(0.0, 0.0, 1.0), clip: np.ndarray | None = None, near: float = 0.01, far: float = 1000.0) -> Camera:
    """A perspective camera (or one with the given clip matrix) at `eye` towards `target`."""
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(back, right), back])
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = rotation, -rotation @ eye
    if clip is None:
        clip = np.zeros((4, 4))
        clip[0, 0], clip[1, 1] = IMAGE[1] / IMAGE[0] / tan(HALF_FOV), 1 / tan(HALF_FOV)
        clip[2, 2:], clip[3, 2] = [-(far + near) / (far - near), -2 * far * near / (far - near)], -1.0
    return Camera(view, clip, near, far)


def ortho_at(eye, target, half_height: float = 4.0) -> Camera:
    """An orthographic camera at `eye` towards `target`."""
    clip = np.diag([1 / (half_height * IMAGE[0] / IMAGE[1]), 1 / half_height, -2 / 999.99, 1.0])
    clip[2, 3] = -1000.01 / 999.99
    return look_at(eye, target, clip=clip)


def corners(low, high) -> np.ndarray:
    """(8, 3) corners of a box."""
    return np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)], float)


def hull_of(rng: np.random.Generator) -> np.ndarray:
    """(8, 3) corners of a random box of sides 0.5…3 somewhere in the world."""
    centre, half = rng.uniform(-20, 20, 3), rng.uniform(0.25, 1.5, 3)
    return corners(centre - half, centre + half)


def direction(rng: np.random.Generator) -> np.ndarray:
    """A random unit vector that is not nearly vertical."""
    while True:
        d = rng.normal(size=3)
        d /= np.linalg.norm(d)
        if abs(d[2]) < 0.95:
            return d


def chosen(perspective: bool = True, texels_per_pixel: float = 1.0, **other) -> ImpostorSettings:
    """Settings of a capture, with one texel a pixel."""
    return ImpostorSettings(projection="perspective" if perspective else "orthographic", texels_per_pixel=texels_per_pixel, **other)


def capture_of(rng: np.random.Generator, hull: np.ndarray, perspective: bool) -> tuple[CaptureFrame, Camera]:
    """A frame and the camera that made it, 3…16 radii away, aiming a little beside the object."""
    radius = np.linalg.norm(np.ptp(hull, axis=0)) / 2
    eye = hull.mean(axis=0) + direction(rng) * radius * rng.uniform(3, 16)
    camera = look_at(eye, hull.mean(axis=0) + rng.uniform(-0.5, 0.5, 3) * radius)
    return capture_frame(hull, camera, IMAGE, chosen(perspective=perspective)), camera


def random_eye(rng: np.random.Generator, hull: np.ndarray, camera: Camera, ortho: bool) -> Camera:
    """A camera up to about 50° away from the capture's, at 3…16 radii."""
    centre = hull.mean(axis=0)
    radius = np.linalg.norm(np.ptp(hull, axis=0)) / 2
    towards = (camera.eye_ws - centre) / np.linalg.norm(camera.eye_ws - centre) + 0.5 * direction(rng) * rng.uniform(0, 1)
    eye = centre + towards / np.linalg.norm(towards) * radius * rng.uniform(3, 16)
    return ortho_at(eye, centre) if ortho else look_at(eye, centre + rng.uniform(-0.3, 0.3, 3) * radius)


def random_texels(rng: np.random.Generator, frame: CaptureFrame, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(uv (count, 2), relief (count,)) anywhere in the texture and its depth range."""
    depth = rng.uniform(0, 1, count) * frame.depth_m
    return rng.uniform(0, 1, (count, 2)) * [frame.width, frame.height], relief_from_depth(frame.source, depth)


def homography_of_quad(frame: CaptureFrame, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """(3, 3) H: homogeneous pixels from (u, v, 1) on the texture's plane."""
    return (pixel_from_clip(size) @ camera.clip_from_world @ frame.world_from_plane)[:, [0, 1, 3]]


def apply_homography(homography: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """(…, 2) pixels of plane points (…, 2); w must be positive."""
    image = np.asarray(uv, float) @ homography[:, :2].T + homography[:, 2]
    return image[..., :2] / image[..., 2:]


def project_texels(frame: CaptureFrame, camera: Camera, size: tuple[int, int], uv: np.ndarray, relief: np.ndarray) -> np.ndarray:
    """(…, 2) pixels: the direct projection of the texels' world points, without any warp. What `forward` + homography must equal."""
    points = frame.points_ws(uv, relief)
    rows = pixel_from_clip(size) @ camera.clip_from_world
    image = points @ rows[:, :3].T + rows[:, 3]
    return image[..., :2] / image[..., 2:]
