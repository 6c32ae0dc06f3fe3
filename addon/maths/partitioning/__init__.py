"""The partition schemes: how the view is divided among shadow maps. A module here for each, with its `ROW` (`row.py`)."""

from ..tables import rows_of
from .row import PartitionScheme

PARTITION_SCHEMES: dict[str, PartitionScheme] = rows_of(__name__, __path__)
