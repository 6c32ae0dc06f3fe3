"""Points that fill a square or a cube evenly at every count: the samples of lights. No randomness: every machine has the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

START = 0.5


def generalised_golden_ratio(dimensions: int) -> float:
    """The positive root φ_d of x^(d+1) = x + 1: 1.618… for d = 1, 1.3247… for d = 2, 1.2207… for d = 3 (Roberts 2018)."""
    root = 1.5
    for _ in range(64):  # x ← (1 + x)^(1/(d+1)) contracts by less than 1/2 a step
        root = (1.0 + root) ** (1.0 / (dimensions + 1))
    return root


def kronecker(indices: ArrayLike, dimensions: int) -> np.ndarray:
    """(K, d) points in [0, 1)^d: frac(1/2 + n α), α_j = φ_d^−j (Roberts' R_d, a Kronecker sequence).

    Point n depends on n alone, so that more points can be added to those there are; point 0 is the middle. Every run of consecutive
    points is as evenly spread as the first ones.
    """
    steps = generalised_golden_ratio(dimensions) ** -np.arange(1.0, dimensions + 1.0)
    return (START + np.asarray(indices, np.float64)[..., None] * steps) % 1.0
