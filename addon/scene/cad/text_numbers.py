"""Numbers in text, read by numpy in one go."""

from __future__ import annotations

import warnings

import numpy as np


def numbers(text: bytes, dtype: type) -> np.ndarray:
    """All whitespace-separated numbers of `text`; raises `ValueError` when something else stands there."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # how numpy reports that it stopped half way
        try:
            return np.fromstring(text, dtype=dtype, sep=" ")
        except DeprecationWarning as warning:
            raise ValueError("something stands where a number should") from warning


def table(lines: list[bytes], columns: int) -> np.ndarray:
    """(N, ≥ columns) float64, a row per line; where lines differ in length only the first `columns` numbers are kept.

    A line that has fewer numbers, or something else, becomes a row of NaN.
    """
    if not lines:
        return np.empty((0, columns))
    even = _even_table(lines, columns)
    return even if even is not None else np.array([_row(line, columns) for line in lines])


def _even_table(lines: list[bytes], columns: int) -> np.ndarray | None:
    """All lines at once; None where they differ in length or hold something else than numbers, and so must be read one by one."""
    try:
        values = numbers(b" ".join(lines), np.float64)
    except ValueError:
        return None
    width = len(lines[0].split())
    is_even = len(values) == width * len(lines) and width >= columns and all(len(line.split()) == width for line in lines)
    return values.reshape(len(lines), width) if is_even else None


def _row(line: bytes, columns: int) -> list[float]:
    try:
        row = [float(word) for word in line.split()[:columns]]
    except ValueError:
        row = []
    return row if len(row) == columns else [np.nan] * columns
