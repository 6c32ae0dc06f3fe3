"""Where the view is divided along its depth: the split distances of every scheme of the texts.

Not here: the side faces of the view frustum (`faces.py`). Sources: T4 §4.3.2, LogPSM §5.1.7–5.1.8, method §4.
"""

from __future__ import annotations

from math import inf, pi

import numpy as np

from ..choices import PartitionChoice, require


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


def split_distances(choice: PartitionChoice, near: float, far: float, gamma_rad: float, orthographic: bool = False) -> np.ndarray:
    """View depths that bound the z partitions: (z_count+1,) float64, strictly increasing, from `near` to `far` exactly.

    Always `choice.z_count` partitions, whatever the view, so that nothing pops while the camera moves (LogPSM §5.1.7.1).
    'faces-z' is self-similar at every γ: faces keep their warp effective, so that (50) stays best. An orthographic camera sees every depth
    alike: its partitions are of equal depth. `gamma_rad` ∈ [0, π/2] matters to 'z-adaptive' with α only.
    Raises SettingsError unless 0 < near < far (near may be ≤ 0 when orthographic), or if the range is too thin to split.
    """
    positive = orthographic or near > 0.0
    require(-inf < near < far < inf and positive, "The near distance must be positive and smaller than the far distance.")
    require(0.0 <= gamma_rad <= pi / 2.0 + 1e-6, "γ must lie between 0 and 90 degrees.")
    count = choice.z_count
    if orthographic or choice.kind == "z-linear":
        splits = linear_splits(near, far, count)
    elif choice.kind == "z-pssm":
        splits = pssm_splits(near, far, count, choice.split_weight)
    elif choice.kind == "z-pseudo-near":
        splits = pseudo_near_splits(near, far, count, choice.pseudo_near, choice.split_weight)
    elif choice.kind == "z-adaptive" and choice.seam_alphas is not None:
        splits = adaptive_splits(near, far, count, min(gamma_rad, pi / 2.0), choice.seam_alphas)
    else:
        splits = log_splits(near, far, count)
    splits[0], splits[-1] = near, far
    require(bool((np.diff(splits) > 0.0).all()), "Near and far are too close to be divided: use fewer partitions.")
    return splits
