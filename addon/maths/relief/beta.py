"""Schaufler's angles, by which RI decides whether an impostor may still be shown as it is. No GPU.

A sprite shows every point X of the object at the place P on the plane where the *capture's own projection* put it. From the current eye
the error of X is the angle P-C-X. β is its maximum over the object's bounds; β_transP and β_transN are what the eye's motion parallel and
normal to the plane would cause alone (RI §5.3); β_screen = FOV/resolution is the angle of a pixel. An orthographic capture is off by β
even at its own eye, a perspective one by nothing. For an orthographic view, where directions have no vertex, the same quantities are
distances across the view in metres and β_screen is the size of a pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..spaces import angle_between, cross, length
from ..view import Camera
from .warp import CaptureFrame


@dataclass(frozen=True, slots=True)
class Betas:
    """The angles in radians (metres for an orthographic view). `texel` is what one texel of the plane covers at the quad's centre."""

    screen: float
    trans_p: float
    trans_n: float
    total: float
    texel: float


@dataclass(frozen=True, eq=False)
class BoundsSet:
    """The bounds of T textures' objects as their planes see them, T last: what `betas_of_set` needs, gathered once.

    `points`, `shown` (3, n, T): the corners and where the sprite shows them, in metres along the plane's axes; `rest` (4, T) the eye at
    capture, `middle` (3, T) the quad's, likewise, and so is what `metres_from_world` (4, 4, T), transposed, leads to; `texel` (T,) metres.
    """

    metres_from_world: np.ndarray
    texel: np.ndarray
    rest: np.ndarray
    middle: np.ndarray
    points: np.ndarray
    shown: np.ndarray


def bounds_set(frames: Sequence[CaptureFrame], hulls_ws: Sequence[np.ndarray]) -> BoundsSet:
    """Stack textures; their hulls (n, 3) must have equally many points."""
    texel = np.array([f.texel_m for f in frames])
    metres = np.stack([texel, texel, np.ones_like(texel), np.ones_like(texel)])
    pairs = [_true_and_shown(f, hull) for f, hull in zip(frames, hulls_ws, strict=True)]
    points, shown = (np.stack([pair[i].T for pair in pairs], axis=-1) for i in (0, 1))
    return BoundsSet(
        metres * np.stack([f.plane_from_world.T for f in frames], axis=-1),
        texel,
        metres * np.stack([f.eye for f in frames], axis=-1),
        metres[:3] * np.stack([[*f.centre_uv, 0.0] for f in frames], axis=-1),
        metres[:3, None] * points,
        metres[:3, None] * shown,
    )


def betas_of_set(bounds: BoundsSet, camera: Camera, size: tuple[int, int]) -> tuple[list[Betas], np.ndarray]:
    """`betas` and (T,) tilts (the angle by which the view of each quad's centre has turned since its capture, 0…π) of all textures."""
    far = camera.is_orthographic
    eye_ws = np.append(-camera.direction_ws, 0.0) if far else np.append(camera.eye_ws, 1.0)
    rest, count = bounds.rest, len(bounds.texel)
    eye = (eye_ws @ bounds.metres_from_world.reshape(4, -1)).reshape(4, count)
    then, now = (e[:3] - e[3] * bounds.middle for e in (rest, eye))
    screen, before = beta_screen(camera, size), eye[2] < 0.0
    total = _largest(bounds, eye)
    parallel, normal = (np.stack([a[0], a[1], b[2], np.full(count, eye_ws[3])]) for a, b in ((eye, rest), (rest, eye)))
    both_near = (rest[3] != 0.0) & (not far)
    trans_p = np.where(both_near, _largest(bounds, parallel), total)
    trans_n = np.where(both_near, _largest(bounds, normal), 0.0)
    texel = bounds.texel / (1.0 if far else length(now))
    columns = [np.where(before, x, np.inf).tolist() for x in (trans_p, trans_n, total, texel)]
    return [Betas(screen, *values) for values in zip(*columns, strict=True)], angle_between(then, now)


def betas(frame: CaptureFrame, hull_ws: np.ndarray, camera: Camera, size: tuple[int, int]) -> Betas:
    """The angles for `camera` with an image of `size` (w, h) pixels; `hull_ws` (n, 3) bounds the object.

    Infinite where the eye does not stand before the plane.
    """
    return betas_of_set(bounds_set([frame], [hull_ws]), camera, size)[0][0]


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


def _largest(bounds: BoundsSet, eye: np.ndarray) -> np.ndarray:
    """(T,) largest angle between `points` and `shown` from `eye` (4, T); largest distance across the view for eyes at infinity."""
    if not eye[3].any():
        return length(cross(bounds.points - bounds.shown, (eye[:3] / length(eye[:3]))[:, None])).max(axis=0)
    return angle_between(bounds.points - eye[:3, None], bounds.shown - eye[:3, None]).max(axis=0)
