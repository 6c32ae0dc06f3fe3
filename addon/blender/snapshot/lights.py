"""Blender lights as `Light`."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan, pi, tan

import bpy
import numpy as np

from ...errors import SceneError
from ...maths.view import Light
from ...scene.light_choice import FAINTEST, strength
from .node_maths import Unfollowable
from .nodes import Plug, Surroundings
from .shaders import closures

MAX_CONE_RAD = 1.5


def light_from_object(ob: bpy.types.Object, world_from_object: np.ndarray, origin_ws: np.ndarray) -> tuple[Light | None, str]:
    """The light and a warning ('' if none); None for a light that cannot be represented.

    A lamp shines along its local −Z, so the direction towards the light is its +Z. Colour: a sun's strength is its irradiance; a spot's
    or point's power P spreads over the sphere, P/4π W/m² at 1 m (the cone of a spot only cuts it); a panel's by Lambert over the half
    before it, P/π W/m² at 1 m before its middle.
    """
    data, name = ob.data, ob.name
    if getattr(getattr(data, "cycles", None), "is_portal", False):
        return None, ""
    axis = world_from_object[:3, 2]
    length = float(np.linalg.norm(axis))
    if not (np.isfinite(world_from_object).all() and length > 0.0):
        return None, f"Light '{name}' is scaled to zero or placed at infinity: left out."
    position = world_from_object[:3, 3] - origin_ws
    direction = axis / length
    factor, unknown = _by_nodes(data)
    warnings = f"Light '{name}' has nodes that cannot be followed ({unknown}): it shines without them." if unknown else ""
    common = {
        "color": tuple(c * f for c, f in zip(_color(data), factor, strict=True)),
        "name": name,
        "is_physical": True,
        "casts": bool(getattr(data, "use_shadow", True)),
    }
    if data.type == "SUN":
        return Light("sun", direction, None, half_angle_rad=min(max(float(data.angle) / 2.0, 0.0), pi / 2.0), **common), warnings
    if data.type == "POINT":
        return Light("point", None, position, radius=float(data.shadow_soft_size), **common), warnings
    if data.type == "SPOT":
        light, narrowed = _spot(data, name, world_from_object, direction, position, common)
        return light, narrowed or warnings
    half_spread = float(data.spread) / 2.0
    cone = min(max(half_spread, 1e-3), MAX_CONE_RAD)
    width, height = float(data.size), float(data.size_y if data.shape in ("RECTANGLE", "ELLIPSE") else data.size)
    common |= {
        "half_axes_ws": np.stack([0.5 * width * world_from_object[:3, 0], 0.5 * height * world_from_object[:3, 1]]),
        "is_round": data.shape in ("DISK", "ELLIPSE"),
    }
    return Light("spot", direction, position, cone, 0.0, spread_rad=half_spread, **common), warnings


def _spot(
    data: bpy.types.Light, name: str, world_from_object: np.ndarray, direction: np.ndarray, position: np.ndarray, common: dict[str, object]
) -> tuple[Light | None, str]:
    """A spot: its cone is as wide as its scale makes it."""
    linear, half = world_from_object[:3, :3], float(data.spot_size) / 2.0
    common = {**common, "radius": float(data.shadow_soft_size)}
    cone = min(half, MAX_CONE_RAD)
    warning = f"Spot '{name}' opens wider than 172°: taken as 172°." if half > MAX_CONE_RAD else ""
    scale = np.linalg.norm(linear, axis=0)
    if np.ptp(scale) <= 1e-6 * scale.max():
        return Light("spot", direction, position, cone, float(data.spot_blend), **common), warning
    if abs(np.linalg.det(linear)) < 1e-12 * scale.max() ** 3:
        return None, f"Light '{name}' is scaled to zero or placed at infinity: left out."
    inner = np.linalg.inv(linear)
    widest = atan(tan(cone) * float(scale[:2].max() / scale[2]))
    if widest > MAX_CONE_RAD:
        warning = f"Spot '{name}' opens wider than 172°: taken as 172°."
    return Light(
        "spot",
        direction,
        position,
        min(widest, MAX_CONE_RAD),
        float(data.spot_blend),
        local_from_world=inner,
        local_cone_rad=cone,
        **common,
    ), warning


def _by_nodes(data: bpy.types.Light) -> tuple[tuple[float, float, float], str]:
    """What a light's nodes multiply its colour by, and the type of a node that cannot be followed ('' if none)."""
    tree = data.node_tree if bpy.app.version >= (5, 0, 0) or data.use_nodes else None
    output = next((node for node in tree.nodes if node.type == "OUTPUT_LIGHT" and node.is_active_output), None) if tree else None
    if output is None:
        return (1.0, 1.0, 1.0), ""
    try:
        return closures(Plug(output.inputs["Surface"]), Surroundings()).emission, ""
    except Unfollowable as error:
        return (1.0, 1.0, 1.0), str(error)


def _color(data: bpy.types.Light) -> tuple[float, float, float]:
    color = np.array(data.color[:], dtype=np.float64)
    if getattr(data, "use_temperature", False):
        color *= np.array(data.temperature_color[:])
    strength = float(data.energy) * 2.0 ** float(getattr(data, "exposure", 0.0))
    if data.type != "SUN":
        strength /= pi if data.type == "AREA" else 4.0 * pi
    return tuple(float(c) * strength for c in color)


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
