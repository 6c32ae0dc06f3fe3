"""The error m as a heat map with a legend: a diverging scale in log2 m from 1/4 to 16, neutral at the ideal m = 1."""

from __future__ import annotations

import numpy as np

from .lettering import HEIGHT, draw_text

LOG2_LOW, LOG2_HIGH = -2.0, 4.0
TICKS = ((-2, "1/4"), (-1, "1/2"), (0, "1"), (1, "2"), (2, "4"), (3, "8"), (4, "16"))
TITLE = "m: picture pixels per shadow map texel"
NOTHING = (70, 70, 76)
INK, PAPER = (20, 20, 22), (240, 240, 240)

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
    image = scale_colors(m)
    if shade is not None:
        image = np.rint(image * (0.55 + 0.45 * np.clip(shade, 0.0, 1.0))[..., None]).astype(np.uint8)
    return np.concatenate([image, legend(image.shape[1])])


def legend(width: int) -> np.ndarray:
    """(height, width, 3) uint8: a bar of the scale with its numbers, and below it what m is where there is room."""
    scale = 2 if width >= 600 else 1
    bar, gap, margin = 12 * scale, 4 * scale, 14 * scale
    line = HEIGHT * scale + gap
    has_title = width >= 6 * scale * len(TITLE)
    image = np.full((gap + bar + gap + line * (2 if has_title else 1), width, 3), PAPER, np.uint8)
    left, right = margin, max(width - margin, margin + 1)
    levels = np.linspace(LOG2_LOW, LOG2_HIGH, right - left)
    room = image[gap : gap + bar, left:right]
    room[:] = scale_colors(2.0**levels)[: room.shape[1]]
    for level, text in TICKS:
        x = round(left + (right - 1 - left) * (level - LOG2_LOW) / (LOG2_HIGH - LOG2_LOW))
        image[gap + bar : gap + bar + gap // 2, x : x + 1] = INK
        draw_text(image, text, x, gap + bar + gap, INK, scale)
    if has_title:
        draw_text(image, TITLE, width // 2, gap + bar + gap + line, INK, scale)
    return image
