"""Where the surface lies."""

import numpy as np

from ...images.passes import byte_picture
from ..passes.gbuffer import pixel_rays
from .row import BlenderPass, RenderPass, ShadedImages, floats


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w, 3) world coordinates as the user knows them, metres; 0 where there is no surface."""
    job, depth = shaded.job, shaded.normals[..., 3].astype(np.float64)
    height, width = depth.shape
    along, start = pixel_rays(job.camera, job.size)
    x, y = np.meshgrid(np.arange(width) + 0.5, height - np.arange(height) - 0.5)
    pixel = np.stack([x, y, np.ones_like(x)], axis=-1)
    points = pixel @ start.T + depth[..., None] * (pixel @ along.T) + job.scene.origin_ws
    return np.where(shaded.ids[..., :1] < 0, 0.0, points).astype(np.float32)


def picture(passes: dict[str, np.ndarray]) -> np.ndarray:
    """The box of all places seen as the colour cube."""
    image = passes["position"]
    low, high = image.min(axis=(0, 1)), image.max(axis=(0, 1))
    return byte_picture((image - low) / np.maximum(high - low, 1e-9))


ROW = RenderPass(
    name="position",
    place=74,
    array="position",
    shape="(h, w, 3)",
    text="The place of the surface in world axes, metres; 0 where there is none",
    make=make,
    picture=picture,
    channels=floats("RGB"),
    blender=BlenderPass("Position", "XYZ", "VECTOR", 74, flag="use_pass_position"),
    is_usual=False,
)
