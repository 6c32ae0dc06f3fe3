"""What of the sky reaches the pixels of a picture, and how shading looks it up. Worker thread only."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from ...maths.spaces import translation
from ...maths.view import Camera
from ..gl.programs import matrix_bytes
from .gbuffer import pixel_from_world


@dataclass(frozen=True, eq=False)
class SkyLight:
    """Sums with cosines (`reach_sums.frag`) at the places that a picture of `size` shows at its pixels' centres, counted from `origin_ws`.

    Whoever draws other samples of the same view looks at the pixels round each.
    """

    sums: moderngl.Texture
    place: moderngl.Texture
    plane: moderngl.Texture
    camera: Camera
    size: tuple[int, int]
    origin_ws: np.ndarray

    def inputs(self) -> dict[str, moderngl.Texture]:
        """The textures by sampler name."""
        return {"u_sky_sums": self.sums, "u_places": self.place, "u_planes": self.plane}

    def uniforms(self, origin_ws: np.ndarray) -> dict[str, object]:
        """For places relative to `origin_ws`."""
        return {
            "u_sky_pixel_from_world": matrix_bytes(pixel_from_world(self.camera, self.size) @ translation(origin_ws)),
            "u_sky_offset": tuple(self.origin_ws - origin_ws),
        }
