"""How surfaces answer light beside their colour, and what makes instances special. No bpy, no GL."""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace

import numpy as np

HIDDEN, NO_SHADOW, HOLDOUT, CATCHER, UNLIT, CAP, GROUND = 1, 2, 4, 8, 16, 32, 64
"""Flags of instances: not seen by the camera; casts no shadow; a hole in the picture; shows only shadows; not reached by the light;
the cap of a section; the ground under the model, of which nothing but shadows is seen."""
BEHIND, LIGHT_BEHIND = slice(8, 11), slice(12, 15)
"""Columns of a look in an array: how much of what lies behind it, and of the light, passes through."""


@dataclass(frozen=True, slots=True)
class Look:
    """Linear light. `weight` of the surface reflects: its colour as a diffuse surface under a coat of reflectance `f0` at normal
    incidence, or as a metal (`metallic` 1); `roughness` that of Blender, its square the α of GGX. `emission` radiance; `through` the part
    of what lies behind that passes to the eye, `light_through` that of the light, which tints its shadow; `hole` the part that is a hole
    in the picture."""

    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    weight: float = 1.0
    metallic: float = 0.0
    roughness: float = 1.0
    f0: float = 0.0
    through: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hole: float = 0.0
    light_through: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def numbers(self) -> np.ndarray:
        """(16,) float32, four texels on the GPU (`shaders/common_look.glsl`): emission, weight; metallic, roughness, f0, hole; through, 0;
        light_through, 0."""
        emission, weight, metallic, roughness, f0, through, hole, light_through = astuple(self)
        return np.array([*emission, weight, metallic, roughness, f0, hole, *through, 0.0, *light_through, 0.0], np.float32)

    def faded(self, opacity: float) -> Look:
        """The same surface, `opacity` of it there: the rest lets through what lies behind, and the light."""
        rest = (min(max(1.0 - opacity, 0.0), 1.0),) * 3
        return replace(self, weight=self.weight * (1.0 - rest[0]), through=rest, light_through=rest)


PLAIN = Look()
"""A diffuse surface."""
COATED = Look(roughness=0.5, f0=0.04)
"""Blender's default material."""
PLAIN_LOOKS = PLAIN.numbers()[None]
