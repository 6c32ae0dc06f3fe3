"""The legends of a live view that shows data: the scale of the error m, or the colours of the shadow maps. No bpy.

`hud` draws them, the colours untouched by Blender's view transform, as those of the picture. Lengths are pixels; y grows upwards from the
legend's lower edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..images.heatmap import LOG2_HIGH, LOG2_LOW, TICKS, scale_colors
from ..images.passes import id_colors
from ..images.srgb import linear_from_srgb
from ..maths.shadow.projection import ShadowPlan

WIDTH, BAR, LINE, PAD = 290, 12, 16, 14
MOST_MAPS = 12


@dataclass(frozen=True)
class Word:
    """A text with its lower edge at y; its 'left', 'middle' or 'right' at x."""

    text: str
    x: float
    y: float
    anchor: str = "left"


@dataclass(frozen=True, eq=False)
class Legend:
    """A box of `size`; in it the rectangle `colors_at` (x, y, width, height) filled by `colors`, words, and marks.

    `colors` (h, w, 4) float32, linear, top row first. `marks`: the ends (x, y) of short lines, two by two.
    """

    size: tuple[int, int]
    colors_at: tuple[int, int, int, int]
    colors: np.ndarray
    words: tuple[Word, ...]
    marks: tuple[tuple[float, float], ...] = ()


def legend_of(display: str, plan: ShadowPlan | None, scale: float) -> Legend | None:
    """The legend of a picture that shows `display` (settings.DISPLAYS); None where the picture needs none. `scale`: Blender's UI scale."""
    if display == "aliasing":
        return heat_legend(scale)
    if display == "partitions" and plan is not None:
        return map_legend(plan, scale)
    return None


@lru_cache(maxsize=4)
def heat_legend(scale: float) -> Legend:
    """The bar of log2 m under its title; below it a mark for each number, the numbers, and what the ends mean."""
    width, bar, line, pad = (round(length * scale) for length in (WIDTH, BAR, LINE, PAD))
    length, foot = width - 2 * pad, pad + 2 * line
    row = _linear(scale_colors(2.0 ** np.linspace(LOG2_LOW, LOG2_HIGH, length)))
    title = Word("m: picture pixels per shadow map texel", pad, foot + bar + 0.35 * line)
    places = [(pad + (level - LOG2_LOW) / (LOG2_HIGH - LOG2_LOW) * length, text) for level, text in TICKS]
    numbers = [Word(text, x, pad + 1.1 * line, "middle") for x, text in places]
    ideal = next(x for x, text in places if text == "1")
    meanings = [Word("fine", pad, pad), Word("ideal", ideal, pad, "middle"), Word("jagged", width - pad, pad, "right")]
    size = (width, foot + bar + line + pad)
    marks = tuple((x, y) for x, _ in places for y in (foot - 0.3 * line, foot))
    return Legend(size, (pad, foot, length, bar), np.repeat(row[None], bar, axis=0), (title, *numbers, *meanings), marks)


def map_legend(plan: ShadowPlan, scale: float) -> Legend:
    """A swatch per map that serves something, with the view depths it serves."""
    line, pad = round(LINE * scale), round(PAD * scale)
    used = [(i, p) for i, p in enumerate(plan.projections) if not p.is_empty]
    shown = used[:MOST_MAPS]
    rows = len(shown) + 2
    height = line * rows + 2 * pad
    colors = np.zeros((max(line * len(shown), 1), line, 4), np.float32)
    words = [Word("Shadow map: view depths it serves", pad, height - pad - 0.8 * line)]
    for k, (i, p) in enumerate(shown):
        colors[k * line + 1 : (k + 1) * line - 1] = _linear(id_colors(np.array([i])))[0]
        face = f", side {p.face + 1}" if p.face >= 0 else ""
        y = height - pad - (k + 2) * line + 0.25 * line
        words.append(Word(f"Map {i + 1}:  {p.depth_range[0]:.3g} … {p.depth_range[1]:.3g} m{face}", 2 * pad + line, y))
    rest = f"and {len(used) - len(shown)} more" if len(used) > len(shown) else ""
    words.append(Word(rest or "Grey: served by none", pad, pad + 0.1 * line))
    top = height - pad - line
    return Legend((round(WIDTH * scale), height), (pad, top - line * len(shown), line, line * len(shown)), colors, tuple(words))


def _linear(srgb: np.ndarray) -> np.ndarray:
    """(…, 3) sRGB bytes as (…, 4) float32 linear, opaque."""
    out = np.ones((*srgb.shape[:-1], 4), np.float32)
    out[..., :3] = linear_from_srgb(srgb / 255.0)
    return out
