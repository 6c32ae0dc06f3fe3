"""How open each place is to light from all round: ambient occlusion."""

import numpy as np

from ...images.passes import byte_picture
from .row import BlenderPass, RenderPass, floats


def grey(image: np.ndarray) -> np.ndarray:
    """(h, w, 3): a colour, as Blender's own engines have it."""
    return np.repeat(image[..., None], 3, axis=-1)


ROW = RenderPass(
    name="ao",
    place=85,
    array="ao",
    shape="(h, w)",
    text="The share of light from all round that reaches the surface, weighted by the cosine: 1 in the open and where there is no surface. "
    "Near and far, by a shadow map for each of the sky's samples",
    make=lambda shaded: shaded.ao,
    picture=lambda passes: byte_picture(passes["ao"]),
    channels=floats("Y"),
    blender=BlenderPass("Ambient Occlusion", "RGB", "COLOR", 85, grey, "use_pass_ambient_occlusion", "AO"),
    is_data=False,
    is_usual=False,
)
