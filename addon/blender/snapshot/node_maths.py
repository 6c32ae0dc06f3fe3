"""What the Mix and Math nodes make of values, in numbers. No bpy."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

Value = np.ndarray
"""A float64 number () or colour (3,); images and attributes (4,) on the way."""


class Unfollowable(Exception):
    """A socket's value cannot be known here: the node's type."""


def blended(kind: str, factor: Value, a: Value, b: Value) -> Value:
    """Two values mixed as the Mix node of that blend type does. Raises `Unfollowable` for a type that there is not."""
    if kind in _HUES:
        return a + factor * (_turned(kind, a, b) - a)
    if kind in ("DODGE", "BURN"):
        return _burnt(kind, factor, a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        rule = _BLENDS.get(kind)
        if rule is None:
            raise Unfollowable(f"MIX {kind}")
        return a + factor * (np.nan_to_num(rule(a, b), posinf=0.0, neginf=0.0) - a)


_HUES = {"HUE": "h", "SATURATION": "s", "VALUE": "v", "COLOR": "hs"}


def _turned(kind: str, a: Value, b: Value) -> Value:
    """`a` with the hue, saturation or value of `b`; a grey `b` has no hue."""
    own, other = dict(zip("hsv", hsv_of(a), strict=True)), dict(zip("hsv", hsv_of(b), strict=True))
    if other["s"] == 0.0 and kind in ("HUE", "COLOR") or own["s"] == 0.0 and kind == "SATURATION":
        return a
    return rgb_of(*(own | {name: other[name] for name in _HUES[kind]}).values())


def _burnt(kind: str, factor: Value, a: Value, b: Value) -> Value:
    """Color Dodge and Color Burn, channel by channel."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if kind == "DODGE":
            rest = 1.0 - factor * b
            return np.where(a == 0.0, a, np.where(rest <= 0.0, 1.0, np.minimum(a / rest, 1.0)))
        part = 1.0 - factor + factor * b
        return np.where(part <= 0.0, 0.0, np.clip(1.0 - (1.0 - a) / part, 0.0, 1.0))


def hsv_of(color: Value) -> Value:
    """(3,) hue, saturation and value of a linear colour, as Blender's nodes have them."""
    high, low = float(color.max()), float(color.min())
    spread = high - low
    if high == 0.0 or spread == 0.0:
        return np.array([0.0, 0.0, high])
    red, green, blue = (high - color) / spread
    hue = blue - green if color[0] == high else 2.0 + red - blue if color[1] == high else 4.0 + green - red
    return np.array([hue / 6.0 % 1.0, spread / high, high])


