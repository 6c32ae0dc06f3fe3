"""The options of several lights and of soft shadows, and when each of them changes anything. No bpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .option import Option, choice
from .words import LIGHTS_WORDS

LIGHT_OPTIONS: tuple[Option, ...] = (
    choice("lights", "lights", "which", "Lights", "Which lights of the scene light the picture", LIGHTS_WORDS),
    Option(
        "light_samples",
        (("lights", "samples"),),
        "count",
        "Light Samples",
        "Soft shadows: places on each light that shadows are drawn from, each of which takes a picture's time; 0 draws hard shadows",
        soft=(0, 256),
    ),
    Option(
        "softness",
        (("lights", "softness"),),
        "number",
        "Softness",
        "How large lights are, times their own size: larger ones have softer shadows",
        soft=(0.0, 4.0),
    ),
    Option(
        "sun_angle",
        (("lights", "sun_angle_deg"),),
        "number",
        "Sun Angle",
        "Width of the sun's disc in degrees, 0.53 in nature (automatic: the light's own)",
        soft=(0.0, 20.0),
        start=0.53,
    ),
)


def _is_soft(v: Any) -> bool:
    return v.light_samples > 0


LIGHTS_APPLY: dict[str, Callable[[Any], bool]] = {"softness": _is_soft, "sun_angle": _is_soft}
