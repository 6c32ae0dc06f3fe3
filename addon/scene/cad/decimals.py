"""Decimal numbers in text, all at once: a column of characters after the other, on arrays with an entry for each number.

Every result is the double that Python's `float` gives: a mantissa below 2⁵³ times or over a power of ten up to 10²² is rounded once (IEEE
754); all other words are left to `float` itself.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

BLANK, MOST_WIDTH, MOST_EXACT = 32, 32, float(1 << 53)
POWERS = 10.0 ** np.arange(23)
AT_ONCE, BYTES_AT_ONCE = 1 << 15, 1 << 18  # words, and bytes: what is worked on stays in the processor's cache


class Words:
    """The words of a text: `raw` its bytes with blanks before and behind, `starts` (N,) where each begins in them, `lengths` (N,)."""

    def __init__(self, text: bytes) -> None:
        self.raw = np.frombuffer(b"".join((b" ", text, b" " * (MOST_WIDTH + 1))), np.uint8)
        edges = np.concatenate([_edges(self.raw, at) for at in range(0, len(self.raw) - 1, BYTES_AT_ONCE)])
        self.starts, self.lengths = edges[0::2], edges[1::2] - edges[0::2]

    def are(self, word: bytes) -> np.ndarray:
        """(N,) bool: which of them are this word, in small letters or capitals."""
        found = np.flatnonzero(self.lengths == len(word))
        for k, letter in enumerate(word):
            found = found[self.raw[self.starts[found] + k] | 32 == letter]
        out = np.zeros(len(self.starts), bool)
        out[found] = True
        return out

    def numbers(self, chosen: np.ndarray | None = None) -> np.ndarray:
        """(M,) float64 the numbers that the words, or those of the given places, are. Raises `ValueError` where one is none."""
        starts, lengths = (self.starts, self.lengths) if chosen is None else (self.starts[chosen], self.lengths[chosen])
        out = np.empty(len(starts))
        for at in range(0, len(starts), AT_ONCE):
            rows = slice(at, at + AT_ONCE)
            out[rows] = self._read(starts[rows], lengths[rows])
        return out

    def _read(self, starts: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        width = min(int(lengths.max()), MOST_WIDTH)
        columns = np.ascontiguousarray(sliding_window_view(self.raw, width)[starts].T)
        values, is_sure = _values(columns, lengths)
        for row in np.flatnonzero(~is_sure):
            word = self.raw[starts[row] : starts[row] + lengths[row]].tobytes()
            if b"_" in word:  # which Python takes for nothing
                raise ValueError("something stands where a number should")
            values[row] = float(word)
        return values


def _edges(raw: np.ndarray, at: int) -> np.ndarray:
    """(N,) int64 where, in the block of bytes that begins there, words begin and end."""
    is_blank = raw[at : at + BYTES_AT_ONCE + 1] <= BLANK
    return np.flatnonzero(is_blank[1:] != is_blank[:-1]) + (at + 1)


def _values(columns: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N,) what words are whose characters stand in (W, N) columns, and whether that is sure."""
    count = columns.shape[1]
    mantissa, valid, digits, decimals, exponent = np.zeros(count), *(np.zeros(count, np.uint8) for _ in range(4))
    has_point, has_mark, is_small = (np.zeros(count, bool) for _ in range(3))
    signs = (columns[0] == ord("-")) | (columns[0] == ord("+"))
    is_word, valid[signs] = np.ones(count, bool), 1
    previous = columns[0]
    for column in columns:
        is_word &= column > BLANK
        digit = column - np.uint8(48)
        is_digit = (digit < 10) & is_word
        is_point = (column == ord(".")) & is_word & ~has_point & ~has_mark
        is_mark = ((column | 32) == ord("e")) & is_word & ~has_mark & (digits > 0)
        if has_mark.any():
            is_sign = has_mark & ((previous | 32) == ord("e")) & ((column == ord("-")) | (column == ord("+"))) & is_word
            is_small |= is_sign & (column == ord("-"))
            of_exponent = is_digit & has_mark
            exponent = np.where(of_exponent & (exponent < 25), exponent * np.uint8(10) + digit, exponent)
            valid += (of_exponent | is_sign).view(np.uint8)
            is_digit &= ~has_mark
        mantissa = np.where(is_digit, mantissa * 10.0 + digit, mantissa)
        digits += is_digit.view(np.uint8)
        decimals += (is_digit & has_point).view(np.uint8)
        valid += (is_digit | is_point | is_mark).view(np.uint8)
        has_point |= is_point
        has_mark |= is_mark
        previous = column
    power = np.where(is_small, -exponent.astype(np.int64), exponent) - decimals
    is_sure = (valid == lengths) & (digits > 0) & (mantissa < MOST_EXACT) & (np.abs(power) <= 22) & (exponent < 25)
    is_sure &= ~has_mark | ((_last(columns, lengths) - np.uint8(48)) < 10)
    factor = POWERS[np.minimum(np.abs(power), 22)]
    values = np.where(power < 0, mantissa / factor, mantissa * factor)
    return np.where(columns[0] == ord("-"), -values, values), is_sure


def _last(columns: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """(N,) the last character of each word."""
    return columns[np.minimum(lengths, len(columns)) - 1, np.arange(columns.shape[1])]
