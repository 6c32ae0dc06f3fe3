"""The shadow maps themselves."""

import numpy as np

from ...images.passes import depth_picture
from .row import RenderPass, ShadedImages

NEVER_DRAWN = 1.0  # what a map is cleared to: the depth of its far end


def make(shaded: ShadedImages) -> np.ndarray | None:
    """(k, N, N) depths 0…1, row 0 at t = −1; None without a light."""
    return shaded.shadow_maps() if shaded.shadow_maps is not None else None


def picture(passes: dict[str, np.ndarray]) -> np.ndarray:
    """The maps side by side, black where nothing casts."""
    layers = passes["shadow_depth"]
    return np.concatenate([depth_picture(np.where(layer < NEVER_DRAWN, layer, np.inf)) for layer in layers], axis=1)


def channels(image: np.ndarray) -> dict[str, np.ndarray]:
    """map0.Depth.Z, map1.Depth.Z, …"""
    return {f"map{i}.Depth.Z": layer.astype(np.float32) for i, layer in enumerate(image)}


ROW = RenderPass(
    name="texel",
    place=70,
    array="shadow_depth",
    shape="(k, N, N)",
    text="The depths of the shadow maps, 0 … 1, 1 where nothing casts",
    make=make,
    picture=picture,
    channels=channels,
    is_data=False,
    is_usual=False,
)
