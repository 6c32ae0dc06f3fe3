"""Slices of equal depth (LogPSM 5.58)."""

from .row import PartitionScheme
from .splits import linear_splits

ROW = PartitionScheme(
    name="z-linear",
    place=20,
    label="Linear",
    text="Slices of equal depth (LogPSM 5.58)",
    splits=lambda view: linear_splits(view.near, view.far, view.count),
    advised=(2, 4),
)
