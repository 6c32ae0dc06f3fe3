"""A slice of its own for what is nearer than shadows need be sharp (LogPSM §5.1.8)."""

from .row import PartitionScheme
from .splits import pseudo_near_splits

ROW = PartitionScheme(
    name="z-pseudo-near",
    place=40,
    label="Pseudo-near",
    text="A short first slice, logarithmic slices behind it (LogPSM §5.1.8)",
    splits=lambda view: pseudo_near_splits(view.near, view.far, view.count, view.pseudo_near, view.split_weight),
    options=frozenset({"pseudo_near"}),
    advised=(2, 3, 4),
)
