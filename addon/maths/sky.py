"""How bright the sky is, direction by direction: the CIE's standard general sky (CIE S 011 / ISO 15469:2004). numpy only.

L(Z, χ) ∝ f(χ) φ(Z): gradation φ(Z) = 1 + a exp(b / cos Z) from zenith to horizon, indicatrix f(χ) = 1 + c (exp(d χ) − exp(d π/2)) +
e cos² χ round the sun, Z from the zenith, χ from the sun. Relative luminances here: normalised so that the sky lights a level ground as a
sky of luminance 1 everywhere does. Not here: colours, the sun's disc, turbidity.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from .domains import require_choice

LEAST_COSINE = 2e-3  # of the zenith angle in b / cos Z: below, φ is that of the horizon
RINGS, STEPS = 48, 96  # of the sum over the sky that normalises


@dataclass(frozen=True, slots=True)
class SkyType:
    """The five numbers of one of the CIE's skies."""

    a: float
    b: float
    c: float
    d: float
    e: float

    def relative(self, directions_ws: np.ndarray, sun_ws: np.ndarray) -> np.ndarray:
        """(N,) f φ in unit directions (N, 3) above the horizon, under a sun in direction (3,); not normalised."""
        cosine = np.clip(directions_ws @ sun_ws, -1.0, 1.0)
        gradation = 1.0 + self.a * np.exp(self.b / np.maximum(directions_ws[:, 2], LEAST_COSINE))
        from_sun = np.arccos(cosine)
        return gradation * (1.0 + self.c * (np.exp(self.d * from_sun) - np.exp(0.5 * pi * self.d)) + self.e * cosine**2)


SKY_TYPES = {
    "uniform": SkyType(0.0, -1.0, 0.0, -1.0, 0.0),  # type 5
    "overcast": SkyType(4.0, -0.7, 0.0, -1.0, 0.0),  # type 1: three times as bright at the zenith as at the horizon
    "cie": SkyType(-1.0, -0.32, 10.0, -3.0, 0.45),  # type 12: clear, low turbidity
}


def sky_luminance(kind: str, directions_ws: np.ndarray, sun_ws: np.ndarray) -> np.ndarray:
    """(N,) luminance of the sky of `SKY_TYPES` in unit directions (N, 3), 0 below the horizon; the sun's direction (3,), Z up.

    Claim: ∫ L cos Z dω over the upper half is π, as of L = 1. A sun below the horizon counts as one at it.
    """
    require_choice("Sky", kind, tuple(SKY_TYPES))
    sky, sun = SKY_TYPES[kind], np.array([*sun_ws[:2], max(float(sun_ws[2]), 0.0)])
    length = float(np.linalg.norm(sun))
    sun = sun / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    up = directions_ws[:, 2] > 0.0
    out = np.zeros(len(directions_ws))
    out[up] = sky.relative(directions_ws[up], sun) / _level_mean(sky, sun)
    return out


def _level_mean(sky: SkyType, sun_ws: np.ndarray) -> float:
    """∫ f φ cos Z dω / π: Gauss–Legendre over cos² Z, the azimuth in even steps."""
    nodes, weights = np.polynomial.legendre.leggauss(RINGS)
    z = np.sqrt(0.5 * (nodes + 1.0))
    turn = (np.arange(STEPS) + 0.5) * 2.0 * pi / STEPS
    flat = np.sqrt(1.0 - z * z)[:, None]
    over = np.stack(np.broadcast_arrays(flat * np.cos(turn), flat * np.sin(turn), z[:, None]), axis=-1).reshape(-1, 3)
    return float(sky.relative(over, sun_ws).reshape(RINGS, STEPS).mean(axis=1) @ weights) / 2.0
