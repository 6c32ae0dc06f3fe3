"""CAD Shadow Preview: anti-aliased shadow previews of CAD models and their measured error, in Blender and on the command line.

Importing the package needs neither Blender nor OpenGL; `register` attaches it to the Blender that runs.
"""

from __future__ import annotations

import atexit
from types import ModuleType

from .blender.registering import attach, detach, is_python_module


def _parts() -> tuple[ModuleType, ...]:
    """What registers itself with Blender, in order."""
    from . import operators
    from .blender import (
        changes,
        engine,
        hud,
        panels,
        preferences,
        presets,
        properties,
        section_properties,
        session,
        sun_properties,
        translations,
        viewport,
    )
    from .blender.hud import impostor_overlay, map_overlay, sun_path
    from .blender.impostors import marks
    from .cli import blender_command

    settings, drawn = (
        (preferences, sun_properties, section_properties, properties, marks, changes, session),
        (map_overlay, sun_path, hud, impostor_overlay),
    )
    return *settings, engine, viewport, operators, presets, *drawn, panels, translations, blender_command


def register() -> None:
    """Attach everything to Blender; if one part fails, those before it are taken back.

    Where Blender is a module of Python, everything is detached when Python ends: a script need not think of it.
    """
    import bpy

    attach(_parts())
    if is_python_module(bpy.app):
        atexit.register(_detach_at_exit)


def unregister() -> None:
    """Detach everything: no class, property, handler, timer, thread or GL object stays."""
    atexit.unregister(_detach_at_exit)
    detach(_parts())


def _detach_at_exit() -> None:
    """Before Blender's own end, which is registered earlier and so comes later, and which 4.5 does not survive with an engine attached.

    What Blender enabled is disabled by Blender, so that it does not do it again.
    """
    import addon_utils

    name = __package__.rpartition(".")[0]
    if name and addon_utils.check(name)[1]:
        addon_utils.disable(name)
    else:
        unregister()
