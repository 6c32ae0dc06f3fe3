"""Numbers as colours above a bar that says what they mean: a picture with its legend. numpy only."""

from __future__ import annotations

from math import floor, log10

import numpy as np

from .color_bar import NOTHING, color_bar, darkened

# sRGB from none to most: dark blue, violet, red, orange, pale yellow (brightness grows all the way)
SUN_COLORS = np.array([(22, 24, 74), (86, 30, 122), (168, 44, 104), (228, 92, 58), (248, 168, 52), (254, 246, 176)], np.float64)
SHADED = 0.35  # of the colour's brightness that the shape takes


def sun_colors(share: np.ndarray) -> np.ndarray:
    """(…, 3) uint8 sRGB of shares 0…1 (clipped) of any shape; NaN is grey."""
    known = ~np.isnan(share)
    at = np.clip(np.where(known, share, 0.0), 0.0, 1.0) * (len(SUN_COLORS) - 1)
    color = np.stack([np.interp(at, np.arange(len(SUN_COLORS)), SUN_COLORS[:, c]) for c in range(3)], axis=-1)
    return np.where(known[..., None], np.rint(color), NOTHING).astype(np.uint8)


def scaled_picture(values: np.ndarray, most: float, title: str, shade: np.ndarray | None = None) -> np.ndarray:
    """(h + legend, w, 3) uint8: values 0…`most` (h, w) in colour, NaN grey, above a bar with its numbers and `title`.

    `shade` (h, w) 0…1 darkens the colours a little, so that the shape stays readable.
    """
    image = darkened(sun_colors(values / max(most, 1e-9)), shade, SHADED)
    return np.concatenate([image, bar(image.shape[1], most, title)])


def ticks(most: float) -> list[float]:
    """Round numbers from 0 to `most`, five or so."""
    raw = max(most, 1e-9) / 5.0
    power = 10.0 ** floor(log10(raw))
    step = next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= raw * 0.999)
    return [step * i for i in range(int(most / step + 1e-6) + 1)]


def bar(width: int, most: float, title: str) -> np.ndarray:
    """(height, width, 3) uint8: a bar of the colours from 0 to `most`, numbers under it, and the title where there is room."""
    marks = [(value / max(most, 1e-9), f"{value:g}") for value in ticks(most)]
    return color_bar(width, lambda count: sun_colors(np.linspace(0.0, 1.0, count)), marks, title)
