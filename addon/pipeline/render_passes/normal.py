"""The shading normal."""

import numpy as np

from ...images.passes import byte_picture
from .row import BlenderPass, RenderPass, floats


def picture(passes: dict[str, np.ndarray]) -> np.ndarray:
    """−1 … 1 as 0 … 255, black where there is no surface."""
    image = passes["normal"]
    return byte_picture(np.where((image == 0.0).all(axis=-1, keepdims=True), 0.0, image * 0.5 + 0.5))


ROW = RenderPass(
    name="normal",
    place=30,
    array="normal",
    shape="(h, w, 3)",
    text="The shading normal in world axes, towards the viewer; 0 where there is no surface",
    make=lambda shaded: np.ascontiguousarray(shaded.normals[..., :3]),
    picture=picture,
    channels=floats("RGB"),
    blender=BlenderPass("Normal", "XYZ", "VECTOR", 2, flag="use_pass_normal"),
)
