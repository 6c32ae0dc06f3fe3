"""Looks: how a picture is drawn as a whole, recognised at a glance. A table, no bpy.

A look holds colours, ambient light, edges and ground. All that a look may hold and this one does not name goes back to its default. How
shadows are made is the presets' business (`blender/presets`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ..errors import SettingsError
from .groups import Settings
from .options import BY_NAME, values_of, with_options

HELD = (
    "light_strength",
    "own_sun",
    "ambient_sky",
    "ambient_ground",
    "use_object_colors",
    "clay",
    "background",
    "sky",
    "sky_samples",
    "edges",
    "edge_color",
    "edge_strength",
    "edge_angle",
    "ground",
    "ground_height",
    "ground_strength",
)
"""The options that a look may hold."""


@dataclass(frozen=True, eq=False)
class PictureLook:
    """One look: how it is called, what one sees, and the options that it sets."""

    label: str
    text: str
    values: dict[str, object] = field(default_factory=dict)


LOOKS: dict[str, PictureLook] = {
    "cad": PictureLook(
        "CAD",
        "Parts in their own colors with thin dark edges, on a ground that catches their shadows: what CAD programs show",
        {"edges": 1.2, "ground": "auto", "background": (0.62, 0.67, 0.73, 1.0), "own_sun": 0.7, "sky": "uniform"},
    ),
    "clay": PictureLook(
        "Clay",
        "Everything in one matt gray under an open sky, no edges, shadows on the ground: shape alone",
        {
            "use_object_colors": False,
            "clay": (0.55, 0.53, 0.50),
            "ground": "auto",
            "background": (0.86, 0.85, 0.83, 1.0),
            "sky": "uniform",
            "ambient_sky": (0.34, 0.35, 0.37),
            "ambient_ground": (0.20, 0.19, 0.18),
        },
    ),
    "technical": PictureLook(
        "Technical",
        "White parts on white with black edges and faint shadows: a drawing for a manual",
        {
            "use_object_colors": False,
            "clay": (0.95, 0.95, 0.95),
            "edges": 1.4,
            "edge_strength": 1.0,
            "edge_color": (0.0, 0.0, 0.0),
            "light_strength": 0.33,
            "ambient_sky": (0.74, 0.74, 0.74),
            "ambient_ground": (0.62, 0.62, 0.62),
            "background": (1.0, 1.0, 1.0, 1.0),
        },
    ),
    "sun-study": PictureLook(
        "Sun Study",
        "Pale parts with faint edges in strong light, dark shadows on the ground: where the sun falls and where it does not",
        {
            "use_object_colors": False,
            "clay": (0.78, 0.76, 0.72),
            "edges": 0.8,
            "edge_strength": 0.5,
            "ground": "auto",
            "light_strength": 1.1,
            "sky": "cie",
            "ambient_sky": (0.22, 0.25, 0.30),
            "ambient_ground": (0.14, 0.13, 0.12),
            "background": (0.90, 0.89, 0.86, 1.0),
        },
    ),
    "oil-platform": PictureLook(
        "Oil Platform",
        "Parts in their own colors with fine edges before a dark sea: plants with thousands of parts stay readable",
        {"edges": 0.7, "edge_strength": 0.6, "background": (0.10, 0.14, 0.18, 1.0)},
    ),
    "reference": PictureLook("Reference", "The parts' own colors and nothing else, to compare with other programs", {}),
}


def look_named(name: str) -> PictureLook:
    """The look of that name. Raises `SettingsError` naming those there are."""
    key = name.strip().lower().replace("_", "-").replace(" ", "-")
    if key not in LOOKS:
        raise SettingsError(f"There is no look '{name}': choose one of {', '.join(LOOKS)}.")
    return LOOKS[key]


def look_values(name: str) -> dict[str, object]:
    """Every option that a look may hold, as this one has it."""
    return {option: BY_NAME[option].default for option in HELD} | look_named(name).values


def with_look(settings: Settings, name: str) -> Settings:
    """A copy of `settings` with that look. Raises `SettingsError`."""
    return with_options(settings, look_values(name))


def look_of(settings: Settings) -> str | None:
    """The name of the look that `settings` have; None when they have been changed by hand."""
    present = values_of(settings)
    held = {name: present[name] for name in HELD}
    return next((name for name in LOOKS if values_of(with_look(settings, name)).items() >= held.items()), None)
