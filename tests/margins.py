"""Comparisons that note how near a test came to its limit: `agree` and `at_most` assert, and `./dev sweep` writes docs/margins.md.

What is compared is named by its source.
"""

from __future__ import annotations

import ast
import linecache
import os
import sys
from dataclasses import dataclass
from types import FrameType

import numpy as np

LONGEST = 60  # of a source, in characters


@dataclass(frozen=True)
class Margin:
    """The worst seen: its share of what is allowed, and both as texts."""

    share: float
    asked: str
    worst: str


class Notes:
    """The worst of every comparison so far, by test and by what is compared; kept only when asked for."""

    def __init__(self) -> None:
        self.are_kept = False
        self.found: dict[tuple[str, str], Margin] = {}

    def note(self, compared: str, margin: Margin) -> None:
        key = os.environ["PYTEST_CURRENT_TEST"].rsplit(" ", 1)[0].split("[")[0], compared
        if key not in self.found or margin.share > self.found[key].share:
            self.found[key] = margin


notes = Notes()


def agree(seen, expected, rel: float = 0.0, abs: float = 0.0) -> None:
    """Assert |seen − expected| ≤ the larger of `abs` and `rel`·|expected|, everywhere; equal infinities agree."""
    seen, expected = np.broadcast_arrays(np.asarray(seen, float), np.asarray(expected, float))
    with np.errstate(all="ignore"):
        size = np.abs(expected)
        error = np.where(seen == expected, 0.0, np.abs(seen - expected))
        allowed = np.maximum(abs, np.where(size < np.inf, rel * size, 0.0))
        share = np.where(error == 0.0, 0.0, np.where(np.isnan(error), np.inf, error / allowed))
    if not share.size:
        return
    worst = np.unravel_index(share.argmax(), share.shape)
    if notes.are_kept:
        is_relative = rel * size[worst] > abs
        asked = " or ".join([f"{rel:g} relative"] * bool(rel > 0.0) + [f"{abs:g}"] * bool(abs > 0.0))
        found = f"{error[worst] / size[worst]:.2g} relative" if is_relative and error[worst] else f"{error[worst]:.2g}"
        notes.note(" is ".join(_arguments(sys._getframe(1))), Margin(float(share[worst]), asked, found))
    assert share[worst] <= 1.0, f"{seen[worst]!r} is not {expected[worst]!r} to {rel = }, {abs = } (at {worst} of {share.shape})"


def at_most(seen, limit) -> None:
    """Assert seen ≤ limit, everywhere; `limit` is positive."""
    seen, limit = np.broadcast_arrays(np.asarray(seen, float), np.asarray(limit, float))
    if not seen.size:
        return
    with np.errstate(all="ignore"):
        share = np.where(np.isnan(seen), np.inf, seen / limit)
    worst = np.unravel_index(share.argmax(), share.shape)
    if notes.are_kept:
        compared = " ≤ ".join(_arguments(sys._getframe(1)))
        notes.note(compared, Margin(float(share[worst]), f"{limit[worst]:.3g}", f"{seen[worst]:.2g}"))
    assert share[worst] <= 1.0, f"{seen[worst]!r} is above {limit[worst]!r} (at {worst} of {share.shape})"


def _arguments(frame: FrameType) -> list[str]:
    """The sources of the two numbers of the call that this frame is in the middle of, long ones cut short."""
    first, last, begin, end = list(frame.f_code.co_positions())[frame.f_lasti // 2]
    lines = [line.encode() for line in linecache.getlines(frame.f_code.co_filename)[first - 1 : last]]
    lines[-1] = lines[-1][:end]
    lines[0] = lines[0][begin:]
    sources = [ast.unparse(argument) for argument in ast.parse(b"".join(lines)).body[0].value.args[:2]]
    return [text if len(text) <= LONGEST else text[: LONGEST - 1] + "…" for text in sources]
