"""The index that its author gave the object that is seen."""

import numpy as np

from ...images.passes import id_colors
from .row import BlenderPass, RenderPass, ShadedImages, floats


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w) float32 whole numbers."""
    scene = shaded.job.scene
    return np.where(shaded.ids[..., 0] < 0, 0, scene.object_index[shaded.ids[..., 0]]).astype(np.float32)


ROW = RenderPass(
    name="object-index",
    place=77,
    array="object_index",
    shape="(h, w)",
    text="Blender's Pass Index of the object seen; 0 where there is none",
    make=make,
    picture=lambda passes: id_colors(passes["object_index"].astype(np.int32) - 1),
    channels=floats("Y"),
    blender=BlenderPass("Object Index", "X", "VALUE", 77, flag="use_pass_object_index", old_name="IndexOB"),
    is_usual=False,
)
