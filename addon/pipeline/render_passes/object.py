"""Which object is seen."""

import numpy as np

from ...images.passes import id_colors
from .row import RenderPass, numbers

ROW = RenderPass(
    name="object",
    place=40,
    array="object",
    shape="(h, w) int32",
    text="The object's number, −1 where there is none; in EXR unsigned and one higher",
    make=lambda shaded: np.ascontiguousarray(shaded.ids[..., 0]),
    picture=lambda passes: id_colors(passes["object"]),
    channels=numbers,
)
