"""Numbers as colours above a bar that says what they mean: a picture with its legend. numpy only."""

from __future__ import annotations

from math import floor, log10

import numpy as np

from .heatmap import INK, NOTHING, PAPER
from .lettering import HEIGHT, draw_text

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
    image = sun_colors(values / max(most, 1e-9))
    if shade is not None:
        image = np.rint(image * (1.0 - SHADED + SHADED * np.clip(shade, 0.0, 1.0))[..., None]).astype(np.uint8)
    return np.concatenate([image, bar(image.shape[1], most, title)])


def ticks(most: float) -> list[float]:
    """Round numbers from 0 to `most`, five or so."""
    raw = max(most, 1e-9) / 5.0
    power = 10.0 ** floor(log10(raw))
    step = next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= raw * 0.999)
    return [step * i for i in range(int(most / step + 1e-6) + 1)]


def bar(width: int, most: float, title: str) -> np.ndarray:
    """(height, width, 3) uint8: a bar of the colours from 0 to `most`, numbers under it, and the title where there is room."""
    scale = 2 if width >= 600 else 1
    thick, gap, margin = 12 * scale, 4 * scale, 14 * scale
    line = HEIGHT * scale + gap
    has_title = width >= 6 * scale * len(title)
    image = np.full((gap + thick + gap + line * (2 if has_title else 1), width, 3), PAPER, np.uint8)
    left, right = margin, max(width - margin, margin + 1)
    room = image[gap : gap + thick, left:right]
    room[:] = sun_colors(np.linspace(0.0, 1.0, right - left))[: room.shape[1]]
    for value in ticks(most):
        x = round(left + (right - 1 - left) * value / max(most, 1e-9))
        image[gap + thick : gap + thick + gap // 2, x : x + 1] = INK
        draw_text(image, f"{value:g}", x, gap + thick + gap, INK, scale)
    if has_title:
        draw_text(image, title, width // 2, gap + thick + gap + line, INK, scale)
    return image
