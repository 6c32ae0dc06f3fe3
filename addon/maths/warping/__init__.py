"""The warps: how the texels of a map are spread between near and far. A module here for each, with its `ROW` (`row.py`)."""

from ..tables import rows_of
from .row import WarpMethod

WARP_METHODS: dict[str, WarpMethod] = rows_of(__name__, __path__)
