"""Where the view is divided along its depth: the split distances of the scheme chosen.

Not here: the schemes themselves (`partitioning`), the side faces of the view frustum (`faces.py`).
"""

from __future__ import annotations

from math import inf, pi

import numpy as np

from ..choices import PartitionChoice, require
from ..partitioning.row import DividedView
from ..partitioning.splits import linear_splits


def split_distances(choice: PartitionChoice, near: float, far: float, gamma_rad: float, orthographic: bool = False) -> np.ndarray:
    """View depths that bound the z partitions: (z_count+1,) float64, strictly increasing, from `near` to `far` exactly.

    Always `choice.z_count` partitions, whatever the view, so that nothing pops while the camera moves (LogPSM §5.1.7.1).
    An orthographic camera sees every depth alike: its partitions are of equal depth. `gamma_rad` ∈ [0, π/2].
    Raises SettingsError unless 0 < near < far (near may be ≤ 0 when orthographic), or if the range is too thin to split.
    """
    positive = orthographic or near > 0.0
    require(-inf < near < far < inf and positive, "The near distance must be positive and smaller than the far distance.")
    require(0.0 <= gamma_rad <= pi / 2.0 + 1e-6, "γ must lie between 0 and 90 degrees.")
    if orthographic:
        splits = linear_splits(near, far, choice.z_count)
    else:
        gamma_rad = min(gamma_rad, pi / 2.0)
        view = DividedView(near, far, choice.z_count, gamma_rad, choice.split_weight, choice.pseudo_near, choice.seam_alphas)
        splits = choice.scheme.splits(view)
    splits[0], splits[-1] = near, far
    require(bool((np.diff(splits) > 0.0).all()), "Near and far are too close to be divided: use fewer partitions.")
    return splits
