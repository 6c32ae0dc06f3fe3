"""The camera and the light as the method sees them: matrices, distances, angles. No GPU, no bpy."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from math import atan, cos, inf, pi
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from .choices import require
from .light_shapes import axes_across, ball, cap, disc
from .low_discrepancy import kronecker
from .spaces import rotation

LIGHT_KINDS = ("sun", "spot", "point")


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera: `view_from_world` is rigid, `clip_from_view` an OpenGL projection (perspective or orthographic, shift allowed).

    World coordinates are relative to the scene's local origin. `near` and `far` are view depths in metres.
    """

    view_from_world: np.ndarray
    clip_from_view: np.ndarray
    near: float
    far: float
    name: str = ""

    def __post_init__(self) -> None:
        require(
            bool(np.isfinite(self.view_from_world).all() and np.isfinite(self.clip_from_view).all()), "The camera's matrix is not finite."
        )
        require(
            0.0 < self.near < self.far < inf or (self.is_orthographic and self.near < self.far),
            "The camera's near distance must be positive and smaller than its far distance.",
        )

    @property
    def key(self) -> tuple:
        """What a picture depends on, comparable and hashable; the name is not part of it."""
        return self.view_from_world.tobytes(), self.clip_from_view.tobytes(), self.near, self.far

    @property
    def is_orthographic(self) -> bool:
        """True when all view rays are parallel."""
        return bool(self.clip_from_view[3, 3] == 1.0)

    @property
    def clip_from_world(self) -> np.ndarray:
        """(4, 4) float64."""
        return self.clip_from_view @ self.view_from_world

    @property
    def world_from_view(self) -> np.ndarray:
        """(4, 4) float64."""
        return np.linalg.inv(self.view_from_world)

    @property
    def eye_ws(self) -> np.ndarray:
        """(3,) position of the eye."""
        return self.world_from_view[:3, 3].copy()

    @property
    def direction_ws(self) -> np.ndarray:
        """(3,) unit view direction."""
        return -self.world_from_view[:3, 2].copy()

    @property
    def half_fov_rad(self) -> float:
        """φ, half the vertical field of view (0 for an orthographic camera)."""
        return 0.0 if self.is_orthographic else atan(1.0 / float(self.clip_from_view[1, 1]))

    def anchor_ws(self, view_depth: float) -> np.ndarray:
        """(3,) float64 that hold float32 numbers: the point of the view axis at that view depth, to count places from."""
        world_from_view = self.world_from_view
        return (world_from_view[:3, 3] - view_depth * world_from_view[:3, 2]).astype(np.float32).astype(np.float64)

    def moved_by(self, offset: ArrayLike) -> Camera:
        """The same camera in a world whose origin lies at `offset` (3,)."""
        view = self.view_from_world.copy()
        view[:3, 3] += view[:3, :3] @ np.asarray(offset, np.float64)
        return replace(self, view_from_world=view)

    def carried(self, point_ws: np.ndarray, angle_rad: float, axis_ws: ArrayLike = (0.0, 0.0, 1.0)) -> Camera:
        """The camera carried rigidly round the axis through a point, the vertical one unless told: anticlockwise seen against it."""
        return replace(self, view_from_world=self.view_from_world @ rotation(axis_ws, -angle_rad, point_ws))


