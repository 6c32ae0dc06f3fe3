"""The codecs of meshopt-compressed buffer views. Source: KHR_meshopt_compression, Appendix A; EXT_meshopt_compression is its version 0.

Not here: what a view says about its codec (`gltf_document.py`) and the filters behind it (`meshopt_filters.py`).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

GROUP = 16
MOST_GROWTH = 1024  # what a byte may become: all deltas of 256 elements of 4 bytes are 0
TAIL_OF_TRIANGLES, TAIL_OF_INDICES = 16, 4
OLD_BITS, BITS = (0, 2, 4, 8), ((0, 1, 2, 4), (1, 2, 4, 8))  # of the deltas of a group: in version 0, and by the control mode of version 1
UNPACKED = {
    bits: [bytes((byte >> shift) & ((1 << bits) - 1) for shift in shifts) for byte in range(256)]
    for bits, shifts in ((1, range(8)), (2, (6, 4, 2, 0)), (4, (4, 0)))
}


def attributes(data: bytes, count: int, stride: int) -> np.ndarray:
    """(count, stride) uint8 the elements of mode 0. Raises `ValueError` for what is no such stream."""
    version = _version(data, 0xA0, 1)
    if stride % 4 or not 4 <= stride <= 256 or count < 0 or count * stride > MOST_GROWTH * len(data):
        raise ValueError(f"{count:,} elements of {stride} bytes cannot be in {len(data):,} bytes")
    modes = stride // 4 if version else 0
    deltas = _deltas(memoryview(data)[1 : len(data) - max(stride + modes, 24 if version else 32)], count, stride, version)
    tail = np.frombuffer(data, np.uint8)[len(data) - stride - modes :]
    out = np.empty((count, stride), np.uint8)
    for channel in range(stride // 4):
        own = slice(4 * channel, 4 * channel + 4)
        out[:, own] = _values(deltas[own], tail[own], int(tail[stride + channel]) if version else 0)
    return out


def _version(data: bytes, mark: int, newest: int) -> int:
    if not data or not mark <= data[0] <= mark + newest:
        raise ValueError(f"a meshopt stream begins with {data[:1].hex() or 'nothing'}")
    return data[0] - mark


def _deltas(data: memoryview, count: int, stride: int, version: int) -> np.ndarray:
    """(stride, count) uint8 the deltas of every byte of the elements, as stored."""
    block = min((8192 // stride) & ~15, 256)
    deltas, at = np.zeros((stride, -(-count // GROUP) * GROUP), np.uint8), 0
    for first in range(0, count, block):
        size = min(block, count - first)
        groups = -(-size // GROUP)
        controls, at = (_taken(data, at, stride // 4), at + stride // 4) if version else (b"", at)
        for k in range(stride):
            control = (controls[k // 4] >> 2 * (k % 4)) & 3 if version else 0
            if control < 2:
                row, at = _row(data, at, groups, BITS[control] if version else OLD_BITS)
            elif control == 2:
                continue
            else:
                row, at = np.frombuffer(_taken(data, at, size), np.uint8), at + size
            deltas[k, first : first + len(row)] = row
    if at != len(data):
        raise ValueError(f"{len(data) - at} bytes of a meshopt stream are left over")
    return deltas[:, :count]


def _taken(data: memoryview, at: int, count: int) -> memoryview:
    if at + count > len(data):
        raise ValueError("a meshopt stream ends too early")
    return data[at : at + count]


def _row(data: memoryview, at: int, groups: int, bits_of: tuple[int, ...]) -> tuple[np.ndarray, int]:
    """The stored deltas of one byte of a block's elements, and where the next begin."""
    head, at = _taken(data, at, -(-groups // 4)), at + -(-groups // 4)
    row = []
    for group in range(groups):
        bits = bits_of[(head[group // 4] >> 2 * (group % 4)) & 3]
        packed, at = _taken(data, at, 2 * bits), at + 2 * bits
        if bits in (0, 8):
            row.append(bytes(packed) if bits else bytes(GROUP))
            continue
        values, sentinel = b"".join([UNPACKED[bits][byte] for byte in packed]), (1 << bits) - 1
        if wide := values.count(sentinel):
            values, at = _with_wide(values, sentinel, _taken(data, at, wide)), at + wide
        row.append(values)
    return np.frombuffer(b"".join(row), np.uint8), at


def _with_wide(values: bytes, sentinel: int, wide: memoryview) -> bytes:
    """Deltas with those in place of sentinels that need a whole byte."""
    following = iter(wide)
    return bytes([next(following) if value == sentinel else value for value in values])


def _values(deltas: np.ndarray, base: np.ndarray, mode: int) -> np.ndarray:
    """(count, 4) uint8 one channel of the elements: (4, count) deltas added up from the baseline (4,)."""
    kind, rotation = mode & 15, mode >> 4
    rows, start = np.ascontiguousarray(deltas.T), np.ascontiguousarray(base)
    if kind == 2:
        words = rows.view("<u4")[:, 0]
        words = (words >> np.uint32(rotation)) | (words << np.uint32((32 - rotation) & 31)) if rotation else words
        joined = np.concatenate([start.view("<u4"), words])
        return np.bitwise_xor.accumulate(joined)[1:, None].view(np.uint8)
    if kind > 1 or rotation:
        raise ValueError(f"a meshopt channel of mode {mode}")
    number = np.dtype("<u2") if kind else np.dtype("u1")
    coded = rows.view(number)
    signed = (coded >> 1) ^ (0 - (coded & 1)).astype(number)
    return np.cumsum(np.concatenate([start.view(number)[None], signed]), axis=0, dtype=number)[1:].view(np.uint8)


def triangles(data: bytes, count: int) -> np.ndarray:
    """(count,) uint32 the indices of mode 1. Raises `ValueError` for what is no such stream."""
    _version(data, 0xE1, 0)
    if count % 3 or count < 0 or count // 3 + 1 + TAIL_OF_TRIANGLES > len(data):
        raise ValueError(f"{count:,} indices of triangles cannot be in {len(data):,} bytes")
    state = _Triangles(data, count // 3)
    out: list[int] = []
    try:
        for code in data[1 : 1 + count // 3]:
            out += state.by_edge(code >> 4, code & 15) if code < 0xF0 else state.by_corners(code)
    except StopIteration:
        raise ValueError("a meshopt stream ends too early") from None
    return (np.array(out, np.int64) & 0xFFFFFFFF).astype(np.uint32)


class _Triangles:
    """What the decoder of mode 1 remembers: the last 16 edges and corners, the next new corner, the last one that was written out."""

    def __init__(self, data: bytes, count: int) -> None:
        self._further = iter(data[1 + count : len(data) - TAIL_OF_TRIANGLES])
        self._pairs = data[len(data) - TAIL_OF_TRIANGLES :]
        self._edges, self._corners = [(0, 0)] * GROUP, [0] * GROUP
        self._edge, self._corner, self._next, self._last = 0, 0, 0, 0

    def by_edge(self, edge: int, code: int) -> tuple[int, int, int]:
        """A triangle on one of the last edges: its third corner is new, one of the last, a neighbour of the one written out, or written."""
        a, b = self._edges[(self._edge - 1 - edge) & 15]
        if code == 0:
            c, self._next = self._next, self._next + 1
        elif code < 13:
            c = self._corners[(self._corner - 1 - code) & 15]
        elif code < 15:
            c = self._last = self._last + (1 if code == 14 else -1)
        else:
            c = self._written()
        if not 0 < code < 13:
            self._push(c)
        self._push_edges((c, b), (a, c))
        return a, b, c

    def by_corners(self, code: int) -> tuple[int, int, int]:
        """A triangle on no edge: its corners are new, among the last, or written out."""
        pair = self._pairs[code & 15] if code < 0xFE else next(self._further)
        if code >= 0xFE and pair == 0:
            self._next = 0
        if code == 0xFF:
            a = self._written()
        else:
            a, self._next = self._next, self._next + 1
        b, is_b_new = self._named(pair >> 4)
        c, is_c_new = self._named(pair & 15)
        self._push(a)
        if is_b_new:
            self._push(b)
        if is_c_new:
            self._push(c)
        self._push_edges((b, a), (c, b))
        self._push_edges((a, c))
        return a, b, c

    def _named(self, code: int) -> tuple[int, bool]:
        """A corner, and whether it is not among the last."""
        if code == 0:
            self._next += 1
            return self._next - 1, True
        return (self._written(), True) if code == 15 else (self._corners[(self._corner - code) & 15], False)

    def _push(self, corner: int) -> None:
        self._corners[self._corner & 15] = corner
        self._corner += 1

    def _push_edges(self, *edges: tuple[int, int]) -> None:
        for edge in edges:
            self._edges[self._edge & 15] = edge
            self._edge += 1

    def _written(self) -> int:
        value = _varint(self._further)
        self._last += ~(value >> 1) if value & 1 else value >> 1
        return self._last


def _varint(data: Iterator[int]) -> int:
    """An integer of 7 bits in each byte, the least first."""
    value = shift = 0
    for byte in data:
        value |= (byte & 127) << shift
        if byte < 128:
            return value
        shift += 7
    raise StopIteration


def indices(data: bytes, count: int) -> np.ndarray:
    """(count,) uint32 the indices of mode 2. Raises `ValueError` for what is no such stream."""
    _version(data, 0xD1, 0)
    if not 0 <= count <= len(data) - 1 - TAIL_OF_INDICES:
        raise ValueError(f"{count:,} indices cannot be in {len(data):,} bytes")
    further, last, out = iter(data[1 : len(data) - TAIL_OF_INDICES]), [0, 0], []
    try:
        for _ in range(count):
            value = _varint(further)
            last[value & 1] += ~(value >> 2) if value & 2 else value >> 2
            out.append(last[value & 1])
    except StopIteration:
        raise ValueError("a meshopt stream ends too early") from None
    return (np.array(out, np.int64) & 0xFFFFFFFF).astype(np.uint32)
