"""Node trees followed to constants: what a socket holds where nothing on the way to it varies over the surface.

Links are followed through reroutes, groups and muted nodes as Blender does. What varies (an image, a colour attribute) gives its mean,
or what `varying` says; what cannot be known without rendering raises `Unfollowable`. `shaders` reads materials and worlds with it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Color as HsvColor

from .node_maths import MATH, VECTORS, Unfollowable, Value, blackbody, blended, hsl_of, hsv_of, rgb_of, rgb_of_hsl
from .pictures import mean_color
from .vertex_colors import mean_attribute

GREY = np.array([0.2126, 0.7152, 0.0722])  # luminance of linear Rec. 709
DEEPEST = 64
Groups = tuple[bpy.types.Node, ...]


@dataclass(frozen=True, slots=True)
class Plug:
    """A socket, inside the groups that lead to it."""

    socket: bpy.types.NodeSocket
    groups: Groups = ()


@dataclass(eq=False)
class Surroundings:
    """What nodes may ask of the object that wears a material, and of the ray. `asked`: whether of the object; `varies`: of its surface;
    `tells_rays_apart`: of the ray."""

    object: bpy.types.Object | None = None
    random: float = 0.0
    is_shadow: bool = False
    varying: float | None = None  # what images and attributes give, instead of their mean
    asked: bool = field(default=False)
    varies: bool = field(default=False)
    tells_rays_apart: bool = field(default=False)

    def ask(self) -> bpy.types.Object | None:
        """The object; from now on the answer holds for it alone."""
        self.asked = True
        return self.object


def origin(place: Plug) -> Plug:
    """Where the value of an input comes from: an output of a node that makes values, or an input that nothing is linked to.

    Where reroutes and muted nodes lead to nothing the input that they lead from keeps its own value.
    """
    own = place
    for _ in range(DEEPEST):
        link = next((one for one in place.socket.links if one.is_valid and not one.is_muted), None) if place.socket.is_linked else None
        if link is None:
            return own
        passed = _passed(link.from_node, link.from_socket, place.groups)
        if passed is None:
            return Plug(link.from_socket, place.groups)
        if passed.socket is None:
            return own
        place = passed
        if link.from_node.type in ("GROUP", "GROUP_INPUT") and not link.from_node.mute:
            own = place
    return own


def _passed(node: bpy.types.Node, out: bpy.types.NodeSocket, groups: Groups) -> Plug | None:
    """The input that a node hands on unchanged at `out`; None for a node that makes a value of its own.

    A plug without a socket: it hands on nothing.
    """
    if node.mute:
        inner = next((one.from_socket for one in node.internal_links if one.to_socket == out), None)
        return Plug(inner, groups)
    if node.type == "REROUTE":
        return Plug(node.inputs[0], groups)
    if node.type == "GROUP_INPUT":
        return Plug(_by_identifier(groups[-1].inputs, out.identifier), groups[:-1]) if groups else Plug(None)
    if node.type == "GROUP":
        inside = node.node_tree and next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
        return Plug(_by_identifier(inside.inputs, out.identifier) if inside else None, (*groups, node))
    return None


def _by_identifier(sockets: bpy.types.NodeInputs, identifier: str) -> bpy.types.NodeSocket | None:
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def number(place: Plug, around: Surroundings) -> float:
    """A socket as a number; of a colour its luminance. Raises `Unfollowable`."""
    found = value(place, around)
    return float(found) if found.ndim == 0 else float(found[:3] @ GREY)


def color(place: Plug, around: Surroundings) -> Value:
    """A socket as a linear colour (3,); of a number grey. Raises `Unfollowable`."""
    found = value(place, around)
    return np.full(3, float(found)) if found.ndim == 0 else found[:3]


def value(place: Plug, around: Surroundings) -> Value:
    """What a socket holds. Raises `Unfollowable`."""
    place = origin(place)
    socket = place.socket
    if not socket.is_output:
        default = getattr(socket, "default_value", None)
        if default is None or isinstance(default, str):
            raise Unfollowable(socket.node.type)
        return np.array(default if isinstance(default, float | int) else default[:3], np.float64)
    maker = MAKERS.get(socket.node.type)
    if maker is None:
        raise Unfollowable(socket.node.type)
    return maker(Ask(socket.node, socket, place.groups, around))


@dataclass(frozen=True, slots=True)
class Ask:
    """A node that is asked for one of its outputs."""

    node: bpy.types.Node
    out: bpy.types.NodeSocket
    groups: Groups
    around: Surroundings

    def place(self, name: str | int) -> Plug:
        """An input: the enabled one of that name, or by its number."""
        inputs = self.node.inputs
        if isinstance(name, int):
            return Plug(inputs[name], self.groups)
        socket = next((one for one in inputs if name in (one.name, one.identifier) and one.enabled), None)
        if socket is None:
            raise Unfollowable(self.node.type)
        return Plug(socket, self.groups)

    def number(self, name: str | int) -> float:
        """An input as a number."""
        return number(self.place(name), self.around)

    def color(self, name: str | int) -> Value:
        """An input as a colour."""
        return color(self.place(name), self.around)


def _mix(ask: Ask) -> Value:
    kind = ask.node.data_type
    if kind == "FLOAT":
        a, b = np.array(ask.number("A")), np.array(ask.number("B"))
    else:
        a, b = ask.color("A"), ask.color("B")
    if kind == "VECTOR" and ask.node.factor_mode == "NON_UNIFORM":
        factor = ask.color("Factor_Vector")
    else:
        factor = np.array(ask.number("Factor_Float"))
    if ask.node.clamp_factor:
        factor = np.clip(factor, 0.0, 1.0)
    mixed = blended(ask.node.blend_type if kind == "RGBA" else "MIX", factor, a, b)
    return np.clip(mixed, 0.0, 1.0) if kind == "RGBA" and ask.node.clamp_result else mixed


def _mix_rgb(ask: Ask) -> Value:
    mixed = blended(ask.node.blend_type, np.clip(ask.number(0), 0.0, 1.0), ask.color(1), ask.color(2))
    return np.clip(mixed, 0.0, 1.0) if ask.node.use_clamp else mixed


def _math(ask: Ask) -> Value:
    rule = MATH.get(ask.node.operation)
    if rule is None:
        raise Unfollowable(f"MATH {ask.node.operation}")
    operands = [ask.number(i) for i in range(rule.__code__.co_argcount)]
    with np.errstate(all="ignore"):
        result = float(np.nan_to_num(rule(*map(np.float64, operands)), posinf=0.0, neginf=0.0))
    return np.array(min(max(result, 0.0), 1.0) if ask.node.use_clamp else result)


def _ramp(ask: Ask) -> Value:
    found = np.array(ask.node.color_ramp.evaluate(ask.number("Fac" if "Fac" in ask.node.inputs else "Factor")), np.float64)
    return np.array(found[3]) if ask.out.name == "Alpha" else found


def _map_range(ask: Ask) -> Value:
    node = ask.node
    if node.data_type == "FLOAT":
        at, low, high, to_low, to_high = (ask.number(i) for i in range(5))
        steps = ask.number("Steps") if node.interpolation_type == "STEPPED" else 0.0
    else:
        at, low, high, to_low, to_high = (ask.color(f"{name}_FLOAT3") for name in ("Vector", "From_Min", "From_Max", "To_Min", "To_Max"))
        steps = ask.color("Steps_FLOAT3") if node.interpolation_type == "STEPPED" else 0.0
    share = np.divide(np.subtract(at, low), np.subtract(high, low), out=np.zeros(np.shape(at)), where=np.not_equal(high, low))
    if node.interpolation_type == "STEPPED":
        share = np.divide(np.floor(share * (np.array(steps) + 1.0)), steps, out=np.zeros(np.shape(at)), where=np.not_equal(steps, 0.0))
    elif node.interpolation_type != "LINEAR":
        share = np.clip(share, 0.0, 1.0)
        share = share**3 * (share * (share * 6.0 - 15.0) + 10.0) if "ER" in node.interpolation_type else share**2 * (3.0 - 2.0 * share)
    if node.clamp and node.interpolation_type in ("LINEAR", "STEPPED"):
        share = np.clip(share, 0.0, 1.0)
    return np.array(to_low + share * np.subtract(to_high, to_low))


def _vector_math(ask: Ask) -> Value:
    if ask.node.operation == "SCALE":
        return ask.color(0) * ask.number("Scale")
    rule = VECTORS.get(ask.node.operation)
    if rule is None:
        raise Unfollowable(f"VECTOR MATH {ask.node.operation}")
    operands = [ask.color(i) for i in range(rule.__code__.co_argcount)]
    with np.errstate(all="ignore"):
        return np.nan_to_num(rule(*operands), posinf=0.0, neginf=0.0)


def _curves(ask: Ask) -> Value:
    """RGB and Float Curves at a value; the fourth curve of colours is for all channels."""
    mapping = ask.node.mapping
    mapping.initialize()
    if ask.node.type == "CURVE_FLOAT":
        before = ask.number("Value")
        return np.array(before + ask.number(0) * (mapping.evaluate(mapping.curves[0], before) - before))
    before = ask.color("Color")
    both = [mapping.evaluate(mapping.curves[i], mapping.evaluate(mapping.curves[3], float(before[i]))) for i in range(3)]
    return before + ask.number(0) * (np.array(both) - before)


def _hue(ask: Ask) -> Value:
    before = HsvColor(np.clip(ask.color("Color"), 0.0, None))
    hue, saturation, brightness, factor = (ask.number(name) for name in ("Hue", "Saturation", "Value", _factor_name(ask)))
    after = before.copy()
    after.h, after.s, after.v = (before.h + hue + 0.5) % 1.0, min(max(before.s * saturation, 0.0), 1.0), before.v * brightness
    return (1.0 - factor) * np.array(before[:]) + factor * np.array(after[:])


def _factor_name(ask: Ask) -> str:
    return "Fac" if "Fac" in ask.node.inputs else "Factor"


def _invert(ask: Ask) -> Value:
    before = ask.color("Color")
    return before + ask.number(_factor_name(ask)) * (1.0 - 2.0 * before)


def _gamma(ask: Ask) -> Value:
    before = ask.color("Color")
    return np.where(before > 0.0, np.power(np.maximum(before, 1e-12), ask.number("Gamma")), before)


def _contrast(ask: Ask) -> Value:
    contrast = ask.number("Contrast")
    bright = ask.number("Brightness" if "Brightness" in ask.node.inputs else "Bright")
    return np.maximum((1.0 + contrast) * ask.color("Color") + bright - 0.5 * contrast, 0.0)


def _separate(ask: Ask) -> Value:
    mode = getattr(ask.node, "mode", "RGB")
    parts = {"HSV": hsv_of, "HSL": hsl_of}.get(mode, np.asarray)(ask.color(0))
    return np.array(parts[list(ask.node.outputs).index(ask.out)])


def _combine(ask: Ask) -> Value:
    parts = [ask.number(i) for i in range(3)]
    return {"HSV": rgb_of, "HSL": rgb_of_hsl}.get(getattr(ask.node, "mode", "RGB"), lambda *rgb: np.array(rgb))(*parts)


def _image(ask: Ask) -> Value:
    ask.around.varies = True
    if ask.around.varying is not None and ask.out.name != "Alpha":
        return np.array([*np.full(3, ask.around.varying), 1.0])
    found = mean_color(ask.node.image)
    if found is None:
        raise Unfollowable(ask.node.type)
    return np.array(found[3]) if ask.out.name == "Alpha" else found


def _object_info(ask: Ask) -> Value:
    ob, name = ask.around.ask(), ask.out.name
    if ob is None:
        raise Unfollowable(ask.node.type)
    answers = {"Color": ob.color[:3], "Alpha": ob.color[3], "Object Index": ob.pass_index, "Random": ask.around.random}
    if name not in answers:
        raise Unfollowable(ask.node.type)
    return np.array(answers[name], np.float64)


def _attribute(ask: Ask) -> Value:
    ob, node = ask.around.ask(), ask.node
    is_varied = node.type == "VERTEX_COLOR" or node.attribute_type == "GEOMETRY"
    ask.around.varies |= is_varied
    if is_varied and ask.around.varying is not None and ask.out.name != "Alpha":
        return _part(np.array([*np.full(3, ask.around.varying), 1.0]), ask.out.name)
    name = node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name
    if ob is None:
        raise Unfollowable(node.type)
    if is_varied:
        found = mean_attribute(ob, name)
    elif node.attribute_type == "OBJECT":
        found = _property(ob, name)
    else:
        raise Unfollowable(node.type)
    return _part(found, ask.out.name)


def _property(ob: bpy.types.Object, name: str) -> Value:
    """A custom or built-in property of the object or its data, as Cycles finds it; black where there is none."""
    for owner in (ob, ob.data):
        for path in (f'["{name}"]', name):
            try:
                found = owner.path_resolve(path)
            except (ValueError, AttributeError):
                continue
            if isinstance(found, float | int):
                return np.full(4, float(found))
            if hasattr(found, "__len__") and len(found) in (3, 4) and not isinstance(found, str):
                return np.array([*found, 1.0][:4], np.float64)
    return np.zeros(4)


def _part(found: Value, name: str) -> Value:
    if name == "Alpha":
        return np.array(found[3])
    return np.array(found[:3].mean()) if name in ("Fac", "Factor") else found


def _light_path(ask: Ask) -> Value:
    """Rays of the camera, or of a lamp's shadow."""
    ask.around.tells_rays_apart = True
    seen = {"Is Shadow Ray": ask.around.is_shadow, "Is Camera Ray": not ask.around.is_shadow}
    return np.array(float(seen.get(ask.out.name, 0.0)))


