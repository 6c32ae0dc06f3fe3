"""Unit vectors as two 16-bit numbers: the octahedron folded flat; mirrors `shaders/common_octahedral.glsl`."""

from __future__ import annotations

import numpy as np


def from_octahedral(folded: np.ndarray) -> np.ndarray:
    """(P, 3) unit vectors of (P, 2) numbers in [−1, 1]."""
    x, y = folded[:, 0], folded[:, 1]
    n = np.stack([x, y, 1.0 - np.abs(x) - np.abs(y)], axis=-1)
    n[:, :2] -= np.where(n[:, :2] >= 0.0, 1.0, -1.0) * np.maximum(-n[:, 2:], 0.0)
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def packed_octahedral(normals: np.ndarray) -> np.ndarray:
    """(V,) uint32 of (V, 3) unit vectors: x in the low, y in the high 16 bits, signed and scaled by 32767 (error below 0.004°)."""
    n = np.asarray(normals, np.float32)
    length = np.abs(n).sum(axis=1, keepdims=True)
    n = n / np.where(length > 0.0, length, np.float32(1.0))
    sign = np.where(n[:, :2] >= 0.0, np.float32(1.0), np.float32(-1.0))
    flat = np.where(n[:, 2:] >= 0.0, n[:, :2], (1.0 - np.abs(n[:, 1::-1])) * sign)
    fixed = np.rint(np.clip(flat, -1.0, 1.0) * 32767.0).astype(np.int32).astype(np.uint32) & np.uint32(0xFFFF)
    return fixed[:, 0] | (fixed[:, 1] << np.uint32(16))
