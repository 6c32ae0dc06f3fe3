"""The table of file formats: a row for each module of this folder that has a `ROW`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...maths.tables import rows_of
from .cad_format import CadFormat

FORMATS: dict[str, CadFormat] = rows_of(__package__, [str(Path(__file__).parent)])
BY_SUFFIX = {suffix: row for row in FORMATS.values() for suffix in row.suffixes}
SUFFIXES = tuple(BY_SUFFIX)


def said(names: Sequence[str] = tuple(FORMATS), last: str = ", ") -> str:
    """Names in a sentence: 'STL, OBJ and PLY' with ' and ' before the last."""
    *first, end = names
    return last.join([", ".join(first), end]) if first else end
