"""Foreign text (names in files, names of files) made fit to be shown: nothing in it moves a terminal's cursor or begins a line. No bpy."""

from __future__ import annotations

import re

# controls (with delete and C1), line and paragraph separators, marks that turn the direction of reading, halves of characters
_UNFIT = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
_UNFIT_BUT_LINES = re.compile(_UNFIT.pattern.replace("\x00-\x1f", "\x00-\x09\x0b-\x1f"))
LONGEST_NAME = 120


def shown(text: str) -> str:
    """One line of text, what is unfit as escapes: \\x1b."""
    return _UNFIT.sub(_escape, text)


def shown_lines(text: str) -> str:
    """The same, but line ends stay."""
    return _UNFIT_BUT_LINES.sub(_escape, text)


def shown_json(text: str) -> str:
    """JSON text whose strings hold nothing that is unfit, in JSON's own escapes; it says the same."""
    return _UNFIT_BUT_LINES.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def shown_name(text: str, most: int = LONGEST_NAME) -> str:
    """A foreign name within a sentence: one line, cut where it is longer than `most` characters."""
    line = shown(text)
    return line if len(line) <= most else f"{line[: most - 1]}…"


def _escape(match: re.Match[str]) -> str:
    code = ord(match[0])
    if 0xDC80 <= code <= 0xDCFF:
        return f"\\x{code - 0xDC00:02x}"  # a byte of a file's name that is no UTF-8
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
