"""Mattes of materials by their names."""

import numpy as np

from ...images.cryptomatte import ranked
from ...images.passes import id_colors
from .row import BlenderPass, RenderPass, ShadedImages, floats, materials_seen


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w, 4) the number of the name seen at the pixel's centre, and its coverage; 0, 0."""
    return ranked(materials_seen(shaded), tuple(name for name, _ in shaded.job.scene.materials))


def picture(passes: dict[str, np.ndarray]) -> np.ndarray:
    """One colour for each name."""
    _, index = np.unique(passes["cryptomatte_material"][..., 0], return_inverse=True)
    return id_colors(index.reshape(passes["cryptomatte_material"].shape[:2]) - 1)


ROW = RenderPass(
    name="cryptomatte-material",
    place=73,
    array="cryptomatte_material",
    shape="(h, w, 4)",
    text="Cryptomatte of materials: the number of the name seen at the pixel's centre, its coverage, 0, 0",
    make=make,
    picture=picture,
    channels=floats("RGBA"),
    blender=BlenderPass("CryptoMaterial00", "rgba", "COLOR", 73, flag="use_pass_cryptomatte_material"),
    is_usual=False,
)
