"""What the drawing shaders look up before the texels: at which depths a square of texels can be met at all, and whether it is smooth.

Grids over the texels, v downwards, each with an empty rim: tiles, over which a fragment's ray leaps, and windows, which overlap so that one
of them holds all that the rays of a small block of pixels touch over a short depth.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from .texels import EMPTY

STRIDES = (4, 8, 16, 32)
"""Texels from one window to the next, in the grids of windows from fine to coarse."""
OVERLAP = 4
"""Strides that a window is wide."""
TILE = STRIDES[1]
"""Texels per side of a tile."""
_NOTHING = np.float32([-EMPTY, -1.0, -EMPTY, EMPTY, 0.0])


def tiles_and_windows(layers: np.ndarray, continuous: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """The grids of texels (h, w, 4) as in `texels.py`, float32; `continuous`: steps of |relief| up to this are one surface.

    Tile (j, i), of (⌈h/TILE⌉ + 2, ⌈w/TILE⌉ + 2, 3), begins at texel TILE·(i − 1): the depth of the nearest front surface in it or in the
    texels round it, slopes included; that behind which a ray meets neither a surface nor a back (nor a neighbour's, as edge texels show
    them); that of the nearest in it. `EMPTY` and −1 where there is nothing. For each stride s of `STRIDES`, window (j, i), of
    (⌈h/s⌉ + 5, ⌈w/s⌉ + 5, 4), spans texels s·(i − OVERLAP) to s·i: the depth of the nearest surface; that behind which nothing is met;
    that by which every ray over it has met the front, if the front is one surface without edges, gaps and steps, else `EMPTY`; the
    steepest slope there, |da/du| + |da/dv|.
    """
    a, du, dv, back = (np.ascontiguousarray(layers[..., i]) for i in range(4))
    front, slopes = np.abs(a), np.abs(du) + np.abs(dv)
    nearer = 0.5 * slopes - front
    behind = np.where(front < EMPTY, np.maximum(back, front + 2.0 * slopes + continuous), np.float32(-1.0))
    far = np.where(_is_smooth(a, du, dv, continuous), front + 0.5 * slopes, EMPTY)
    images = (nearer, 1), (behind, 1), (nearer, 0), (far, 0), (slopes, 0)
    squares = np.stack([_largest(image, empty, around) for (image, around), empty in zip(images, _NOTHING, strict=True)], axis=-1)
    levels = {STRIDES[0]: squares}
    for finer, coarser in pairwise(STRIDES):
        levels[coarser] = _halved(levels[finer])
    windows = [_of_neighbours(_of_neighbours(_with_rim(level, OVERLAP)[..., [2, 1, 3, 4]], 1), 2) for level in levels.values()]
    sign = np.float32([-1.0, 1.0, 1.0, 1.0])
    return _with_rim(levels[TILE], 1)[..., :3] * np.float32([-1.0, 1.0, -1.0]), [window * sign for window in windows]


def _is_smooth(a: np.ndarray, du: np.ndarray, dv: np.ndarray, continuous: float) -> np.ndarray:
    """(h, w) bool: one whole surface, which goes on into the texels beside and below with a step of at most `continuous`."""
    smooth = (a >= 0.0) & (a < EMPTY)
    smooth[:, :-1] &= np.abs(np.diff(a, axis=1) - 0.5 * (du[:, 1:] + du[:, :-1])) <= continuous
    smooth[:-1] &= np.abs(np.diff(a, axis=0) - 0.5 * (dv[1:] + dv[:-1])) <= continuous
    return smooth


def _largest(image: np.ndarray, empty: float, around: int) -> np.ndarray:
    """The largest in every square of STRIDES[0]² of an image (h, w) and `around` texels beyond it; outside the image lies `empty`."""
    side = STRIDES[0]
    for axis in (0, 1):
        lines = np.moveaxis(image, axis, 0)
        length = -(-len(lines) // side) * side
        padded = np.full((length + 2 * around, lines.shape[1]), empty, np.float32)
        padded[around : around + len(lines)] = lines
        most = padded[:length:side]
        for beyond in range(1, side + 2 * around):
            most = np.maximum(most, padded[beyond : beyond + length : side])
        image = np.moveaxis(most, 0, axis)
    return image


def _halved(squares: np.ndarray) -> np.ndarray:
    """Squares (rows, columns, 5) of twice the side: the largest of four."""
    rows, columns = (n + n % 2 for n in squares.shape[:2])
    padded = np.full((rows, columns, len(_NOTHING)), _NOTHING)
    padded[: squares.shape[0], : squares.shape[1]] = squares
    return _of_neighbours(padded, 1)[::2, ::2]


def _with_rim(squares: np.ndarray, rim: int) -> np.ndarray:
    """With so many squares of nothing on every side."""
    rows, columns = squares.shape[:2]
    padded = np.full((rows + 2 * rim, columns + 2 * rim, len(_NOTHING)), _NOTHING)
    padded[rim : rim + rows, rim : rim + columns] = squares
    return padded


def _of_neighbours(squares: np.ndarray, apart: int) -> np.ndarray:
    """The largest of every square and those `apart` to the right, below and both."""
    rows = np.maximum(squares[:-apart], squares[apart:])
    return np.maximum(rows[:, :-apart], rows[:, apart:])
