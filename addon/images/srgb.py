"""From linear light to the values that files and screens hold, and back."""

from __future__ import annotations

import numpy as np


def srgb(linear: np.ndarray) -> np.ndarray:
    """Linear light 0…1 (clipped) as sRGB values (IEC 61966-2-1), (h, w, 3 or 4) float32; alpha stays."""
    clipped = np.clip(np.nan_to_num(linear[..., :3]), 0.0, 1.0)
    out = np.array(linear, dtype=np.float32)
    out[..., :3] = np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * np.maximum(clipped, 0.0031308) ** (1 / 2.4) - 0.055)
    return out


def linear_from_srgb(color: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1 decoding of RGB(A) in 0…1; alpha stays as it is."""
    out = np.array(color, dtype=np.float64)
    rgb = out[..., :3]
    out[..., :3] = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return out
