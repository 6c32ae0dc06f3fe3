"""The lit picture."""

import numpy as np

from ...images.passes import byte_picture
from ...images.srgb import srgb
from ...settings.groups import ShadingChoice
from .row import BlenderPass, RenderPass, floats


def exposed(combined: np.ndarray | None, shading: ShadingChoice) -> np.ndarray | None:
    """The picture (h, w, 4) 2^`exposure` times as bright, its alpha as it is; pictures of data are not exposed."""
    if combined is None or shading.exposure == 0.0 or shading.display != "shaded":
        return combined
    factor = np.float32(2.0**shading.exposure)
    return combined * np.array([factor, factor, factor, 1.0], np.float32)


ROW = RenderPass(
    name="combined",
    place=0,
    array="combined",
    shape="(h, w, 4)",
    text="The lit picture, scene linear, with alpha; as PNG through the scene's view transform",
    make=lambda shaded: exposed(shaded.combined, shaded.job.settings.shading),
    picture=lambda passes: byte_picture(srgb(passes["combined"])),
    channels=floats("RGBA"),
    blender=BlenderPass("Combined", "RGBA", "COLOR", 0),
    is_data=False,
)
