"""Colours of CAD files to linear RGBA, and faces grouped by colour into material slots."""

from __future__ import annotations

import numpy as np

from ...images.srgb import linear_from_srgb

MAX_SLOTS = 16


def rgba(colors: np.ndarray, *, is_srgb: bool) -> np.ndarray:
    """(N, 4) float64 linear in 0…1 from (N, 3) or (N, 4) of bytes, 16-bit integers or floats."""
    array = np.asarray(colors)
    scale = float(np.iinfo(array.dtype).max) if array.dtype.kind in "ui" else 1.0
    unit = np.clip(np.nan_to_num(array.astype(np.float64) / scale), 0.0, 1.0)
    if unit.shape[1] == 3:
        unit = np.concatenate([unit, np.ones((len(unit), 1))], axis=1)
    return linear_from_srgb(unit) if is_srgb else unit


def color_slots(corner_colors: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Claim: (S, 4) colours, S ≤ `MAX_SLOTS`, and the slot (T,) of each triangle of (T, 3, 4) corner colours; None where a triangle has
    more than one colour, or all together have more.

    Colours are told apart at 1/255, as files store them.
    """
    steps = np.rint(corner_colors * 255.0).astype(np.int64)
    key = steps @ np.array([1 << 24, 1 << 16, 1 << 8, 1])
    if (key != key[:, :1]).any():
        return None
    _, first, slots = np.unique(key[:, 0], return_index=True, return_inverse=True)
    return None if len(first) > MAX_SLOTS else (corner_colors[first, 0], slots.astype(np.int32).ravel())


def of_faces(colors: np.ndarray) -> np.ndarray:
    """(T, 3, 4) the colours of all corners from (T, 4) of the triangles."""
    return np.broadcast_to(colors[:, None, :], (len(colors), 3, 4))
