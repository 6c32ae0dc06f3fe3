"""Numbers in text, read by numpy in one go."""

from __future__ import annotations

import warnings

import numpy as np

from ...errors import CadFileError
from .decimals import Words

NEWLINE, BLANK = 10, 32
LONG = 1 << 14  # bytes, from which on the setting up of arrays pays


def numbers(text: bytes, dtype: type) -> np.ndarray:
    """All whitespace-separated numbers of `text`; raises `ValueError` when something else stands there."""
    if len(text) > LONG:
        values = Words(text).numbers()
        if np.issubdtype(dtype, np.integer) and not (np.isfinite(values).all() and (values == np.rint(values)).all()):
            raise ValueError("something stands where a whole number should")
        return values.astype(dtype, copy=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # how numpy reports that it stopped half way
        try:
            return np.fromstring(text, dtype=dtype, sep=" ")
        except DeprecationWarning as warning:
            raise ValueError("something stands where a number should") from warning


def with_points(text: bytes, file: str, warnings_: list[str]) -> bytes:
    """The text of numbers with decimal points for commas, where they can be meant so, and a line that says it.

    Raises `CadFileError` where there are both.
    """
    if b"," not in text:
        return text
    if b"." in text:
        raise CadFileError(f"{file} writes its numbers with commas and with points: export it with decimal points alone.")
    warnings_.append(f"{file} writes decimal commas (1,5 for 1.5), which its format does not know: they are read as points.")
    return text.replace(b",", b".")


def words_per_line(text: bytes) -> np.ndarray:
    """(L,) how many words each line of a text that ends with a newline has."""
    raw = np.frombuffer(text, np.uint8)
    return np.diff(np.searchsorted(word_begins(raw), np.flatnonzero(raw == NEWLINE)), prepend=0)


def word_begins(raw: np.ndarray) -> np.ndarray:
    """Where words begin in bytes."""
    is_blank = raw <= BLANK
    begins = ~is_blank
    begins[1:] &= is_blank[:-1]
    return np.flatnonzero(begins)


def table(text: bytes, columns: int) -> np.ndarray:
    """(N, ≥ columns) float64, a row per line of a text that ends with a newline; where lines differ in length only the first `columns`
    numbers are kept. A line that has fewer numbers, or something else, becomes a row of NaN."""
    if not text:
        return np.empty((0, columns))
    even = _even_table(text, columns)
    return even if even is not None else np.array([_row(line, columns) for line in text.split(b"\n")[:-1]])


def _even_table(text: bytes, columns: int) -> np.ndarray | None:
    """All lines at once; None where they differ in length or hold something else than numbers, and so must be read one by one."""
    counts = words_per_line(text)
    width = int(counts[0])
    if width < columns or not (counts == width).all():
        return None
    try:
        values = numbers(text, np.float64)
    except ValueError:
        return None
    return values.reshape(len(counts), width) if len(values) == width * len(counts) else None


def _row(line: bytes, columns: int) -> list[float]:
    try:
        row = [float(word) for word in line.split()[:columns]]
    except ValueError:
        row = []
    return row if len(row) == columns else [np.nan] * columns
