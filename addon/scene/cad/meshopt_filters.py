"""What turns decoded meshopt elements into the numbers they stand for. Source: KHR_meshopt_compression, Appendix B."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

WIDTHS = {"OCTAHEDRAL": (4, 8), "QUATERNION": (8,), "COLOR": (4, 8)}


def filtered(elements: np.ndarray, name: str) -> np.ndarray:
    """(count, stride) uint8 elements after the filter of that name. Raises `ValueError` for one that is unknown or of another width."""
    if name == "NONE":
        return elements
    if name not in FILTERS or elements.shape[1] not in WIDTHS.get(name, range(4, 257, 4)):
        raise ValueError(f"a meshopt filter {name[:20]} on elements of {elements.shape[1]} bytes")
    with np.errstate(all="ignore"):
        return np.ascontiguousarray(FILTERS[name](np.ascontiguousarray(elements))).view(np.uint8)


def _octahedral(elements: np.ndarray) -> np.ndarray:
    """Unit vectors from their place on an octahedron; the third number is what stands for 1."""
    number = np.dtype("i1" if elements.shape[1] == 4 else "<i2")
    given = elements.view(number)
    one = np.maximum(given[:, 2], 1).astype(np.float32)
    x, y = given[:, 0] / one, given[:, 1] / one
    z = 1.0 - np.abs(x) - np.abs(y)
    below = np.minimum(z, 0.0)
    vector = np.stack([x - np.copysign(below, x), y - np.copysign(below, y), z], axis=1)
    vector /= np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), np.finfo(np.float32).tiny)
    return np.concatenate([np.rint(vector * np.iinfo(number).max).astype(number), given[:, 3:]], axis=1)


def _quaternion(elements: np.ndarray) -> np.ndarray:
    """Unit quaternions from all but their largest component, whose number stands in the last two bits."""
    given = elements.view("<i2").astype(np.int32)
    one = np.maximum(given[:, 3] | 3, 1).astype(np.float32)[:, None]
    three = given[:, :3] / one / np.float32(np.sqrt(2.0))
    largest = np.sqrt(np.maximum(1.0 - np.einsum("ij,ij->i", three, three), 0.0))
    out, rows = np.empty((len(given), 4), "<i2"), np.arange(len(given))
    for step, value in enumerate((largest, *three.T)):
        out[rows, (given[:, 3] + step) & 3] = np.rint(np.clip(value, -1.0, 1.0) * 32767.0).astype(np.int16)
    return out


def _exponential(elements: np.ndarray) -> np.ndarray:
    """Floats from 8 bits of exponent and 24 of mantissa."""
    given = elements.view("<i4")
    return np.ldexp(((given << 8) >> 8).astype(np.float32), given >> 24).astype("<f4")


def _color(elements: np.ndarray) -> np.ndarray:
    """Red, green, blue, opacity from luma, two differences and an opacity whose highest bit says how many bits count."""
    unsigned = np.dtype("u1" if elements.shape[1] == 4 else "<u2")
    given = elements.view(unsigned).astype(np.int32)
    luma, alpha = given[:, 0], given[:, 3]
    orange, green = (elements.view(unsigned.str.replace("u", "i"))[:, k].astype(np.int32) for k in (1, 2))
    most = (1 << (np.frexp(alpha.astype(np.float64))[1])) - 1
    opacity = alpha & (most >> 1)
    opacity = (opacity << 1) | (opacity & 1)
    channels = np.stack([luma + orange - green, luma + green, luma - orange - green, opacity], axis=1)
    scale = np.iinfo(unsigned).max / np.maximum(most, 1)
    return np.clip(np.rint(channels * scale[:, None]), 0, np.iinfo(unsigned).max).astype(unsigned)


FILTERS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "OCTAHEDRAL": _octahedral,
    "QUATERNION": _quaternion,
    "EXPONENTIAL": _exponential,
    "COLOR": _color,
}
