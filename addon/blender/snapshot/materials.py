"""Materials as `Look`s: what a surface reflects, emits and lets through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...scene.looks import COATED, PLAIN, Look
from .node_maths import Unfollowable
from .nodes import Plug, Surroundings
from .shaders import BLACK, Closures, Rgb, closures

DEFAULT_COLOR = (0.8, 0.8, 0.8, 1.0)
FAINTEST = 0.004
"""Opacity of a surface that is as good as not there: less than a step of an 8-bit picture."""
Color = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Paint:
    """What one material slot looks like: its colour (linear, with opacity) and the rest. `is_solid` False: there is no surface at all.

    `varied`: the colours where what varies over the surface (a picture, an attribute) is black and where it is white.
    `name` and `index`: what the author calls the material.
    """

    color: Color = DEFAULT_COLOR
    look: Look = COATED
    is_solid: bool = True
    varied: tuple[Color, Color] | None = None
    name: str = ""
    index: int = 0

    def where(self, varying: np.ndarray) -> Paint:
        """The paint where what varies has a linear colour (3,): nodes that multiply and mix are linear in it."""
        if self.varied is None:
            return self
        black, white = (np.array(color[:3]) for color in self.varied)
        return replace(self, color=(*(float(c) for c in black + (white - black) * varying), self.color[3]))


@dataclass(frozen=True, slots=True)
class Followed:
    """A material's paint; `is_followed` False: it is its viewport colour, the tree cannot be followed. `asks`: it depends on the object."""

    paint: Paint
    is_followed: bool = True
    asks: bool = False


def paint_of(material: bpy.types.Material | None, ob: bpy.types.Object | None = None, random: float = 0.0) -> Followed:
    """The paint of a material on an object (None: one that asks nothing of it), from its node tree; without nodes its viewport colour."""
    if material is None:
        return Followed(Paint(look=COATED if bpy.app.version >= (5, 0, 0) else PLAIN))
    found = _followed(material, ob, random)
    return replace(found, paint=replace(found.paint, name=material.name, index=material.pass_index))


def _followed(material: bpy.types.Material, ob: bpy.types.Object | None, random: float) -> Followed:
    if material.node_tree is None or (bpy.app.version < (5, 0, 0) and not material.use_nodes):
        return Followed(Paint(tuple(material.diffuse_color), plain_look(material)))
    output = material.node_tree.get_output_node("ALL")
    if output is None:
        return Followed(Paint((0.0, 0.0, 0.0, 1.0), PLAIN))
    around, surface = Surroundings(ob, random), Plug(output.inputs["Surface"])
    try:
        seen = closures(surface, around)
        light = closures(surface, Surroundings(ob, random, is_shadow=True)).through if around.tells_rays_apart else seen.through
    except Unfollowable:
        return Followed(viewport_paint(material.diffuse_color, plain_look(material)), False, around.asked)
    if not getattr(material, "use_transparent_shadow", True):
        light = BLACK
    if seen == Closures():
        is_volume = output.inputs["Volume"].is_linked
        return Followed(Paint((0.0, 0.0, 0.0, 1.0), PLAIN, not is_volume), asks=around.asked)
    return Followed(_varied(_paint(seen, light), material, around), asks=around.asked)


def _varied(paint: Paint, material: bpy.types.Material, around: Surroundings) -> Paint:
    """The paint with its colours where what varies is black and white, if anything does."""
    if not around.varies or not paint.is_solid:
        return paint
    socket = material.node_tree.get_output_node("ALL").inputs["Surface"]
    worn = [Surroundings(around.object, around.random, varying=end) for end in (0.0, 1.0)]
    ends = [_paint(closures(Plug(socket), one), BLACK).color for one in worn]
    return replace(paint, varied=tuple(ends))


def plain_look(material: bpy.types.Material) -> Look:
    """The look that the viewport's settings of a material give."""
    return Look(metallic=float(material.metallic), roughness=float(material.roughness), f0=COATED.f0)


def viewport_paint(color: Sequence[float], look: Look = COATED) -> Paint:
    """A colour with an opacity, as the viewport shows it."""
    red, green, blue, opacity = map(float, color)
    return Paint((red, green, blue, opacity), look.faded(opacity), opacity >= FAINTEST)


def _paint(seen: Closures, light: Rgb) -> Paint:
    """What is seen, and the part of the `light` that passes."""
    through, light = (tuple(min(c, 1.0) for c in rgb) for rgb in (seen.through, light))
    opacity = 1.0 - sum(through) / 3.0
    is_there = max(1.0 - min(*through, *light), seen.weight, *seen.emission) >= FAINTEST
    look = Look(seen.emission, seen.weight, seen.metallic, seen.roughness, seen.f0, through, seen.hole, light)
    return Paint((*seen.color, opacity), look, is_there)
