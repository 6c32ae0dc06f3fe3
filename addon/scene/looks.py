"""How surfaces answer light beside their colour, and what makes instances special. No bpy, no GL."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np

LOOK_NUMBERS = 12
"""Of a look in an array: three texels on the GPU (`shaders/common_look.glsl`)."""
HIDDEN, NO_SHADOW, HOLDOUT, CATCHER, UNLIT, CAP, GROUND = 1, 2, 4, 8, 16, 32, 64
"""Flags of instances: not seen by the camera; casts no shadow; a hole in the picture; shows only shadows; not reached by the light;
the cap of a section; the ground under the model, of which nothing but shadows is seen."""


@dataclass(frozen=True, slots=True)
class Look:
    """Linear light. `weight` of the surface reflects: its colour as a diffuse surface under a coat of reflectance `f0` at normal
    incidence, or as a metal (`metallic` 1); `roughness` that of Blender, its square the α of GGX. `emission` radiance; `through` the part
    of what lies behind that passes; `hole` the part that is a hole in the picture."""

    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    weight: float = 1.0
    metallic: float = 0.0
    roughness: float = 1.0
    f0: float = 0.0
    through: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hole: float = 0.0

    def numbers(self) -> np.ndarray:
        """(12,) float32: emission, weight; metallic, roughness, f0, hole; through, 0."""
        emission, weight, metallic, roughness, f0, through, hole = astuple(self)
        return np.array([*emission, weight, metallic, roughness, f0, hole, *through, 0.0], np.float32)


PLAIN = Look()
"""A diffuse surface."""
COATED = Look(roughness=0.5, f0=0.04)
"""Blender's default material."""
PLAIN_LOOKS = PLAIN.numbers()[None]
