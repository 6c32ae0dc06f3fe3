"""The lit picture."""

from ...images.passes import byte_picture
from ...images.srgb import srgb
from .row import BlenderPass, RenderPass, floats

ROW = RenderPass(
    name="combined",
    place=0,
    array="combined",
    shape="(h, w, 4)",
    text="The lit picture, scene linear, with alpha; as PNG through the scene's view transform",
    make=lambda shaded: shaded.combined,
    picture=lambda passes: byte_picture(srgb(passes["combined"])),
    channels=floats("RGBA"),
    blender=BlenderPass("Combined", "RGBA", "COLOR", 0),
    is_data=False,
)
