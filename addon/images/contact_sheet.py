"""Pictures side by side with a line of text under each. numpy only; values keep their meaning, linear or displayed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, sqrt

import numpy as np

from .lettering import lines

GAP = 8
PAPER, INK = 0.12, 0.92
TILE = (480, 360)
Lines = Callable[[Sequence[str], int], list[np.ndarray]]  # coverage 0…1 of each text, none wider than so many pixels


def shrunk(picture: np.ndarray, height: int, width: int) -> np.ndarray:
    """(h, w, c) picture resampled to a size not above its own: each new pixel is the mean over the area it covers (exact, also in part)."""
    out = picture.astype(np.float64)
    for axis, count in ((0, height), (1, width)):
        size = out.shape[axis]
        if count == size:
            continue
        sums = np.concatenate([np.zeros_like(out.take([0], axis)), out.cumsum(axis)], axis)
        edges = np.linspace(0.0, size, count + 1)
        below = np.minimum(edges.astype(int), size - 1)
        part = (edges - below).reshape([-1 if k == axis else 1 for k in range(out.ndim)])
        at = sums.take(below, axis) + part * out.take(below, axis)
        out = np.diff(at, axis=axis) * (count / size)
    return out.astype(np.float32)


def fitted(picture: np.ndarray, tile: tuple[int, int]) -> np.ndarray:
    """The picture made small enough for a tile (width, height), its proportions kept; never enlarged."""
    height, width = picture.shape[:2]
    scale = min(tile[0] / width, tile[1] / height, 1.0)
    return shrunk(picture, max(round(height * scale), 1), max(round(width * scale), 1))


def contact_sheet(
    pictures: Sequence[np.ndarray],
    captions: Sequence[str],
    columns: int | None = None,
    tile: tuple[int, int] = TILE,
    written: Lines = lines,
) -> np.ndarray:
    """(h, w, 4) float32 sheet, opaque, of (h, w, 3 | 4) float pictures in reading order, each in the middle of a tile.

    `columns` by default makes the sheet about square in tiles. `written` letters the captions, those too long for their tile cut.
    Transparent parts show the paper.
    """
    if not pictures or len(pictures) != len(captions):
        raise ValueError("a contact sheet takes one caption per picture, and at least one picture")
    small = [fitted(p, tile) for p in pictures]
    cell_h, cell_w = max(p.shape[0] for p in small), max(p.shape[1] for p in small)
    columns = min(columns or ceil(sqrt(len(small))), len(small))
    rows = ceil(len(small) / columns)
    texts = written(captions, cell_w)
    step_y, step_x = cell_h + max(text.shape[0] for text in texts) + 2 * GAP, cell_w + GAP
    sheet = np.full((GAP + rows * step_y, GAP + columns * step_x, 4), PAPER, np.float32)
    sheet[..., 3] = 1.0
    for i, (picture, text) in enumerate(zip(small, texts, strict=True)):
        top, left = GAP + i // columns * step_y, GAP + i % columns * step_x
        _paste(sheet, picture, top + (cell_h - picture.shape[0]) // 2, left + (cell_w - picture.shape[1]) // 2)
        y, x = top + cell_h + GAP // 2, left + cell_w // 2 - text.shape[1] // 2
        sheet[y : y + text.shape[0], x : x + text.shape[1], :3] += (INK - PAPER) * text[..., None]
    return sheet


def _paste(sheet: np.ndarray, picture: np.ndarray, top: int, left: int) -> None:
    """Colours with an alpha are taken as premultiplied, as Blender's are."""
    height, width = picture.shape[:2]
    place = sheet[top : top + height, left : left + width, :3]
    cover = picture[..., 3:4] if picture.shape[2] == 4 else 1.0
    place[...] = picture[..., :3] + (1.0 - cover) * place
