"""Parallel-split shadow maps (LogPSM 5.60)."""

from .row import PartitionScheme
from .splits import pssm_splits

ROW = PartitionScheme(
    name="z-pssm",
    place=30,
    label="PSSM",
    text="A mean of logarithmic and linear slices (LogPSM 5.60)",
    splits=lambda view: pssm_splits(view.near, view.far, view.count, view.split_weight),
    options=frozenset({"split_weight"}),
    advised=(2, 3, 4, 6),
)
