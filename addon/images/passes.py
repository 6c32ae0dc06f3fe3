"""Every pass as something to look at (PNG) and as exact values (EXR)."""

from __future__ import annotations

import numpy as np

from .heatmap import NOTHING, heat_map

NEVER_DRAWN = 1.0
"""What a shadow map is cleared to: the depth of its far end."""
_GOLDEN = 0.6180339887498949
EXR_CHANNELS = {
    "combined": "RGBA",
    "normal": "RGB",
    "shadow": "Y",
    "depth": "Z",
    "object": "Y",
    "partition": "Y",
    "aliasing": "RGB",
}


def picture_of(name: str, passes: dict[str, np.ndarray]) -> np.ndarray:
    """uint8 or uint16 image of pass `name`: shadow grey, depth nearest white, ids in distinct colours, aliasing a heat map.

    Of shadow maps (texel) the depths side by side, black where nothing casts.
    """
    image = passes["shadow_depth" if name == "texel" else name]
    if name == "shadow":
        return _bytes(image)
    if name == "depth":
        return depth_picture(image)
    if name == "normal":
        return _bytes(np.where((image == 0.0).all(axis=-1, keepdims=True), 0.0, image * 0.5 + 0.5))
    if name in ("object", "partition"):
        return id_colors(image)
    if name == "texel":
        return np.concatenate([depth_picture(np.where(layer < NEVER_DRAWN, layer, np.inf)) for layer in image], axis=1)
    normal = passes.get("normal")
    return heat_map(image[..., 0], None if normal is None else 0.5 + 0.5 * normal @ np.array([-0.36, -0.48, 0.8], np.float32))


def _bytes(image: np.ndarray) -> np.ndarray:
    return np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)


def depth_picture(depth: np.ndarray) -> np.ndarray:
    """uint16 grey: the nearest depth white, the farthest dark grey, nothing (inf) black. Linear in depth."""
    seen = np.isfinite(depth)
    if not seen.any():
        return np.zeros(depth.shape, np.uint16)
    near, far = float(depth[seen].min()), float(depth[seen].max())
    level = np.where(seen, 1.0 - 0.9 * (np.where(seen, depth, near) - near) / max(far - near, 1e-30), 0.0)
    return np.rint(level * 65535.0).astype(np.uint16)


def id_colors(ids: np.ndarray) -> np.ndarray:
    """(h, w, 3) uint8: one colour per number, neighbours far apart (hues by the golden ratio); −1 grey."""
    numbers, index = np.unique(ids, return_inverse=True)
    hue = (numbers.astype(np.float64) * _GOLDEN) % 1.0
    wave = 0.5 + 0.5 * np.cos(2.0 * np.pi * (hue[:, None] + np.array([0.0, 2.0 / 3.0, 1.0 / 3.0])))
    value = np.where(numbers % 2 == 0, 0.95, 0.75)
    colors = np.rint(255.0 * value[:, None] * (0.25 + 0.75 * wave)).astype(np.uint8)
    colors[numbers < 0] = NOTHING
    return colors[index.reshape(ids.shape)]


def channels_of(name: str, passes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The pass as EXR channels (h, w), values untouched.

    Normals x, y, z and errors m, m_x, m_z are R, G, B; ids are unsigned, one higher (0 = nothing).
    Shadow maps are map0.Depth.Z, map1.Depth.Z, …
    """
    if name == "texel":
        return {f"map{i}.Depth.Z": layer.astype(np.float32) for i, layer in enumerate(passes["shadow_depth"])}
    image = passes[name]
    if name in ("object", "partition"):
        return {"Y": (image + 1).astype(np.uint32)}
    planes = image.reshape(*image.shape[:2], -1)
    return {channel: np.ascontiguousarray(planes[..., i], dtype=np.float32) for i, channel in enumerate(EXR_CHANNELS[name])}
