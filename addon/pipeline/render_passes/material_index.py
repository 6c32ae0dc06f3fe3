"""The index that its author gave the material that is seen."""

import numpy as np

from ...images.passes import id_colors
from .row import BlenderPass, RenderPass, ShadedImages, floats


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w) float32 whole numbers."""
    scene = shaded.job.scene
    return np.where(
        shaded.ids[..., 0] < 0, 0, np.array([index for _, index in scene.materials], np.int32)[scene.instances.material[shaded.ids[..., 2]]]
    ).astype(np.float32)


ROW = RenderPass(
    name="material-index",
    place=71,
    array="material_index",
    shape="(h, w)",
    text="Blender's Pass Index of the material seen; 0 where there is none",
    make=make,
    picture=lambda passes: id_colors(passes["material_index"].astype(np.int32) - 1),
    channels=floats("Y"),
    blender=BlenderPass("Material Index", "X", "VALUE", 71, flag="use_pass_material_index", old_name="IndexMA"),
    is_usual=False,
)
