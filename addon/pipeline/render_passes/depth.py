"""The distance along the view axis."""

import numpy as np

from ...images.passes import depth_picture
from .row import BlenderPass, RenderPass, ShadedImages, floats

NOTHING_HERE = np.float32(1e10)  # what Blender's own engines write as the depth of the background


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w) metres, inf where there is no surface."""
    return np.where(shaded.ids[..., 0] < 0, np.float32(np.inf), shaded.normals[..., 3])


ROW = RenderPass(
    name="depth",
    place=20,
    array="depth",
    shape="(h, w)",
    text="The distance along the view axis, metres; inf where there is no surface. As PNG the nearest white",
    make=make,
    picture=lambda passes: depth_picture(passes["depth"]),
    channels=floats("Z"),
    blender=BlenderPass("Depth", "Z", "VALUE", 1, lambda image: np.where(np.isfinite(image), image, NOTHING_HERE), "use_pass_z"),
)
