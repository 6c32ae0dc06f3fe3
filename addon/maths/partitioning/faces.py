"""A map for each side of the view frustum (T4 §4.3.1)."""

from .row import PartitionScheme
from .splits import log_splits

ROW = PartitionScheme(
    name="faces",
    place=60,
    label="Faces",
    text="One map per side of the view frustum (T4 §4.3.1)",
    splits=lambda view: log_splits(view.near, view.far, view.count),
    divides_depth=False,
    has_faces=True,
)
