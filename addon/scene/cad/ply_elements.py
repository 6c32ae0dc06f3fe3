"""The elements of a PLY file as columns: text and binary of either byte order, lists of any lengths, whatever elements there are.

Text becomes numbers of 64 bits first, and then is read as the binary form is. Source: G. Turk, "The PLY Polygon File Format", 1994.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from .text_numbers import numbers

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST_HEADER = 1 << 20
_STRUCTS = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}


@dataclass(frozen=True)
class Property:
    """`kind` the numpy type as kept; of a list, that of its items, and `count_kind` that of their number. `declared` the header's."""

    name: str
    kind: str
    declared: str
    count_kind: str | None = None


@dataclass
class Element:
    """A header's element: how many rows of which properties."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)

    @property
    def least_row(self) -> int:
        """Bytes of a row whose lists are all empty."""
        return sum(np.dtype(p.count_kind or p.kind).itemsize for p in self.properties)


@dataclass(frozen=True, eq=False)
class Lists:
    """A list property of all rows: `sizes` (N,), and the `values` of all, one after the other."""

    sizes: np.ndarray
    values: np.ndarray


Columns = dict[str, np.ndarray | Lists]


def ply_elements(data: bytes) -> dict[str, Columns]:
    """The columns of every element by the names of both. Raises `ValueError` for what is no whole PLY file."""
    order, elements, at = _header(data)
    body, is_text = memoryview(data)[at:], b"ascii" in data[:at].split(b"format", 1)[1].split()[0]
    if is_text:
        body = memoryview(numbers(bytes(body), np.float64).astype("<f8").tobytes())
        elements = [_of_doubles(element) for element in elements]
    found, at = {}, 0
    for element in elements:
        if element.count * element.least_row > len(body) - at:
            raise ValueError(f"{element.count} rows of {element.name} are announced, but the file ends before")
        try:
            columns, at = _columns(element, body, at, order)
        except struct.error as error:
            raise ValueError(f"the file ends within its {element.name}") from error
        found[element.name] = {p.name: _declared(columns[p.name], p.declared) for p in element.properties} if is_text else columns
    return found


def _declared(column: np.ndarray | Lists, kind: str) -> np.ndarray | Lists:
    """A column of text as the header's type, which colours are told apart by; lists of indices stay."""
    if isinstance(column, Lists) or kind[0] == "f":
        return column
    limits = np.iinfo(kind)
    return np.clip(np.nan_to_num(column), limits.min, limits.max).astype(kind)


def _header(data: bytes) -> tuple[str, list[Element], int]:
    end = re.search(rb"end_header[ \t]*(\r\n|\n|\r)", data[:LONGEST_HEADER])
    if end is None:
        raise ValueError("its header has no end")
    order, elements = None, []
    for line in data[: end.start()].decode("latin-1").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            order = ORDERS[words[1]]
        elif words[:1] == ["element"]:
            elements.append(Element(words[1], int(words[2])))
        elif words[:2] == ["property", "list"]:
            elements[-1].properties.append(Property(words[4], TYPES[words[3]], TYPES[words[3]], TYPES[words[2]]))
        elif words[:1] == ["property"]:
            elements[-1].properties.append(Property(words[2], TYPES[words[1]], TYPES[words[1]]))
    if order is None or any(element.count < 0 for element in elements):
        raise ValueError("its header says nothing of the format, or a negative number of rows")
    return order, elements, end.end()


def _of_doubles(element: Element) -> Element:
    """The element as the numbers of its text are kept."""
    return Element(element.name, element.count, [Property(p.name, "f8", p.declared, p.count_kind and "f8") for p in element.properties])


