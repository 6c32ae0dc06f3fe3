"""The warp of a relief texture: where a texel of a captured image falls when the eye has moved. No GPU.

One projective rule serves both kinds of capture. The texture's plane has coordinates (u, v, d): u, v texels (centres at half integers,
v downwards), d metres behind the plane, away from the capturing eye. A texel (u, v) with *relief* δ stands for the point
`(u, v, 0, 1) + δ·S`, where S is the capture's centre of projection in plane coordinates: `(0, 0, 1, 0)` for an orthographic capture
(then δ = d) and `(s_u, s_v, s_d, 1)` for a perspective one (then δ = γ = (z₀ − z)/z ≤ 0, z₀ the plane's and z the point's view depth).

Sources: Oliveira 2000 through RI 5-2…5-4; the perspective source is our own (method §7).
What is not here: the prediction of errors (`error.py`), the frame's construction (`frame.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...errors import SceneError
from ..view import Camera

ORTHOGRAPHIC_SOURCE = np.array([0.0, 0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class CaptureFrame:
    """The textured quad of an impostor and the projection that captured it.

    `world_from_plane` (4, 4): columns a, b (the world vectors of one texel, square and perpendicular), f (unit normal, away from the
    eye), C₀ (corner of texel 0, 0). `source` (4,) the centre of projection S in plane coordinates. `eye` (4,) the capturing camera's eye in
    plane coordinates (last component 0: a direction, towards the eye). `width`, `height` texels; `depth_m` from the plane, which touches
    the front of the bounds, to their back.
    """

    world_from_plane: np.ndarray
    source: np.ndarray
    eye: np.ndarray
    width: int
    height: int
    depth_m: float

    @property
    def is_perspective(self) -> bool:
        """True when the capture's rays meet in an eye."""
        return bool(self.source[3] != 0.0)

    @cached_property
    def texel_m(self) -> float:
        """Side of a texel on the plane, metres."""
        return float(np.linalg.norm(self.world_from_plane[:3, 0]))

    @cached_property
    def plane_from_world(self) -> np.ndarray:
        """(4, 4) inverse of `world_from_plane`."""
        return np.linalg.inv(self.world_from_plane)

    @property
    def centre_uv(self) -> np.ndarray:
        """(2,) the middle of the quad, texels."""
        return np.array([self.width / 2.0, self.height / 2.0])

    @property
    def deepest_relief(self) -> float:
        """δ of the back of the bounds."""
        return float(relief_from_depth(self.source, self.depth_m))

    def camera(self) -> Camera:
        """The camera whose image of `width` × `height` pixels is this texture: pixel centres are texel centres.

        Clip depth −1…+1 runs from a little before the plane to a little behind the bounds.
        """
        axes = self.world_from_plane[:3, :3] / np.linalg.norm(self.world_from_plane[:3, :3], axis=0)
        rotation = np.stack([axes[:, 0], -axes[:, 1], -axes[:, 2]])
        pad = 1e-3 * max(self.depth_m, self.texel_m)
        size = np.array([self.width, self.height])
        if self.is_perspective:
            distance = -float(self.source[2])
            eye_ws = (self.world_from_plane @ self.source)[:3]
            near, far = distance - min(pad, 0.5 * distance), distance + self.depth_m + pad
            corners = (np.array([[0.0, self.height], [self.width, 0.0]]) - self.source[:2]) * [self.texel_m, -self.texel_m]
            clip = _perspective(corners * near / distance, near, far)
        else:
            eye_ws = (self.world_from_plane @ [*self.centre_uv, 0.0, 1.0])[:3]
            near, far = -pad, self.depth_m + pad
            clip = _orthographic(size * self.texel_m, near, far)
        view = np.eye(4)
        view[:3, :3], view[:3, 3] = rotation, -rotation @ eye_ws
        return Camera(view, clip, near, far, name="capture")

    def points_ws(self, uv: np.ndarray, relief: np.ndarray) -> np.ndarray:
        """(…, 3) world points of texels `uv` (…, 2) with relief δ (…)."""
        plane = _plane_points(self.source, np.asarray(uv, float), np.asarray(relief, float))
        world = plane @ self.world_from_plane.T
        return world[..., :3] / world[..., 3:]

    def texels(self, points_ws: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Inverse of `points_ws`: (uv (…, 2), relief (…)) under which the capture sees world points (…, 3)."""
        points = np.asarray(points_ws, float)
        plane = np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1) @ self.plane_from_world.T
        relief = relief_from_depth(self.source, plane[..., 2])
        return plane[..., :2] * (1.0 + self.source[3] * relief)[..., None] - relief[..., None] * self.source[:2], relief


def relief_from_depth(source: np.ndarray, depth_m: np.ndarray | float) -> np.ndarray:
    """δ of a point `depth_m` behind the plane: d for an orthographic source, γ = (z₀ − z)/z = d/(s_d − d) for a perspective one."""
    depth = np.asarray(depth_m, float)
    return depth / (source[..., 2] - source[..., 3] * depth)


def depth_from_relief(source: np.ndarray, relief: np.ndarray | float) -> np.ndarray:
    """Metres behind the plane: `d = δ·s_d / (1 + δ·s_w)`, the inverse of `relief_from_depth`."""
    delta = np.asarray(relief, float)
    return delta * source[..., 2] / (1.0 + delta * source[..., 3])


def shift_unit(frame: CaptureFrame) -> float:
    """The relief step of a depth of one texel at the plane: makes a shift (texels per unit of relief) a tangent."""
    return frame.texel_m / abs(float(frame.source[2]))


def eye_in_plane(frame: CaptureFrame, camera: Camera) -> np.ndarray:
    """(4,) the camera's eye in homogeneous plane coordinates; an orthographic camera's is a direction (last component 0)."""
    eye_ws = np.append(-camera.direction_ws, 0.0) if camera.is_orthographic else np.append(camera.eye_ws, 1.0)
    return frame.plane_from_world @ eye_ws


@dataclass(frozen=True, eq=False)
class ReliefWarp:
    """The warp in the texture's plane, `u_i = (u + K₁δ)/(1 + K₃δ)`, v_i likewise with K₂; after it the quad's homography shows it.

    `k` (3,): Oliveira's k₁, k₂, k₃, which belong to an orthographic source: `−(e_u, e_v, e_w)/e_d` with the eye e in plane coordinates
    (k₃ = 0 for an orthographic view). `K` (3,): `(s_u + k₁s_d, s_v + k₂s_d, s_w + k₃s_d)`, equal to k for an orthographic source and zero,
    the identity, at a perspective capture's own eye. The epipole, the warp's fixed point, is (K₁/K₃, K₂/K₃), at infinity when K₃ = 0.
    """

    k: np.ndarray
    K: np.ndarray

    def scale(self, relief: np.ndarray) -> np.ndarray:
        """s(δ) = 1/(1 + K₃δ): `p_i = e + s·(p − e)`, a radial scaling about the epipole."""
        return 1.0 / (1.0 + self.K[2] * np.asarray(relief, float))

    def forward(self, uv: np.ndarray, relief: np.ndarray) -> np.ndarray:
        """(…, 2) warped texel coordinates of texels `uv` (…, 2) with relief δ (…)."""
        delta = np.asarray(relief, float)[..., None]
        return (np.asarray(uv, float) + self.K[:2] * delta) / (1.0 + self.K[2] * delta)

    def inverse(self, warped_uv: np.ndarray, relief: np.ndarray) -> np.ndarray:
        """(…, 2) texels that the view ray through `warped_uv` crosses at relief δ; linear in δ: the ray is straight in (u, v, δ)."""
        delta = np.asarray(relief, float)[..., None]
        uv = np.asarray(warped_uv, float)
        return uv + delta * (uv * self.K[2] - self.K[:2])


def relief_warp(frame: CaptureFrame, camera: Camera) -> ReliefWarp:
    """The warp of `frame`'s texture for `camera`; raises `SceneError` when the eye does not stand before the texture's plane."""
    k, big_k = warp_coefficients(frame.source, eye_in_plane(frame, camera))
    return ReliefWarp(k, big_k)


def warp_coefficients(source: np.ndarray, eye: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, K), each (…, 3), from homogeneous plane coordinates (…, 4) of the source's centre and of the eye (see `ReliefWarp`)."""
    if not np.all(eye[..., 2] < 0.0):
        raise SceneError("The camera does not stand before the impostor's plane: draw the geometry, or regenerate the impostor from here.")
    k = -eye[..., [0, 1, 3]] / eye[..., 2:3]
    return k, source[..., [0, 1, 3]] + k * source[..., 2:3]


def pixel_from_clip(size: tuple[int, int]) -> np.ndarray:
    """(3, 4) from clip coordinates to homogeneous pixels of an image (width, height), y downwards."""
    half_w, half_h = size[0] / 2.0, size[1] / 2.0
    return np.array([[half_w, 0.0, 0.0, half_w], [0.0, -half_h, 0.0, half_h], [0.0, 0.0, 0.0, 1.0]])


def _plane_points(source: np.ndarray, uv: np.ndarray, relief: np.ndarray) -> np.ndarray:
    """(…, 4) homogeneous plane coordinates `(u, v, 0, 1) + δ·S`."""
    flat = np.concatenate([uv, np.zeros((*uv.shape[:-1], 1)), np.ones((*uv.shape[:-1], 1))], axis=-1)
    return flat + relief[..., None] * source


def _perspective(corners_m: np.ndarray, near: float, far: float) -> np.ndarray:
    """OpenGL frustum through `corners_m` ((left, bottom), (right, top)) on the near plane."""
    (left, bottom), (right, top) = corners_m
    return np.array(
        [
            [2 * near / (right - left), 0.0, (right + left) / (right - left), 0.0],
            [0.0, 2 * near / (top - bottom), (top + bottom) / (top - bottom), 0.0],
            [0.0, 0.0, -(far + near) / (far - near), -2 * far * near / (far - near)],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )


def _orthographic(size_m: np.ndarray, near: float, far: float) -> np.ndarray:
    """OpenGL orthographic projection of a box of `size_m` (width, height) centred on the axis."""
    clip = np.diag([2 / size_m[0], 2 / size_m[1], -2 / (far - near), 1.0])
    clip[2, 3] = -(far + near) / (far - near)
    return clip
