"""What the drawing shaders look up before the texels: at which depths a square of texels can be met at all, and whether it is smooth.

Two grids over the texels, v downwards, each with an empty rim: tiles, over which a fragment's ray leaps, and windows, which overlap so that
one of them holds all that the rays of a small block of pixels touch over a short depth.
"""

from __future__ import annotations

import numpy as np

from .impostor_texels import EMPTY

STRIDE = 4
"""Texels from one window to the next."""
TILE, WINDOW = 2 * STRIDE, 4 * STRIDE
"""Texels per side of a tile and of a window."""


def tiles_and_windows(layers: np.ndarray, continuous: float) -> tuple[np.ndarray, np.ndarray]:
    """The grids of texels (h, w, 4) as in `impostor_texels.py`, float32; `continuous`: steps of |relief| up to this are one surface.

    Tile (j, i), of (⌈h/TILE⌉ + 2, ⌈w/TILE⌉ + 2, 3), begins at texel TILE·(i − 1): the depth of the nearest front surface in it or in the
    texels round it, slopes included; that behind which a ray meets neither a surface nor a back (nor a neighbour's, as edge texels show
    them); that of the nearest in it. `EMPTY` and −1 where there is nothing. Window (j, i), of (⌈h/STRIDE⌉ + 5, ⌈w/STRIDE⌉ + 5, 4), begins
    at STRIDE·i − WINDOW: that of the nearest; that behind which nothing is met; that by which every ray over it has met the front, if the
    front is one surface without edges, gaps and steps, else `EMPTY`; the steepest slope there, |da/du| + |da/dv|.
    """
    a, du, dv, back = (np.ascontiguousarray(layers[..., i]) for i in range(4))
    front, slopes = np.abs(a), np.abs(du) + np.abs(dv)
    nearer = 0.5 * slopes - front
    behind = np.where(front < EMPTY, np.maximum(back, front + 2.0 * slopes + continuous), np.float32(-1.0))
    far = np.where(_is_smooth(a, du, dv, continuous), front + 0.5 * slopes, EMPTY)
    kinds = (nearer, -EMPTY, 1), (behind, -1.0, 1), (nearer, -EMPTY, 0), (far, EMPTY, 0), (slopes, 0.0, 0)
    pairs = _of_neighbours(np.stack([_largest(*kind) for kind in kinds], axis=-1), 1)
    rows, columns = (-(-n // TILE) for n in layers.shape[:2])
    rim = WINDOW // STRIDE
    tiles = np.full((rows + 2, columns + 2, 3), (EMPTY, -1.0, EMPTY), np.float32)
    tiles[1:-1, 1:-1] = pairs[rim : rim + 2 * rows : 2, rim : rim + 2 * columns : 2, :3] * np.float32([-1.0, 1.0, -1.0])
    return tiles, _of_neighbours(pairs[..., [2, 1, 3, 4]], 2) * np.float32([-1.0, 1.0, 1.0, 1.0])


def _is_smooth(a: np.ndarray, du: np.ndarray, dv: np.ndarray, continuous: float) -> np.ndarray:
    """(h, w) bool: one whole surface, which goes on into the texels beside and below with a step of at most `continuous`."""
    smooth = (a >= 0.0) & (a < EMPTY)
    smooth[:, :-1] &= np.abs(np.diff(a, axis=1) - 0.5 * (du[:, 1:] + du[:, :-1])) <= continuous
    smooth[:-1] &= np.abs(np.diff(a, axis=0) - 0.5 * (dv[1:] + dv[:-1])) <= continuous
    return smooth


def _largest(image: np.ndarray, empty: float, around: int) -> np.ndarray:
    """The largest in every square of STRIDE² of an image (h, w) and `around` texels beyond it; outside the image, in a rim of a window's
    width too, lies `empty`."""
    for axis in (0, 1):
        lines = np.moveaxis(image, axis, 0)
        count = -(-len(lines) // STRIDE) + 2 * (WINDOW // STRIDE)
        padded = np.full((count * STRIDE + 2 * around, lines.shape[1]), empty, np.float32)
        padded[WINDOW + around : WINDOW + around + len(lines)] = lines
        most = padded[: count * STRIDE : STRIDE]
        for beyond in range(1, STRIDE + 2 * around):
            most = np.maximum(most, padded[beyond : beyond + count * STRIDE : STRIDE])
        image = np.moveaxis(most, 0, axis)
    return image


def _of_neighbours(squares: np.ndarray, apart: int) -> np.ndarray:
    """The largest of every square and those `apart` to the right, below and both."""
    rows = np.maximum(squares[:-apart], squares[apart:])
    return np.maximum(rows[:, :-apart], rows[:, apart:])
