"""The aliasing error."""

import numpy as np

from ...images.heatmap import heat_map
from .row import BlenderPass, RenderPass, ShadedImages, floats

LAMP = np.array([-0.36, -0.48, 0.8], np.float32)  # that shades the heat map a little


def make(shaded: ShadedImages) -> np.ndarray:
    """(h, w, 3) m, m_x, m_z with NaN where there is no surface or no map."""
    image = np.ascontiguousarray(shaded.errors[..., :3])
    image[image < 0.0] = np.nan
    return image


def picture(passes: dict[str, np.ndarray]) -> np.ndarray:
    """The heat map of m over its legend; with the normals at hand the model's shape is seen."""
    normal = passes.get("normal")
    return heat_map(passes["aliasing"][..., 0], None if normal is None else 0.5 + 0.5 * normal @ LAMP)


ROW = RenderPass(
    name="aliasing",
    place=60,
    array="aliasing",
    shape="(h, w, 3)",
    text="The error m and the perspective m_x, m_z: picture pixels per texel of the map; NaN where there is no surface or no map",
    make=make,
    picture=picture,
    channels=floats("RGB"),
    blender=BlenderPass("Aliasing", "XYZ", "VECTOR", 4, lambda image: np.where(np.isnan(image), np.float32(0.0), image)),
)
