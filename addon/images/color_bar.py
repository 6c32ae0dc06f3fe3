"""A picture of numbers as colours: what its bar looks like, and how the shape of what is shown stays readable. numpy only."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from .lettering import HEIGHT, draw_text

NOTHING = (70, 70, 76)
"""sRGB where there is no number."""
INK, PAPER = (20, 20, 22), (240, 240, 240)


def darkened(image: np.ndarray, shade: np.ndarray | None, most: float) -> np.ndarray:
    """(h, w, 3) uint8 colours darkened by up to `most` of their brightness, as `shade` (h, w) 0…1 says; None leaves them flat."""
    if shade is None:
        return image
    return np.rint(image * (1.0 - most + most * np.clip(shade, 0.0, 1.0))[..., None]).astype(np.uint8)


def color_bar(width: int, colors: Callable[[int], np.ndarray], ticks: Iterable[tuple[float, str]], title: str) -> np.ndarray:
    """(height, width, 3) uint8: a bar with numbers under it, and the title where there is room.

    `colors` gives so many of them (N, 3) from one end to the other; `ticks`: how far along, 0…1, and what stands there.
    """
    scale = 2 if width >= 600 else 1
    thick, gap, margin = 12 * scale, 4 * scale, 14 * scale
    line = HEIGHT * scale + gap
    has_title = width >= 6 * scale * len(title)
    image = np.full((gap + thick + gap + line * (2 if has_title else 1), width, 3), PAPER, np.uint8)
    left, right = margin, max(width - margin, margin + 1)
    room = image[gap : gap + thick, left:right]
    room[:] = colors(right - left)[: room.shape[1]]
    for along, text in ticks:
        x = round(left + (right - 1 - left) * along)
        image[gap + thick : gap + thick + gap // 2, x : x + 1] = INK
        draw_text(image, text, x, gap + thick + gap, INK, scale)
    if has_title:
        draw_text(image, title, width // 2, gap + thick + gap + line, INK, scale)
    return image