def rgb_of(hue: float, saturation: float, value: float) -> Value:
    """The linear colour (3,) of a hue, saturation and value."""
    turn = (float(hue) % 1.0) * 6.0
    part = np.clip(np.abs((turn + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0, 0.0, 1.0)
    return float(value) * (1.0 - float(saturation) * (1.0 - part))


def hsl_of(color: Value) -> Value:
    """(3,) hue, saturation and lightness of a linear colour."""
    high, low = float(color.max()), float(color.min())
    light, spread = (high + low) / 2.0, high - low
    room = 2.0 - high - low if light > 0.5 else high + low
    return np.array([hsv_of(color)[0], spread / room if spread > 0.0 and room > 0.0 else 0.0, light])


def rgb_of_hsl(hue: float, saturation: float, light: float) -> Value:
    """The linear colour (3,) of a hue, saturation and lightness."""
    chroma = (1.0 - abs(2.0 * float(light) - 1.0)) * float(saturation)
    return (rgb_of(hue, 1.0, 1.0) - 0.5) * chroma + float(light)


_WARM = np.array([
    [965.0, 1.61919106e3, -2.05010916e-3, 5.02995757, -4.88999748e2, 6.04330754e-4, -7.55807526e-2,
     5.96945309e-11, -4.85742887e-8, -9.70622247e-5, -4.07936148e-3],
    [1167.0, 2.48845471e3, -1.11330907e-3, 3.22621544, -7.55994277e2, 3.16730098e-4, 4.78306139e-1,
     2.40430366e-11, 5.55021075e-8, -1.98503712e-4, 2.89312858e-2],
    [1449.0, 3.34143193e3, -4.86551192e-4, 1.76486769, -1.02363977e3, 1.20223470e-4, 9.36662319e-1,
     -1.40949732e-11, 1.89878968e-7, -3.56632824e-4, 9.10767778e-2],
    [1902.0, 4.09461742e3, -1.27446582e-4, 7.25731635e-1, -1.26571316e3, 4.87340896e-6, 1.27054498,
     -3.61460868e-11, 2.84822009e-7, -4.93211319e-4, 1.56723440e-1],
    [3315.0, 4.67028036e3, 2.91258199e-5, 1.26703442e-1, -1.42529332e3, -4.01150431e-5, 1.43972784,
     -1.97075738e-11, 1.75359352e-7, -2.50542825e-4, -2.22783266e-2],
    [6365.0, 4.59509185e3, 2.87495649e-5, 1.50345020e-1, -1.17554822e3, -2.16378048e-5, 1.30408023,
     -1.61997957e-13, -1.64216008e-8, 3.86216271e-4, -7.38077418e-1],
    [12000.0, 3.78717450e3, 9.35907826e-6, 3.99075871e-1, -5.00799571e2, -4.59832026e-6, 1.09098763,
     6.72650283e-13, -2.73078809e-8, 4.24098264e-4, -7.52335691e-1],
])  # fmt: skip
"""Cycles' fit of a black body's colour (`svm/math_util.h`): up to so many kelvin, red and green as a / T + b T + c, blue a cubic in T."""


def blackbody(kelvin: float) -> Value:
    """The linear Rec. 709 colour (3,) of a black body of luminance 1, as Cycles has it."""
    t = float(kelvin)
    if t >= 12000.0:
        return np.array([0.826295481, 0.99450805, 1.566307710])
    if t < 800.0:
        return np.array([5.41329449, 0.0, 0.0])
    _, *fit = _WARM[int(np.searchsorted(_WARM[:, 0], t, side="right"))]
    red, green = (fit[i] / t + fit[i + 1] * t + fit[i + 2] for i in (0, 3))
    return np.maximum(np.array([red, green, ((fit[6] * t + fit[7]) * t + fit[8]) * t + fit[9]]), 0.0)


_BLENDS: dict[str, Callable[[Value, Value], Value]] = {
    "MIX": lambda a, b: b,
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
    "MULTIPLY": lambda a, b: a * b,
    "SCREEN": lambda a, b: 1.0 - (1.0 - a) * (1.0 - b),
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "DIVIDE": lambda a, b: a / b,
    "DIFFERENCE": lambda a, b: np.abs(a - b),
    "EXCLUSION": lambda a, b: np.maximum(a + b - 2.0 * a * b, 0.0),
    "OVERLAY": lambda a, b: np.where(a < 0.5, 2.0 * a * b, 1.0 - 2.0 * (1.0 - a) * (1.0 - b)),
    "LINEAR_LIGHT": lambda a, b: a + 2.0 * b - 1.0,
    "SOFT_LIGHT": lambda a, b: (1.0 - a) * a * b + a * (1.0 - (1.0 - a) * (1.0 - b)),
}


MATH: dict[str, Callable[..., float]] = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b,
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b: a**b,
    "SQRT": lambda a: np.sqrt(a),
    "ABSOLUTE": lambda a: abs(a),
    "MINIMUM": lambda a, b: min(a, b),
    "MAXIMUM": lambda a, b: max(a, b),
    "LESS_THAN": lambda a, b: float(a < b),
    "GREATER_THAN": lambda a, b: float(a > b),
    "ROUND": lambda a: np.floor(a + 0.5),
    "FLOOR": lambda a: np.floor(a),
    "CEIL": lambda a: np.ceil(a),
    "FRACT": lambda a: a - np.floor(a),
    "MODULO": lambda a, b: np.fmod(a, b),
    "SINE": lambda a: np.sin(a),
    "COSINE": lambda a: np.cos(a),
    "RADIANS": lambda a: a * pi / 180.0,
    "DEGREES": lambda a: a * 180.0 / pi,
    "LOGARITHM": lambda a, b: np.log(a) / np.log(b),
    "INVERSE_SQRT": lambda a: 1.0 / np.sqrt(a),
    "EXPONENT": lambda a: np.exp(a),
    "SIGN": lambda a: np.sign(a),
    "TRUNC": lambda a: np.trunc(a),
    "FLOORED_MODULO": lambda a, b: a - np.floor(a / b) * b,
    "WRAP": lambda a, b, c: a - (b - c) * np.floor((a - c) / (b - c)) if b != c else c,
    "SNAP": lambda a, b: np.floor(a / b) * b,
    "PINGPONG": lambda a, b: abs((a - b) / (2.0 * b) - np.floor((a - b) / (2.0 * b)) - 0.5) * 2.0 * b,
    "COMPARE": lambda a, b, c: float(abs(a - b) <= max(c, 1e-5)),
    "SMOOTH_MIN": lambda a, b, c: _smooth_least(a, b, c),
    "SMOOTH_MAX": lambda a, b, c: -_smooth_least(-a, -b, c),
    "TANGENT": lambda a: np.tan(a),
    "ARCSINE": lambda a: np.arcsin(a),
    "ARCCOSINE": lambda a: np.arccos(a),
    "ARCTANGENT": lambda a: np.arctan(a),
    "ARCTAN2": lambda a, b: np.arctan2(a, b),
    "SINH": lambda a: np.sinh(a),
    "COSH": lambda a: np.cosh(a),
    "TANH": lambda a: np.tanh(a),
}


def _smooth_least(a: float, b: float, distance: float) -> float:
    if distance == 0.0:
        return min(a, b)
    near = max(distance - abs(a - b), 0.0) / distance
    return min(a, b) - near**3 * distance / 6.0


VECTORS: dict[str, Callable[..., Value]] = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b,
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "CROSS_PRODUCT": lambda a, b: np.cross(a, b),
    "DOT_PRODUCT": lambda a, b: np.array(a @ b),
    "DISTANCE": lambda a, b: np.array(np.linalg.norm(a - b)),
    "LENGTH": lambda a: np.array(np.linalg.norm(a)),
    "NORMALIZE": lambda a: a / np.linalg.norm(a),
    "ABSOLUTE": lambda a: np.abs(a),
    "POWER": lambda a, b: a**b,
    "MINIMUM": lambda a, b: np.minimum(a, b),
    "MAXIMUM": lambda a, b: np.maximum(a, b),
    "FLOOR": lambda a: np.floor(a),
    "CEIL": lambda a: np.ceil(a),
    "FRACTION": lambda a: a - np.floor(a),
    "MODULO": lambda a, b: np.fmod(a, b),
    "SNAP": lambda a, b: np.floor(a / b) * b,
    "SINE": lambda a: np.sin(a),
    "COSINE": lambda a: np.cos(a),
    "TANGENT": lambda a: np.tan(a),
}
