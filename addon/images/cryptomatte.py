"""Cryptomatte: names as numbers that pictures can hold (Friedman and Jones 2015, "Fully automatic ID mattes", specification 1.2)."""

from __future__ import annotations

import json
from collections.abc import Iterable

import numpy as np

WORD = 0xFFFFFFFF


def murmur3(data: bytes, seed: int = 0) -> int:
    """MurmurHash3_x86_32, the hash that the specification asks for."""
    h = seed
    whole = len(data) // 4 * 4
    for i in range(0, whole, 4):
        h ^= _scrambled(int.from_bytes(data[i : i + 4], "little"))
        h = (_turned(h, 13) * 5 + 0xE6546B64) & WORD
    if whole < len(data):
        h ^= _scrambled(int.from_bytes(data[whole:], "little"))
    h ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
        h = ((h ^ (h >> shift)) * factor) & WORD
    return h ^ (h >> 16)


def _scrambled(k: int) -> int:
    return (_turned((k * 0xCC9E2D51) & WORD, 15) * 0x1B873593) & WORD


def _turned(number: int, bits: int) -> int:
    return ((number << bits) | (number >> (32 - bits))) & WORD


def number_bits(name: str) -> int:
    """The 32 bits of a name's number: its hash, kept from infinities, NaN and denormals by a turned bit of the exponent."""
    h = murmur3(name.encode())
    exponent = (h >> 23) & 255
    return h ^ (1 << 23) if exponent in (0, 255) else h


def numbers_of(names: Iterable[str]) -> np.ndarray:
    """(N,) float32 of names."""
    return np.array([number_bits(name) for name in names], np.uint32).view(np.float32)


def manifest(names: Iterable[str]) -> str:
    """Which name has which number, as JSON: what lets a viewer show names."""
    return json.dumps({name: f"{number_bits(name):08x}" for name in names}, ensure_ascii=False, separators=(",", ":"))


def layer_key(layer: str) -> str:
    """The seven digits that a layer's metadata go under."""
    return f"{murmur3(layer.encode()):08x}"[:7]


def ranked(index: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
    """(h, w, 4) number, coverage, 0, 0 of the first rank, from an image (h, w) of indices into `names`, −1 where there is nothing."""
    numbers = numbers_of(names)
    out = np.zeros((*index.shape, 4), np.float32)
    seen = index >= 0
    out[seen, 0] = numbers[index[seen]]
    out[seen, 1] = 1.0
    return out
