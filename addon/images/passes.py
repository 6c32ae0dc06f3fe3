"""Data as something to look at: depths as grey, numbers as colours, shares as bytes."""

from __future__ import annotations

import numpy as np

from .color_bar import NOTHING

_GOLDEN = 0.6180339887498949


def byte_picture(image: np.ndarray) -> np.ndarray:
    """uint8 of values 0…1 (clipped)."""
    return np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)


def depth_picture(depth: np.ndarray) -> np.ndarray:
    """uint16 grey: the nearest depth white, the farthest dark grey, nothing (inf) black. Linear in depth."""
    seen = np.isfinite(depth)
    if not seen.any():
        return np.zeros(depth.shape, np.uint16)
    near, far = float(depth[seen].min()), float(depth[seen].max())
    level = np.where(seen, 1.0 - 0.9 * (np.where(seen, depth, near) - near) / max(far - near, 1e-30), 0.0)
    return np.rint(level * 65535.0).astype(np.uint16)


def id_colors(ids: np.ndarray) -> np.ndarray:
    """(h, w, 3) uint8: one colour per number, neighbours far apart (hues by the golden ratio); −1 grey."""
    numbers, index = np.unique(ids, return_inverse=True)
    hue = (numbers.astype(np.float64) * _GOLDEN) % 1.0
    wave = 0.5 + 0.5 * np.cos(2.0 * np.pi * (hue[:, None] + np.array([0.0, 2.0 / 3.0, 1.0 / 3.0])))
    value = np.where(numbers % 2 == 0, 0.95, 0.75)
    colors = np.rint(255.0 * value[:, None] * (0.25 + 0.75 * wave)).astype(np.uint8)
    colors[numbers < 0] = NOTHING
    return colors[index.reshape(ids.shape)]
