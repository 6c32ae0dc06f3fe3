"""The mean colours of Blender's images, kept while the image does not change."""

from __future__ import annotations

import bpy
import numpy as np

from ...images.srgb import linear_from_srgb

MOST_PIXELS = 1 << 24
KEPT = 256
SAMPLED = 512
LINEAR = ("Linear", "Non-Color", "Raw", "Generic Data")
_means: dict[tuple, np.ndarray | None] = {}
_halves: dict[tuple, np.ndarray | None] = {}
_whole: dict[tuple, np.ndarray | None] = {}
KEPT_WHOLE = 32


def mean_color(image: bpy.types.Image | None) -> np.ndarray | None:
    """(4,) the mean of an image in scene-linear colour, weighted by its opacity, and its mean opacity; None where it cannot be read."""
    return _kept(_means, image, _mean)


def mean_halves(image: bpy.types.Image | None) -> np.ndarray | None:
    """(2, 3) the mean radiance of the upper and the lower half of the world that an equirectangular image surrounds; None: unreadable."""
    return _kept(_halves, image, _half_means)


def pixels_of(image: bpy.types.Image | None) -> np.ndarray | None:
    """(h, w, 4) an image in scene-linear colour, row 0 at the bottom, of at most `SAMPLED` a side; None where it cannot be read."""
    if len(_whole) >= KEPT_WHOLE:
        _whole.clear()
    return _kept(_whole, image, lambda pixels: pixels.astype(np.float32))


def _kept(kept: dict, image: bpy.types.Image | None, make: object) -> np.ndarray | None:
    if image is None:
        return None
    image = image.original if image.original is not None else image
    key = image.session_uid, image.filepath, image.source, tuple(image.size), image.colorspace_settings.name, image.is_dirty
    if key not in kept or image.is_dirty:
        if len(kept) >= KEPT:
            kept.clear()
        pixels = _pixels(image)
        kept[key] = None if pixels is None else make(pixels)
    return kept[key]


def _pixels(image: bpy.types.Image) -> np.ndarray | None:
    """(h, w, 4) scene-linear, row 0 at the bottom, of at most `SAMPLED` a side."""
    (width, height), channels = image.size, image.channels
    if not 0 < width * height <= MOST_PIXELS:
        return None
    flat = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(flat)
    some = flat.reshape(height, width, channels)[:: -(-height // SAMPLED), :: -(-width // SAMPLED)]
    pixels = np.ones((*some.shape[:2], 4))
    pixels[..., :3] = np.nan_to_num(some[..., :3] if channels >= 3 else some[..., :1])
    if channels == 4:
        pixels[..., 3] = np.nan_to_num(some[..., 3])
    if not (image.is_float or image.colorspace_settings.name.startswith(LINEAR)):
        pixels = linear_from_srgb(pixels)
    return pixels


def _mean(pixels: np.ndarray) -> np.ndarray:
    alpha = pixels[..., 3]
    opaque = float(alpha.mean(dtype=np.float64))
    weight = alpha if opaque > 0.0 else np.ones_like(alpha)
    mean = np.einsum("ijk,ij->k", pixels[..., :3].astype(np.float64), weight.astype(np.float64)) / weight.sum(dtype=np.float64)
    return np.array([*mean, opaque])


def _half_means(pixels: np.ndarray) -> np.ndarray:
    """Rows weighted by the cosine law of a horizontal surface: by sin·cos of the elevation."""
    elevation = ((np.arange(len(pixels)) + 0.5) / len(pixels) - 0.5) * np.pi
    rows = pixels[..., :3].mean(axis=1, dtype=np.float64)
    weight = np.abs(np.sin(elevation) * np.cos(elevation))
    upper = elevation > 0.0
    halves = [(rows[part] * weight[part, None]).sum(axis=0) / weight[part].sum() for part in (upper, ~upper)]
    return np.array(halves)
