"""Materials as `Look`s: what a surface reflects, emits and lets through."""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...scene.looks import COATED, PLAIN, Look
from .nodes import Plug, Surroundings, Unfollowable
from .shaders import Closures, closures

DEFAULT_COLOR = (0.8, 0.8, 0.8, 1.0)
FAINTEST = 0.004
"""Opacity of a surface that is as good as not there: less than a step of an 8-bit picture."""
LETS_LIGHT_THROUGH = 0.5
"""Opacity below which a surface casts no shadow."""
OPAQUE = 0.99
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
    around = Surroundings(ob, random)
    try:
        seen = closures(Plug(output.inputs["Surface"]), around)
    except Unfollowable:
        return Followed(Paint(tuple(material.diffuse_color), plain_look(material)), False, around.asked)
    if seen == Closures():
        is_volume = output.inputs["Volume"].is_linked
        return Followed(Paint((0.0, 0.0, 0.0, 1.0), PLAIN, not is_volume), asks=around.asked)
    return Followed(_varied(_paint(seen), material, around), asks=around.asked)


def _varied(paint: Paint, material: bpy.types.Material, around: Surroundings) -> Paint:
    """The paint with its colours where what varies is black and white, if anything does."""
    if not around.varies or not paint.is_solid:
        return paint
    socket = material.node_tree.get_output_node("ALL").inputs["Surface"]
    ends = [_paint(closures(Plug(socket), Surroundings(around.object, around.random, varying=end))).color for end in (0.0, 1.0)]
    return replace(paint, varied=tuple(ends))


def plain_look(material: bpy.types.Material) -> Look:
    """The look that the viewport's settings of a material give."""
    return Look(metallic=float(material.metallic), roughness=float(material.roughness), f0=COATED.f0)


def _paint(seen: Closures) -> Paint:
    opacity = 1.0 - min(max(seen.through), 1.0)
    if opacity < FAINTEST and seen.weight < FAINTEST:
        return Paint((*seen.through, opacity), PLAIN, False)
    tinted = seen.weight < FAINTEST and seen.emission == (0.0, 0.0, 0.0) and seen.hole == 0.0
    color, weight = (seen.through, 1.0) if tinted else (seen.color, seen.weight / max(opacity, FAINTEST))
    look = Look(seen.emission, weight, seen.metallic, seen.roughness, seen.f0, (0.0, 0.0, 0.0), seen.hole)
    return Paint((*color, opacity), look)