def _fresnel(ask: Ask) -> Value:
    """At normal incidence, where most of a surface is seen."""
    ior = max(ask.number("IOR"), 1e-3)
    return np.array(((ior - 1.0) / (ior + 1.0)) ** 2)


def _layer_weight(ask: Ask) -> Value:
    blend = min(max(ask.number("Blend"), 0.0), 1.0 - 1e-5)
    if ask.out.name == "Facing":
        return np.array(0.0)
    ior = 1.0 / (1.0 - blend)
    return np.array(((ior - 1.0) / (ior + 1.0)) ** 2)


def _geometry(ask: Ask) -> Value:
    if ask.out.name != "Backfacing":
        raise Unfollowable(ask.node.type)
    return np.array(0.0)


MAKERS: dict[str, Callable[[Ask], Value]] = {
    "RGB": lambda ask: np.array(ask.node.outputs[0].default_value[:3]),
    "VALUE": lambda ask: np.array(ask.node.outputs[0].default_value),
    "MIX": _mix,
    "MIX_RGB": _mix_rgb,
    "MATH": _math,
    "VALTORGB": _ramp,
    "MAP_RANGE": _map_range,
    "CLAMP": lambda ask: np.array(min(max(ask.number("Value"), ask.number("Min")), ask.number("Max"))),
    "HUE_SAT": _hue,
    "INVERT": _invert,
    "GAMMA": _gamma,
    "BRIGHTCONTRAST": _contrast,
    "RGBTOBW": lambda ask: np.array(ask.color("Color") @ GREY),
    "SEPARATE_COLOR": _separate,
    "SEPRGB": _separate,
    "COMBINE_COLOR": _combine,
    "COMBRGB": _combine,
    "SEPXYZ": _separate,
    "COMBXYZ": _combine,
    "VECT_MATH": _vector_math,
    "CURVE_RGB": _curves,
    "CURVE_FLOAT": _curves,
    "BLACKBODY": lambda ask: blackbody(ask.number(0)),
    "TEX_IMAGE": _image,
    "OBJECT_INFO": _object_info,
    "ATTRIBUTE": _attribute,
    "VERTEX_COLOR": _attribute,
    "LIGHT_PATH": _light_path,
    "FRESNEL": _fresnel,
    "LAYER_WEIGHT": _layer_weight,
    "NEW_GEOMETRY": _geometry,
}