@dataclass(frozen=True, eq=False)
class Light:
    """A light that casts shadows.

    `direction_ws` (3,) unit, towards the light (sun, and the axis of a spot, reversed travel); `position_ws` (3,) for spot and point.
    `cone_rad` is the half opening angle of a spot. `color` (3,) linear RGB times strength: where `is_physical` a sun's irradiance in W/m²,
    that of the others at 1 m; else relative to the settings' own sun. `casts` False: nothing stands in its way.
    `spread_rad`: of a panel, which shines by Lambert, narrowed to that half angle (π/2: not). A spot that is scaled unevenly has a cone of
    `local_cone_rad` after `local_from_world` (3, 3); `cone_rad` is then the widest half angle.
    What makes its shadows soft: `half_angle_rad` of a sun's disc; `radius` (metres) of a lamp; `half_axes_ws` (2, 3) of a panel, a
    rectangle, or an ellipse if it `is_round`.
    """

    kind: str = "sun"
    direction_ws: np.ndarray | None = None
    position_ws: np.ndarray | None = None
    cone_rad: float = 0.7853981633974483
    cone_blend: float = 0.15
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    name: str = ""
    is_physical: bool = False
    casts: bool = True
    spread_rad: float | None = None
    local_from_world: np.ndarray | None = None
    local_cone_rad: float = 0.0
    half_angle_rad: float = 0.0
    radius: float = 0.0
    half_axes_ws: np.ndarray | None = None
    is_round: bool = False

    def __post_init__(self) -> None:
        require(0.0 <= self.half_angle_rad <= pi / 2.0, "A sun's disc is 0° to 180° wide.")
        require(0.0 <= self.radius < inf, "A lamp's radius must be finite and not negative.")
        require(self.kind in LIGHT_KINDS, f"Light kind '{self.kind}' is not one of {', '.join(LIGHT_KINDS)}.")
        if self.kind != "point":
            d = self.direction_ws
            require(d is not None and bool(abs(float(np.dot(d, d)) - 1.0) < 1e-6), "The light's direction must be a unit vector.")
        if self.kind != "sun":
            require(self.position_ws is not None and bool(np.isfinite(self.position_ws).all()), "The light's position must be finite.")
        if self.kind == "spot":
            require(0.0 < self.cone_rad < 1.55, "The spot's half opening angle must lie between 0° and 88°.")

    def moved_by(self, offset: ArrayLike) -> Light:
        """The same light in a world whose origin lies at `offset` (3,)."""
        return self if self.position_ws is None else replace(self, position_ws=self.position_ws - np.asarray(offset, np.float64))

    @property
    def key(self) -> tuple:
        """What a picture depends on, comparable and hashable; the name is not part of it."""
        vectors = self.direction_ws, self.position_ws, self.local_from_world, self.half_axes_ws
        look = self.cone_rad, self.cone_blend, self.color, self.is_physical, self.casts, self.spread_rad, self.local_cone_rad
        shape = self.half_angle_rad, self.radius, self.is_round
        return self.kind, *(None if v is None else np.asarray(v, np.float64).tobytes() for v in vectors), *look, *shape

    @property
    def shadow_key(self) -> tuple:
        """What its shadows depend on: all but its colour."""
        return replace(self, color=(1.0, 1.0, 1.0)).key

    @property
    def is_soft(self) -> bool:
        """Whether it has a size, so that its shadows have soft edges."""
        return self.half_angle_rad > 0.0 if self.kind == "sun" else self.radius > 0.0 or self.half_axes_ws is not None

    @property
    def hard(self) -> Light:
        """The same light from its middle alone."""
        return replace(self, half_angle_rad=0.0, radius=0.0, half_axes_ws=None)

    def softened(self, factor: float) -> Light:
        """The same light, so many times as large."""
        axes = None if self.half_axes_ws is None or factor == 0.0 else self.half_axes_ws * factor
        half_angle = min(self.half_angle_rad * factor, pi / 2.0)
        return replace(self, half_angle_rad=half_angle, radius=self.radius * factor, half_axes_ws=axes)

    def sample(self, index: int) -> Light:
        """The hard light number `index` of those whose mean this light is; samples that follow each other are spread evenly over it.

        A sun's are spread evenly over its cap of half angle a and are 2 / (1 + cos a) times as strong, so that together they give a
        surface that faces the sun its irradiance. A lamp's look like a disc from every side; a panel's lie on it.
        """
        hard = self.hard
        if self.kind == "sun" and self.direction_ws is not None and self.half_angle_rad > 0.0:
            away = cap(kronecker([index], 2), self.half_angle_rad)[0] @ axes_across(self.direction_ws)
            brighter = 2.0 / (1.0 + cos(self.half_angle_rad))
            red, green, blue = (c * brighter for c in self.color)
            return replace(hard, direction_ws=away / np.linalg.norm(away), color=(red, green, blue))
        if self.half_axes_ws is not None:
            place = kronecker([index], 2)
            place = disc(place) if self.is_round else 2.0 * place - 1.0
            return replace(hard, position_ws=self.position_ws + place[0] @ self.half_axes_ws)
        if self.radius > 0.0:
            return replace(hard, position_ws=self.position_ws + self.radius * ball(kronecker([index], 3))[0])
        return hard

    def lights_towards(self, towards_ws: np.ndarray) -> np.ndarray:
        """(K,) bool: whether it shines on points from which it lies in the unit directions (K, 3): within a spot's cone."""
        if self.kind != "spot":
            return np.ones(len(towards_ws), dtype=bool)
        if self.local_from_world is None:
            return towards_ws @ self.direction_ws > np.cos(self.cone_rad)
        local = towards_ws @ self.local_from_world.T
        return local[:, 2] > np.cos(self.local_cone_rad) * np.linalg.norm(local, axis=1)


class LightSource(Protocol):
    """What lights a picture: a `Light`, or anything else that is the mean of hard ones (a sky)."""

    @property
    def name(self) -> str:
        """What it is called in reports."""

    @property
    def kind(self) -> str:
        """What it is in reports."""

    @property
    def key(self) -> Hashable:
        """What a picture depends on: equal keys, equal light."""

    @property
    def is_soft(self) -> bool:
        """Whether its samples differ."""

    def sample(self, index: int) -> Light:
        """One of the hard lights whose mean it is; consecutive ones are spread evenly over it."""


def gamma_rad(light_direction_ws: np.ndarray, view_direction_ws: np.ndarray) -> float:
    """γ ∈ [0, π/2]: the smaller angle between the light's and the view's line (T4 §4.2.2). Stable at both ends (atan2)."""
    cross = np.linalg.norm(np.cross(light_direction_ws, view_direction_ws))
    return float(np.arctan2(cross, abs(np.dot(light_direction_ws, view_direction_ws))))
