"""The error m as a heat map with a legend: a diverging scale in log2 m from 1/4 to 16, neutral at the ideal m = 1."""

from __future__ import annotations

import numpy as np

from .color_bar import NOTHING, color_bar, darkened

LOG2_LOW, LOG2_HIGH = -2.0, 4.0
TICKS = ((-2, "1/4"), (-1, "1/2"), (0, "1"), (1, "2"), (2, "4"), (3, "8"), (4, "16"))
TITLE = "m: picture pixels per shadow map texel"
SHADED = 0.45
"""Of a colour's brightness that the shape takes."""

# sRGB per doubling of m from LOG2_LOW to LOG2_HIGH: blue wastes texels, pale is ideal, yellow to dark red aliases
SCALE_COLORS = np.array(
    [(33, 72, 160), (112, 164, 214), (232, 240, 226), (250, 214, 96), (240, 138, 45), (206, 48, 36), (110, 6, 40)], np.float64
)
_STOPS = np.linspace(LOG2_LOW, LOG2_HIGH, len(SCALE_COLORS))


def scale_colors(m: np.ndarray) -> np.ndarray:
    """(…, 3) uint8 sRGB of errors m ≥ 0 of any shape; NaN (no surface, no map) is grey, beyond the ends the ends' colours."""
    m = np.asarray(m, dtype=np.float64)
    known = ~np.isnan(m)
    level = np.log2(np.clip(np.where(known, m, 1.0), 2.0**LOG2_LOW, 2.0**LOG2_HIGH))
    color = np.stack([np.interp(level, _STOPS, SCALE_COLORS[:, c]) for c in range(3)], axis=-1)
    return np.where(known[..., None], np.rint(color), NOTHING).astype(np.uint8)


def heat_map(m: np.ndarray, shade: np.ndarray | None = None) -> np.ndarray:
    """(h + legend, w, 3) uint8: the error m (h, w) in colour above its legend.

    `shade` (h, w) 0…1 darkens the colours a little, so that the shape of the model stays readable; None leaves them flat.
    """
    image = darkened(scale_colors(m), shade, SHADED)
    return np.concatenate([image, legend(image.shape[1])])


def legend(width: int) -> np.ndarray:
    """(height, width, 3) uint8: a bar of the scale with its numbers, and below it what m is where there is room."""
    ticks = [((level - LOG2_LOW) / (LOG2_HIGH - LOG2_LOW), text) for level, text in TICKS]
    return color_bar(width, lambda count: scale_colors(2.0 ** np.linspace(LOG2_LOW, LOG2_HIGH, count)), ticks, TITLE)
