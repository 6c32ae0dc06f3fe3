"""Mattes of objects by their names."""

import numpy as np

from ...images.cryptomatte import ranked
from ...images.passes import id_colors
from .row import BlenderPass, RenderPass, ShadedImages, floats


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w, 4) the number of the name seen at the pixel's centre, and its coverage; 0, 0."""
    return ranked(shaded.ids[..., 0], shaded.job.scene.object_names)


def picture(passes: dict[str, np.ndarray]) -> np.ndarray:
    """One colour for each name."""
    _, index = np.unique(passes["cryptomatte_object"][..., 0], return_inverse=True)
    return id_colors(index.reshape(passes["cryptomatte_object"].shape[:2]) - 1)


ROW = RenderPass(
    name="cryptomatte-object",
    place=72,
    array="cryptomatte_object",
    shape="(h, w, 4)",
    text="Cryptomatte of objects: the number of the name seen at the pixel's centre, its coverage, 0, 0",
    make=make,
    picture=picture,
    channels=floats("RGBA"),
    blender=BlenderPass("CryptoObject00", "rgba", "COLOR", 72, flag="use_pass_cryptomatte_object"),
    is_usual=False,
)
