"""From even points of the unit square or cube to points of what shines: a disc, a cap of the sky, a ball. numpy only."""

from __future__ import annotations

from functools import cache

import numpy as np

_STEPS = 512


def disc(points: np.ndarray) -> np.ndarray:
    """(K, 2) points of the unit disc, evenly spread, from (K, 2) of the unit square; the middle stays (Shirley and Chiu 1997)."""
    a, b = (2.0 * points[:, i] - 1.0 for i in (0, 1))
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    safe = np.where(radius == 0.0, 1.0, radius)
    angle = np.where(wide, 0.25 * np.pi * b / safe, 0.5 * np.pi - 0.25 * np.pi * a / safe)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def cap(points: np.ndarray, half_angle_rad: float) -> np.ndarray:
    """(K, 3) unit vectors evenly spread over the cap round +Z, from (K, 2) of the unit square: equal areas by Archimedes, 1 − z = ρ² h."""
    flat = disc(points)
    height = 2.0 * np.sin(0.5 * half_angle_rad) ** 2  # 1 − cos, without cancelling
    squared = np.einsum("ij,ij->i", flat, flat) * height
    return np.column_stack([flat * np.sqrt(height * (2.0 - squared))[:, None], 1.0 - squared])


def ball(points: np.ndarray) -> np.ndarray:
    """(K, 3) points of the unit ball that look like an evenly lit disc from every side, from (K, 3) of the unit cube.

    The density 1 / (π² √(1 − ρ²)) is the one whose projection on every plane is constant; with ρ = sin t its distribution over ρ is
    (2 t − sin 2 t) / π.
    """
    z = 2.0 * points[:, 0] - 1.0
    across = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    turn = 2.0 * np.pi * points[:, 1]
    radius = np.sin(np.interp(points[:, 2], *_ball_table()))
    return radius[:, None] * np.column_stack([across * np.cos(turn), across * np.sin(turn), z])


@cache
def _ball_table() -> tuple[np.ndarray, np.ndarray]:
    """The distribution over t, and t: dense near 0, where it grows with t³."""
    t = 0.5 * np.pi * np.linspace(0.0, 1.0, _STEPS) ** 2
    return (2.0 * t - np.sin(2.0 * t)) / np.pi, t


@np.errstate(under="ignore")  # products of nearly parallel axes: zero is what they mean
def axes_across(direction: np.ndarray) -> np.ndarray:
    """(3, 3) rows x, y, z of a right-handed system whose z is the unit `direction`."""
    first = np.eye(3)[np.abs(direction).argmin()]
    y = np.cross(direction, first)
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, direction), y, direction])
