"""Self-similar slices (T4 (50))."""

from .row import PartitionScheme
from .splits import log_splits

ROW = PartitionScheme(
    name="z-log",
    place=10,
    label="Logarithmic",
    text="Self-similar slices, each as many times longer as the one before (T4 (50))",
    splits=lambda view: log_splits(view.near, view.far, view.count),
    advised=(2, 3, 4, 6, 8),
)
