"""The version of settings in files, and what older ones mean now. No bpy.

Version 1 showed a light of irradiance E as E·albedo (now E·albedo/π), 0.85 of it by default, under a sky and before a background of its
own wherever the scene has a world. Version 2 drew one light of a scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

from ..errors import SettingsError
from .groups import BRIGHTEST

VERSION = 3
KEY = "settings_version"
TEST_1 = "depth"
LIGHTS_2 = "one"
"""How many of a scene's lights the first two versions drew."""
STRENGTH_1 = 0.85
"""The light strength that version 1 had where none was set, and its shadow test."""


def light_since_1(strength: float) -> dict[str, float]:
    """What a light strength of version 1 is now: the lights of scenes are as bright as they were, and so is a sun of our own."""
    return {"light_strength": min(pi * strength, BRIGHTEST), "own_sun": 1.0 / pi}


def migrated(content: Mapping[str, object]) -> dict[str, object]:
    """The content of a settings file as this version means it, without its version. Raises `SettingsError` for one from the future."""
    version = content.get(KEY, 1)
    if not (isinstance(version, int) and 1 <= version <= VERSION):
        raise SettingsError(f"The settings are of version {version}, this extension knows {VERSION}: update it, or write them anew.")
    now = {name: dict(value) if isinstance(value, Mapping) else value for name, value in content.items() if name != KEY}
    if version == 1:
        for table in (now, now.get("shading")):
            if isinstance(table, dict):
                _brighten(table)
    if KEY in content and version < 3 and not isinstance(now.get("lights"), Mapping):
        now.setdefault("lights", LIGHTS_2)
    return now


def _brighten(table: dict[str, object]) -> None:
    name = next((one for one in table if one.replace("-", "_") == "light_strength"), None)
    strength = table.get(name) if name else None
    if name is not None and isinstance(strength, int | float) and not isinstance(strength, bool) and 0.0 <= strength <= BRIGHTEST:
        table |= {name: light_since_1(strength)["light_strength"], "own_sun": table.get("own_sun", light_since_1(strength)["own_sun"])}
