"""The shadow tests: how a surface is compared with the shadow map. A module here for each, with its `ROW` (`row.py`)."""

from ...maths.tables import rows_of
from .row import ShadowTest

SHADOW_TESTS: dict[str, ShadowTest] = rows_of(__name__, __path__)
