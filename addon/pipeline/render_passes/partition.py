"""Which shadow map serves."""

import numpy as np

from ...images.passes import id_colors
from .row import RenderPass, numbers

ROW = RenderPass(
    name="partition",
    place=50,
    array="partition",
    shape="(h, w) int32",
    text="The shadow map that serves the pixel, −1 for none; in EXR unsigned and one higher",
    make=lambda shaded: np.ascontiguousarray(shaded.ids[..., 1]),
    picture=lambda passes: id_colors(passes["partition"]),
    channels=numbers,
)
