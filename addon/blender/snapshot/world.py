"""A scene's world as what surrounds it: a colour for its upper half, one for its lower, one behind everything."""

from __future__ import annotations

import bpy
import numpy as np

from ...settings.groups import BRIGHTEST, ShadingWorld
from .node_maths import Unfollowable
from .nodes import Plug, Surroundings, number, origin
from .pictures import mean_halves
from .shaders import closures

NOT_FOLLOWED = "World '{}' is lit by nodes that cannot be followed here ({}): its viewport colour is used."


def world_of(world: bpy.types.World | None) -> tuple[ShadingWorld, str]:
    """What a world is for the picture, and a warning ('' if none). A scene without a world has the surroundings of a CAD file."""
    if world is None:
        return ShadingWorld(), ""
    if world.node_tree is None or (bpy.app.version < (5, 0, 0) and not world.use_nodes):
        return _even(np.array(world.color[:])), ""
    output = world.node_tree.get_output_node("ALL")
    if output is None:
        return _even(np.zeros(3)), ""
    try:
        return _followed(Plug(output.inputs["Surface"])), ""
    except Unfollowable as error:
        return _even(np.array(world.color[:])), NOT_FOLLOWED.format(world.name, error)


def _followed(surface: Plug) -> ShadingWorld:
    place = origin(surface)
    node = place.socket.node if place.socket.is_output else None
    if node is not None and node.type == "BACKGROUND":
        paint = origin(Plug(node.inputs["Color"], place.groups))
        image = paint.socket.node if paint.socket.is_output and paint.socket.node.type == "TEX_ENVIRONMENT" else None
        if image is not None:
            return _pictured(image, number(Plug(node.inputs["Strength"], place.groups), Surroundings()))
    return _even(np.array(closures(surface, Surroundings()).emission))


def _pictured(node: bpy.types.Node, strength: float) -> ShadingWorld:
    """Of a picture all around: the means of its halves, and behind everything their mean."""
    halves = mean_halves(node.image) if node.projection == "EQUIRECTANGULAR" else None
    if halves is None:
        raise Unfollowable(node.type)
    upper, lower = halves * strength
    return ShadingWorld(_limited(upper), _limited(lower), (*_limited((upper + lower) / 2.0), 1.0))


def _even(radiance: np.ndarray) -> ShadingWorld:
    same = _limited(radiance)
    return ShadingWorld(same, same, (*same, 1.0))


def _limited(radiance: np.ndarray) -> tuple[float, float, float]:
    return tuple(float(min(max(c, 0.0), BRIGHTEST)) for c in radiance)
