"""What surfaces glow by themselves."""

import numpy as np

from ...images.passes import byte_picture
from ...images.srgb import srgb
from .row import BlenderPass, RenderPass, ShadedImages, floats


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w, 3) radiance, scene linear; 0 where nothing glows."""
    scene = shaded.job.scene
    glow = scene.looks[scene.instances.look[shaded.ids[..., 2]]][..., :3]
    return np.where(shaded.ids[..., :1] < 0, np.float32(0.0), glow)


ROW = RenderPass(
    name="emission",
    place=76,
    array="emission",
    shape="(h, w, 3)",
    text="What the surface glows by itself, scene linear",
    make=make,
    picture=lambda passes: byte_picture(srgb(passes["emission"])),
    channels=floats("RGB"),
    blender=BlenderPass("Emission", "RGB", "COLOR", 76, flag="use_pass_emit", old_name="Emit"),
    is_usual=False,
)