def _columns(element: Element, body: memoryview, at: int, order: str) -> tuple[Columns, int]:
    """The element's columns, and where it ends. Rows that are all as long as the first are read at once."""
    if not element.count or not element.properties:
        nothing = np.zeros(0, np.int64)
        return {p.name: Lists(nothing, nothing) if p.count_kind else nothing for p in element.properties}, at
    sizes = [size for _, size, _ in _lists(element, body, at, order)]
    fields: list[tuple] = []
    names = iter(sizes)
    for i, p in enumerate(element.properties):
        if p.count_kind is not None:
            fields.append((f"n{i}", order + p.count_kind))
            fields.append((f"p{i}", order + p.kind, (next(names),)))
        else:
            fields.append((f"p{i}", order + p.kind))
    row = np.dtype(fields)
    if row.itemsize * element.count <= len(body) - at:
        rows = np.frombuffer(body, row, element.count, at)
        if all((rows[f"n{i}"] == rows[f"n{i}"][0]).all() for i, p in enumerate(element.properties) if p.count_kind):
            return _even_columns(element, rows), at + rows.nbytes
    return _uneven_columns(element, body, at, order)


def _even_columns(element: Element, rows: np.ndarray) -> Columns:
    columns: Columns = {}
    for i, p in enumerate(element.properties):
        own = rows[f"p{i}"]
        columns[p.name] = own if p.count_kind is None else Lists(np.full(len(own), own.shape[1], np.int64), own.reshape(-1))
    return columns


def _lists(element: Element, body: memoryview, at: int, order: str) -> Iterator[tuple[int, int, int]]:
    """Of one row that starts at `at`: (where the items start, how many, where what follows starts) of each list, in order."""
    for p in element.properties:
        if p.count_kind is None:
            at += np.dtype(p.kind).itemsize
            continue
        count = struct.unpack_from(order + _STRUCTS[p.count_kind], body, at)[0]
        start = at + np.dtype(p.count_kind).itemsize
        if not 0 <= count <= len(body) - start:
            raise ValueError(f"a list of {count} items is longer than the file")
        at = start + int(count) * np.dtype(p.kind).itemsize
        yield start, int(count), at


def _uneven_columns(element: Element, body: memoryview, at: int, order: str) -> tuple[Columns, int]:
    """The same for rows of different lengths: a walk over them finds where everything starts, then all is gathered at once."""
    starts, counts = _walked(element, body, at, order)
    end = int(starts[-1, -1])
    if end > len(body):
        raise ValueError(f"the file ends within its {element.name}")
    raw = np.frombuffer(body, np.uint8)
    columns: Columns = {}
    for i, p in enumerate(element.properties):
        size = np.dtype(p.kind).itemsize
        if p.count_kind is None:
            columns[p.name] = _gathered(raw, starts[:, i], size).view(order + p.kind).ravel()
            continue
        own = counts[:, i]
        within = np.arange(own.sum()) - np.repeat(np.cumsum(own) - own, own)
        columns[p.name] = Lists(own, _gathered(raw, np.repeat(starts[:, i], own) + within * size, size).view(order + p.kind).ravel())
    return columns, end


def _gathered(raw: np.ndarray, starts: np.ndarray, size: int) -> np.ndarray:
    """(N, size) bytes from each start on."""
    return raw[starts[:, None] + np.arange(size)]


def _walked(element: Element, body: memoryview, at: int, order: str) -> tuple[np.ndarray, np.ndarray]:
    """(N, P + 1) where each property's own bytes start in each row, and where the row ends; (N, P) the items of each (1 of a scalar)."""
    plan = [(np.dtype(p.kind).itemsize, p.count_kind and struct.Struct(order + _STRUCTS[p.count_kind])) for p in element.properties]
    starts, counts = [], []
    for _ in range(element.count):
        for size, number in plan:
            count = 1
            if number:
                count = int(number.unpack_from(body, at)[0])
                at += number.size
                if count < 0:
                    raise ValueError(f"a list of {count} items")
            starts.append(at)
            counts.append(count)
            at += count * size
        starts.append(at)
        if at > len(body):
            raise ValueError(f"the file ends within its {element.name}")
    width = len(plan)
    return np.array(starts, np.int64).reshape(-1, width + 1), np.array(counts, np.int64).reshape(-1, width)
