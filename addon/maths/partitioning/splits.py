"""The formulas of split distances: where the view is divided along its depth.

The schemes that choose among them have a module each, beside this one. Sources: T4 §4.3.2, LogPSM §5.1.7–5.1.8, method §4.
"""

from __future__ import annotations

from math import pi

import numpy as np


def log_splits(near: float, far: float, count: int) -> np.ndarray:
    """(count+1,) self-similar partitions, `n (f/n)^(i/k)` (T4 (50), LogPSM 5.53): the least S for light ⟂ view, and the least (54)."""
    return near * (far / near) ** (np.arange(count + 1) / count)


def linear_splits(near: float, far: float, count: int) -> np.ndarray:
    """(count+1,) partitions of equal depth (LogPSM 5.58)."""
    return near + (far - near) * (np.arange(count + 1) / count)


def pssm_splits(near: float, far: float, count: int, weight: float) -> np.ndarray:
    """(count+1,) `λ log + (1−λ) linear` (PSSM; LogPSM 5.60 is λ = 1/2)."""
    return weight * log_splits(near, far, count) + (1.0 - weight) * linear_splits(near, far, count)


def pseudo_near_splits(near: float, far: float, count: int, pseudo_near: float | None, weight: float) -> np.ndarray:
    """(count+1,) first partition [n, n_p], the others self-similar on [n_p, f] (ZP_np, LogPSM §5.1.8; 5.62–5.63 reconstructed).

    `pseudo_near` None takes PSSM's first split, as the text does. n_p is never taken below the first self-similar split (below it the
    scheme would only spend a map on nothing, and at that split it is T4 (50)), nor so near to f that the others collapse.
    """
    if count == 1:
        return np.array([near, far])
    ratio = far / near
    wanted = pssm_splits(near, far, count, weight)[1] if pseudo_near is None else pseudo_near
    first = min(max(wanted, near * ratio ** (1.0 / count)), far * ratio ** (-0.25 / count))
    return np.concatenate([[near], log_splits(first, far, count - 1)])


def adaptive_splits(near: float, far: float, count: int, gamma_rad: float, alpha: tuple[float, ...]) -> np.ndarray:
    """(count+1,) T4 (55): self-similar for light ⟂ view, ratios f_i/n_i = α_i for light ∥ view, mixed by λ = γ/(π/2) in between.

    `alpha` holds α₂, α₃, …; the last one serves all that follow. Each is limited to (f_i/n)^(1/(i−½)): where α_i^(i−½) > f_i/n the text's
    recursion would fall below n; limited so, the first partition keeps half the log share of the others, and the splits increase strictly.
    """
    weight = gamma_rad / (pi / 2.0)
    splits = np.empty(count + 1)
    splits[count], splits[0] = far, near
    for i in range(count, 1, -1):
        ratio = splits[i] / near
        alpha_i = min(alpha[min(i - 2, len(alpha) - 1)], ratio ** (1.0 / (i - 0.5)))
        splits[i - 1] = weight * near * ratio ** ((i - 1) / i) + (1.0 - weight) * splits[i] / alpha_i
    return splits
