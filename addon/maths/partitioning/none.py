"""One map."""

from .row import PartitionScheme
from .splits import log_splits

ROW = PartitionScheme(
    name="none",
    place=0,
    label="One map",
    text="The whole view in a single shadow map",
    splits=lambda view: log_splits(view.near, view.far, view.count),
    divides_depth=False,
)
