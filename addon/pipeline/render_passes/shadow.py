"""The light that the shadow lets through."""

import numpy as np

from ...images.passes import byte_picture
from .row import BlenderPass, RenderPass, floats

ROW = RenderPass(
    name="shadow",
    place=10,
    array="shadow",
    shape="(h, w)",
    text="The light that arrives, 0 … 1; 1 where there is no surface",
    make=lambda shaded: np.ascontiguousarray(shaded.errors[..., 3]),
    picture=lambda passes: byte_picture(passes["shadow"]),
    channels=floats("Y"),
    blender=BlenderPass("Shadow", "X", "VALUE", 3, flag="use_pass_shadow"),
)
