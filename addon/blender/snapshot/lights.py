"""Blender lights as `Light`."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import bpy
import numpy as np

from ...errors import SceneError
from ...maths.view import Light

MAX_CONE_RAD = 1.5
FAINTEST = 0.05


def light_from_object(ob: bpy.types.Object, world_from_object: np.ndarray, origin_ws: np.ndarray) -> tuple[Light | None, str]:
    """The light and a warning ('' if none); None for a light that cannot be represented.

    A lamp shines along its local −Z, so the direction towards the light is its +Z. Colour: a sun's strength is its irradiance; a spot's
    or point's power P spreads over the sphere, P/4π W/m² at 1 m (the cone of a spot only cuts it). Area lights count as spots of 60°.
    """
    data, name = ob.data, ob.name
    axis = world_from_object[:3, 2]
    length = float(np.linalg.norm(axis))
    if not (np.isfinite(world_from_object).all() and length > 0.0):
        return None, f"Light '{name}' is scaled to zero or placed at infinity: left out."
    position = world_from_object[:3, 3] - origin_ws
    direction = axis / length
    color = _color(data)
    if data.type == "SUN":
        return Light("sun", direction, None, color=color, name=name, is_physical=True), ""
    if data.type == "POINT":
        return Light("point", None, position, color=color, name=name, is_physical=True), ""
    if data.type == "SPOT":
        cone = float(data.spot_size) / 2.0
        warning = f"Spot '{name}' opens wider than 172°: taken as 172°." if cone > MAX_CONE_RAD else ""
        return Light("spot", direction, position, min(cone, MAX_CONE_RAD), float(data.spot_blend), color, name, True), warning
    return Light(
        "spot", direction, position, pi / 3, 0.5, color, name, True
    ), f"Area light '{name}' is taken as a spot of 120° at its centre."


def _color(data: bpy.types.Light) -> tuple[float, float, float]:
    color = np.array(data.color[:], dtype=np.float64)
    if getattr(data, "use_temperature", False):
        color *= np.array(data.temperature_color[:])
    strength = float(data.energy) * 2.0 ** float(getattr(data, "exposure", 0.0))
    if data.type != "SUN":
        strength /= 4.0 * pi
    return tuple(float(c) * strength for c in color)


def strength(light: Light) -> float:
    """Sum of the colour's channels: what 'the strongest' compares."""
    return sum(light.color)


def reaches(light: Light, bounds_ws: np.ndarray) -> bool:
    """Whether a light lights the scene at all: a sun always, others when the mean of their channels at the middle of `bounds_ws` (2, 3), or
    at half its diagonal when they stand nearer, is at least `FAINTEST` of a sun of strength 1."""
    if light.kind == "sun":
        return True
    radius = float(np.linalg.norm(bounds_ws[1] - bounds_ws[0])) / 2.0
    distance = max(float(np.linalg.norm(light.position_ws - bounds_ws.mean(axis=0))), radius, 1e-6)
    return strength(light) / 3.0 >= FAINTEST * distance**2


def choose_light(lights: Sequence[Light], name: str | None = None) -> Light | None:
    """The light of that name, else the strongest sun, else the first light, else None; raises `SceneError` for an unknown name."""
    if name is not None:
        for light in lights:
            if light.name == name:
                return light
        known = ", ".join(light.name for light in lights) or "none"
        raise SceneError(f"There is no sun, spot or point light '{name}' in the scene: choose one of: {known}.")
    suns = [light for light in lights if light.kind == "sun"]
    return max(suns, key=strength) if suns else (lights[0] if lights else None)
