"""CAD Shadow Preview: anti-aliased shadow previews of CAD models and their measured error, in Blender and on the command line.

Importing the package needs neither Blender nor OpenGL; `register` attaches it to the Blender that runs.
"""

from __future__ import annotations

from types import ModuleType

from .parts import attach, detach


def _parts() -> tuple[ModuleType, ...]:
    """What registers itself with Blender, in order."""
    from . import (
        command,
        engine,
        hud,
        impostor_marks,
        impostor_overlay,
        operators,
        overlays,
        panels,
        preferences,
        presets,
        properties,
        session,
        sun_properties,
        viewport,
    )

    settings, drawn = (preferences, sun_properties, properties, impostor_marks, session), (overlays, hud, impostor_overlay)
    return *settings, engine, viewport, operators, presets, *drawn, panels, command


def register() -> None:
    """Attach everything to Blender; if one part fails, those before it are taken back."""
    attach(_parts())


def unregister() -> None:
    """Detach everything: no class, property, handler, timer, thread or GL object stays."""
    detach(_parts())
