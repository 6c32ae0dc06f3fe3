"""Slices that follow the light's angle (T4 (55)); self-similar where no α is in effect."""

import numpy as np

from .row import DividedView, PartitionScheme
from .splits import adaptive_splits, log_splits


def splits(view: DividedView) -> np.ndarray:
    """T4 (55) with α, (50) without."""
    if view.alphas is None:
        return log_splits(view.near, view.far, view.count)
    return adaptive_splits(view.near, view.far, view.count, view.gamma_rad, view.alphas)


ROW = PartitionScheme(
    name="z-adaptive",
    place=50,
    label="Adaptive",
    text="Logarithmic; cut across the view, or with α by hand, geometric when the light runs along the view (T4 (55))",
    splits=splits,
    parts_spots=True,
    options=frozenset({"alpha"}),
    advised=(2, 3, 4, 6, 8),
)
