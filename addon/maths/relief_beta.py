"""Schaufler's angles, by which RI decides whether an impostor may still be shown as it is. No GPU.

A sprite shows every point X of the object at the place P on the plane where the *capture's own projection* put it. From the current eye
the error of X is the angle P-C-X. β is its maximum over the object's bounds; β_transP and β_transN are what the eye's motion parallel and
normal to the plane would cause alone (RI §5.3); β_screen = FOV/resolution is the angle of a pixel. An orthographic capture is off by β
even at its own eye, a perspective one by nothing. For an orthographic view, where directions have no vertex, the same quantities are
distances across the view in metres and β_screen is the size of a pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .relief import CaptureFrame, eye_in_plane
from .view import Camera


@dataclass(frozen=True, slots=True)
class Betas:
    """The angles in radians (metres for an orthographic view). `texel` is what one texel of the plane covers at the quad's centre."""

    screen: float
    trans_p: float
    trans_n: float
    total: float
    texel: float


def betas(frame: CaptureFrame, hull_ws: np.ndarray, camera: Camera, size: tuple[int, int]) -> Betas:
    """The angles for `camera` with an image of `size` (w, h) pixels; `hull_ws` (n, 3) bounds the object.

    Infinite where the eye does not stand before the plane.
    """
    points, on_plane = _true_and_shown(frame, hull_ws)
    eye, rest = eye_in_plane(frame, camera), frame.eye
    middle = np.array([*frame.centre_uv, 0.0])
    screen = beta_screen(camera, size)
    if not eye[2] < 0.0:
        return Betas(screen, np.inf, np.inf, np.inf, np.inf)
    total = _largest(frame, eye, points, on_plane)
    if eye[3] == 0.0 or rest[3] == 0.0:
        texel = frame.texel_m if eye[3] == 0.0 else frame.texel_m / _distance(frame, eye, middle)
        return Betas(screen, total, 0.0, total, texel)
    parallel, normal = np.array([*eye[:2], rest[2], 1.0]), np.array([*rest[:2], eye[2], 1.0])
    return Betas(
        screen,
        _largest(frame, parallel, points, on_plane),
        _largest(frame, normal, points, on_plane),
        total,
        frame.texel_m / _distance(frame, eye, middle),
    )


def beta_screen(camera: Camera, size: tuple[int, int]) -> float:
    """Schaufler's `FOV / resolution`, radians, the finer of the two axes; for an orthographic camera the side of a pixel, metres."""
    half = [abs(1.0 / float(camera.clip_from_view[axis, axis])) for axis in (0, 1)]
    if camera.is_orthographic:
        return min(2.0 * h / n for h, n in zip(half, size, strict=True))
    return min(2.0 * float(np.arctan(h)) / n for h, n in zip(half, size, strict=True))


def _true_and_shown(frame: CaptureFrame, hull_ws: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) the hull's points in plane coordinates and where the sprite shows them, on d = 0."""
    hull = np.asarray(hull_ws, float)
    plane = np.concatenate([hull, np.ones((len(hull), 1))], axis=1) @ frame.plane_from_world.T
    shown = np.column_stack([frame.texels(hull)[0], np.zeros(len(hull))])
    return plane[:, :3], shown


def _metres(frame: CaptureFrame) -> np.ndarray:
    """(3,) metres of one unit of u, v, d."""
    return np.array([frame.texel_m, frame.texel_m, 1.0])


def _distance(frame: CaptureFrame, eye: np.ndarray, point: np.ndarray) -> float:
    """Metres from a finite eye to a point, both in plane coordinates."""
    return float(np.linalg.norm((point - eye[:3]) * _metres(frame)))


def _largest(frame: CaptureFrame, eye: np.ndarray, points: np.ndarray, shown: np.ndarray) -> float:
    """Largest angle between `points` and `shown` (n, 3) from `eye`; largest distance across the view for an eye at infinity."""
    metres = _metres(frame)
    if eye[3] == 0.0:
        towards = eye[:3] * metres / np.linalg.norm(eye[:3] * metres)
        return float(np.linalg.norm(np.cross((points - shown) * metres, towards), axis=1).max())
    a, b = (points - eye[:3]) * metres, (shown - eye[:3]) * metres
    return float(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)).max())
