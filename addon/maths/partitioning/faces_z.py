"""Faces, each in self-similar slices: faces keep their warp effective at every γ, so that T4 (50) stays best."""

from .row import PartitionScheme
from .splits import log_splits

ROW = PartitionScheme(
    name="faces-z",
    place=70,
    label="Faces × depth",
    text="One map per side of the view frustum and slice of depth",
    splits=lambda view: log_splits(view.near, view.far, view.count),
    has_faces=True,
    advised=(2, 3),
)
