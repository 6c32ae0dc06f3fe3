"""The number that Object Info calls random, as Cycles makes it of an object's name (Jenkins' lookup3)."""

from __future__ import annotations

ALL = 0xFFFFFFFF


def random_of(name: str) -> int:
    """A 32-bit number for an object that is no instance (those have their own)."""
    total = 0
    for byte in name.encode():
        total = (37 * total + (byte if byte < 128 else byte - 256)) & ALL
    return _mixed(total, 0)


def _mixed(x: int, y: int) -> int:
    start = (0xDEADBEEF + (2 << 2) + 13) & ALL
    a, b, c = (start + x) & ALL, (start + y) & ALL, start
    for shift in (14, 11, 25, 16, 4, 14, 24):  # the last round of lookup3, its three numbers in turn
        c = ((c ^ b) - _turned(b, shift)) & ALL
        a, b, c = b, c, a
    return b


def _turned(number: int, bits: int) -> int:
    return ((number << bits) | (number >> (32 - bits))) & ALL
