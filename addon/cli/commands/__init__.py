"""The commands. A module here for each, named after it, with its `ROW` (`command.py`)."""

from ...maths.tables import rows_of
from ..command import Command

COMMANDS: dict[str, Command] = rows_of(__name__, __path__)
