"""Points and matrices between spaces: homogeneous transforms and the camera matrices of OpenGL.

Matrices say target from source and act on column vectors; points are rows (CONVENTIONS.md). Nothing here knows of lights.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import tan

import numpy as np
from numpy.typing import ArrayLike

from .domains import require

Rows = Sequence[np.ndarray] | np.ndarray  # vectors (3, …) by component


def transform(target_from_source: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(…, 3) points through a 4×4 matrix → (…, 4) homogeneous points, float64; nothing is divided."""
    return np.asarray(points, np.float64) @ target_from_source[:, :3].T + target_from_source[:, 3]


def linear(matrix: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(R, N) a small matrix (R, C), or (N,) a row (C,) of one, times N columns (C, N).

    By numpy's own loops: a linear-algebra library would begin threads for it, and these cost many times what the product does.
    """
    return np.einsum("...c,cn->...n", matrix, columns)


def divide(points_h: np.ndarray) -> np.ndarray:
    """(…, 4) homogeneous → (…, 3). Domain: w ≠ 0."""
    return points_h[..., :3] / points_h[..., 3:]


def cross(a: Rows, b: Rows) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The components (…) of the cross products of vectors (3, …)."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def length(a: Rows) -> np.ndarray:
    """(…) of vectors (3, …)."""
    return np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def angle_between(a: Rows, b: Rows) -> np.ndarray:
    """(…) 0…π between vectors (3, …), exact for small angles too."""
    return np.arctan2(length(cross(a, b)), a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def translation(offset: np.ndarray) -> np.ndarray:
    """(4, 4) matrix that adds `offset` (3,)."""
    out = np.eye(4)
    out[:3, 3] = offset
    return out


def rotation(axis: ArrayLike, angle_rad: float, point: ArrayLike = (0.0, 0.0, 0.0)) -> np.ndarray:
    """(4, 4) rotation about the line through `point` (3,) along `axis` (3,), anticlockwise seen against it: Rodrigues' formula.

    Domain: `axis` not zero; its length does not matter.
    """
    along = np.asarray(axis, np.float64)
    x, y, z = along / np.linalg.norm(along)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    out = np.eye(4)
    out[:3, :3] += np.sin(angle_rad) * cross + (1.0 - np.cos(angle_rad)) * (cross @ cross)
    fixed = np.asarray(point, np.float64)
    out[:3, 3] = fixed - out[:3, :3] @ fixed
    return out


def look_at(eye_ws: np.ndarray, target_ws: np.ndarray, up_ws: ArrayLike = (0.0, 0.0, 1.0)) -> np.ndarray:
    """`view_from_world` of a camera at `eye_ws` that looks at `target_ws`.

    Where `up_ws` lies along the line of sight, world Y (or X) stands in for it, so that the result is always rigid.
    Raises `SettingsError` when eye and target coincide.
    """
    eye, forward = np.asarray(eye_ws, np.float64), np.subtract(target_ws, eye_ws, dtype=np.float64)
    length = float(np.linalg.norm(forward))
    require(0.0 < length < np.inf, "The camera's eye and target are the same point: move one of them.")
    forward /= length
    for up in np.array([np.asarray(up_ws, np.float64), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]):
        right = np.cross(forward, up)
        if np.linalg.norm(right) > 1e-6 * np.linalg.norm(up):
            break
    right /= np.linalg.norm(right)
    out = np.eye(4)
    out[:3, :3] = right, np.cross(right, forward), -forward
    out[:3, 3] = -out[:3, :3] @ eye
    return out


def with_depth_range(clip_from_view: np.ndarray, near: float, far: float, is_orthographic: bool) -> np.ndarray:
    """The projection (4, 4), its shift and sides kept, with OpenGL's exact rows of depth and w for view depths `near` to `far`.

    A projection made in float32 holds near/far to 1e-7 only: beyond that its far plane lies anywhere.
    """
    made = (orthographic if is_orthographic else perspective)(0.5, 1.0, near, far)
    return np.concatenate([clip_from_view[:2], made[2:]])


def perspective(half_fov_rad: float, aspect: float, near: float, far: float) -> np.ndarray:
    """OpenGL's `clip_from_view` for half the *vertical* field of view, aspect = width/height, near and far view depth."""
    out = np.zeros((4, 4))
    out[1, 1] = 1.0 / tan(half_fov_rad)
    out[0, 0] = out[1, 1] / aspect
    out[2, 2], out[2, 3] = (far + near) / (near - far), 2.0 * far * near / (near - far)
    out[3, 2] = -1.0
    return out


def orthographic(half_height: float, aspect: float, near: float, far: float) -> np.ndarray:
    """OpenGL's parallel `clip_from_view`: metres from the axis to the top edge, aspect = width/height."""
    out = np.eye(4)
    out[1, 1] = 1.0 / half_height
    out[0, 0] = out[1, 1] / aspect
    out[2, 2], out[2, 3] = 2.0 / (near - far), (far + near) / (near - far)
    return out


def smoothstep(x: float, start: float = 0.0, end: float = 1.0) -> float:
    """0 up to `start`, 1 from `end` on, a cubic between."""
    share = min(1.0, max(0.0, (x - start) / (end - start)))
    return share * share * (3.0 - 2.0 * share)
