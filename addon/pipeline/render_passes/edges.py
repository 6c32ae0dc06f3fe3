"""How much feature edges cover."""

from ...images.passes import byte_picture
from .row import RenderPass, floats

ROW = RenderPass(
    name="edges",
    place=80,
    array="edges",
    shape="(h, w)",
    text="How much feature edges cover of the pixel, 0 … 1, whatever their strength; averaged over the camera samples",
    make=lambda shaded: shaded.edges,
    picture=lambda passes: byte_picture(passes["edges"]),
    channels=floats("Y"),
    is_data=False,
    is_usual=False,
)
