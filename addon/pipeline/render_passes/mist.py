"""How far into the World's mist the surface lies."""

import numpy as np

from ...images.passes import byte_picture
from ..passes.gbuffer import pixel_rays
from .row import BlenderPass, RenderPass, ShadedImages, floats

FALLOFFS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w) 0 before the mist begins, 1 where it ends and where there is no surface."""
    job, depth = shaded.job, shaded.normals[..., 3].astype(np.float64)
    begin, reach, falloff = job.scene.mist
    if not job.camera.is_orthographic:
        height, width = depth.shape
        along, _ = pixel_rays(job.camera, job.size)
        x, y = np.meshgrid(np.arange(width) + 0.5, height - np.arange(height) - 0.5)
        depth = depth * np.linalg.norm(np.stack([x, y, np.ones_like(x)], axis=-1) @ along.T, axis=-1)
    share = np.clip((depth - begin) / max(reach, 1e-9), 0.0, 1.0) ** FALLOFFS[falloff]
    return np.where(shaded.ids[..., 0] < 0, 1.0, share).astype(np.float32)


ROW = RenderPass(
    name="mist",
    place=75,
    array="mist",
    shape="(h, w)",
    text="The World's mist, 0 … 1; 1 where there is no surface",
    make=make,
    picture=lambda passes: byte_picture(passes["mist"]),
    channels=floats("Y"),
    blender=BlenderPass("Mist", "X", "VALUE", 75, flag="use_pass_mist"),
    is_usual=False,
)
