"""Points spread evenly: directions over the sphere, and places over a square. Deterministic, numpy only.

Sources: the spherical Fibonacci lattice (Keinert et al. 2015, Spherical Fibonacci Mapping, (1), (2)), whose discrepancy is about the least
known of its count; `low_discrepancy.kronecker`, any part of which is spread evenly too.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from .low_discrepancy import kronecker

GOLDEN = 0.5 * (1.0 + sqrt(5.0))


def sphere_directions(count: int) -> np.ndarray:
    """(count, 3) unit directions over the whole sphere, each for the same solid angle 4π / count, from the zenith down.

    Their heights are exact means of their rings (z = 1 − (2 i + 1) / count), so integrals of what depends on z alone are midpoint sums.
    None lies along a vertical or, for an even count, in the horizontal plane.
    """
    i = np.arange(count, dtype=np.float64)
    z = 1.0 - (2.0 * i + 1.0) / count
    turn = 2.0 * pi * ((i / GOLDEN) % 1.0)
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=-1)


def square_points(count: int, start: int = 0) -> np.ndarray:
    """(count, 2) places in [0, 1)², the terms of R2 from number `start` on."""
    return kronecker(np.arange(start + 1, start + count + 1), 2)


def places_on(corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(N, 3) places on triangles with `corners` (N, 3, 3), by the weights (N, 2) of their second and third corner."""
    a, b, c = (corners[:, k] for k in range(3))
    return a + weights[:, :1] * (b - a) + weights[:, 1:] * (c - a)


def triangle_points(square: np.ndarray) -> np.ndarray:
    """(N, 2) weights of a triangle's second and third corner, evenly over its area, of places in the square (N, 2): folded in half."""
    return np.where(square.sum(axis=1, keepdims=True) > 1.0, 1.0 - square, square)
