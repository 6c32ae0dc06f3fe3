"""The statements of a STEP file (ISO 10303-21): where each stands in the text, its arguments, its strings; and edits of the text."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator

import numpy as np

STATEMENT = re.compile(rb"#(\d+)\s*=\s*([A-Z0-9_]*)\s*((?>[^';/]++|'[^']*+'|/\*.*?\*/|/)*+);", re.DOTALL)
TOKEN = re.compile(rb"'(?:[^']|'')*'|/\*.*?\*/|[(),]|[^'(),/]+|/", re.DOTALL)
REFERENCE = re.compile(rb"'[^']*'|#(\d+)")
PLACE = re.compile(rb"CARTESIAN_POINT\s*\(\s*'[^']*'\s*,\s*\(([^()]*)\)")
ESCAPE = re.compile(r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\|\\X4\\((?:[0-9A-F]{8})*)\\X0\\|\\X\\([0-9A-F]{2})|\\S\\(.)|\\P[A-I]\\|\\\\|''")

Span = tuple[int, int]


class Statements:
    """The statements of `data` by number and by type. Complex ones, which have several types, are of type b''."""

    def __init__(self, data: bytes, wanted: frozenset[bytes]) -> None:
        self.data = data
        self.of_type: dict[bytes, list[int]] = {kind: [] for kind in wanted}
        numbers, kinds, starts, ends = [], [], [], []
        for match in STATEMENT.finditer(data):
            number, kind = int(match[1]), match[2]
            numbers.append(number)
            starts.append(match.start(3))
            ends.append(match.end(3))
            kinds.append(kind)
            if kind in self.of_type:
                self.of_type[kind].append(number)
        order = np.argsort(np.array(numbers, dtype=np.float64), kind="stable")
        self._numbers = [numbers[i] for i in order]
        self._spans = [(starts[i], ends[i]) for i in order]
        self._kinds = [kinds[i] for i in order]

    def __contains__(self, number: int) -> bool:
        return self._index(number) is not None

    def _index(self, number: int) -> int | None:
        i = bisect_left(self._numbers, number)
        return i if i < len(self._numbers) and self._numbers[i] == number else None

    def kind(self, number: int) -> bytes | None:
        """The type of a statement; None of one that is not there."""
        i = self._index(number)
        return None if i is None else self._kinds[i]

    def body(self, number: int) -> bytes:
        """The text of a statement from its bracket on; empty where it is not there."""
        i = self._index(number)
        return b"" if i is None else self.data[slice(*self._spans[i])]

    def spans(self, number: int) -> list[Span]:
        """Where the arguments of a statement of one type stand in the data."""
        i = self._index(number)
        return [] if i is None else list(_argument_spans(self.data, *self._spans[i]))

    def arguments(self, number: int) -> list[bytes]:
        """The arguments of a statement of one type, as written."""
        return [self.data[a:b].strip() for a, b in self.spans(number)]

    def references(self, number: int) -> list[int]:
        """The numbers of the statements that one names, in order."""
        return references(self.body(number))

    def reached(self, roots: list[int], stop: frozenset[bytes] = frozenset()) -> set[int]:
        """All statements named from some, directly or not, but nothing beyond those of the types to stop at."""
        seen, left = set(), list(roots)
        while left:
            number = left.pop()
            if number not in seen and number in self:
                seen.add(number)
                if self.kind(number) not in stop:
                    left += self.references(number)
        return seen


def _argument_spans(data: bytes, start: int, end: int) -> Iterator[Span]:
    depth, first = 0, start
    for token in TOKEN.finditer(data, start, end):
        mark = token[0]
        if mark == b"(":
            depth += 1
            first = token.end() if depth == 1 else first
        elif mark in b")," and len(mark) == 1:
            if depth == 1:
                yield first, token.start()
                first = token.end()
            depth -= mark == b")"


def references(text: bytes) -> list[int]:
    """The numbers behind # outside strings."""
    return [int(match[1]) for match in REFERENCE.finditer(text) if match[1]]


def text_of(argument: bytes) -> str:
    """A string argument as text, its escapes resolved (ISO 10303-21, 6.4.3); empty for anything else."""
    if not (argument.startswith(b"'") and argument.endswith(b"'") and len(argument) >= 2):
        return ""
    raw = re.sub(rb"[\r\n]", b"", argument[1:-1])
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("cp1252", "replace")
    return ESCAPE.sub(_character, text).strip()


def _character(match: re.Match[str]) -> str:
    if match[1] is not None:
        return bytes.fromhex(match[1]).decode("utf-16-be", "replace")
    if match[2] is not None:
        return bytes.fromhex(match[2]).decode("utf-32-be", "replace")
    if match[3] is not None:
        return chr(int(match[3], 16))
    if match[4] is not None:
        return chr((ord(match[4]) & 0x7F) + 0x80)
    return {"\\\\": "\\", "''": "'"}.get(match[0], "")


def numbers_of(argument: bytes) -> list[float]:
    """The numbers of a list of them."""
    return [float(word) for word in argument.strip().strip(b"()").split(b",") if word.strip()]


def farthest(data: bytes) -> float:
    """The largest coordinate of the file's points in space, in its own units; 0 without any."""
    texts = [match[1] for match in PLACE.finditer(data) if match[1].count(b",") == 2]
    try:
        values = np.array(b",".join(texts).split(b",") if texts else [], dtype=np.float64)
    except ValueError:
        return 0.0
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if len(finite) else 0.0


def edited(data: bytes, edits: list[tuple[int, int, bytes]]) -> bytes:
    """The data with spans replaced, which do not overlap."""
    out, at = [], 0
    for start, end, replacement in sorted(edits):
        out += [data[at:start], replacement]
        at = end
    return b"".join([*out, data[at:]])
