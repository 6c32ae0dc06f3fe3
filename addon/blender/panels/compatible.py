"""Blender's own properties panels that make sense with this engine: output, dimensions, colour management, camera, light, material."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ..render_wish import ENGINE

MODEL = "BLENDER_WORKBENCH"
NOT_OURS = (
    "RENDER_PT_opengl_",
    "RENDER_PT_eevee_",
    "RENDER_PT_freestyle",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_workbench",
    "VIEWLAYER_PT_layer_passes",
    "MATERIAL_PT_freestyle",
    "DATA_PT_camera_dof",
    "RENDER_PT_stereoscopy",
    "TEXTURE_PT_",
    "WORLD_PT_",
)
ALSO_OURS = (
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_MATERIAL_PT_viewport_settings",
    "EEVEE_NEXT_MATERIAL_PT_settings",
    "DATA_PT_EEVEE_light",
    "EEVEE_WORLD_PT_surface",
    "WORLD_PT_context_world",
    "OBJECT_PT_shading",
    "VIEWLAYER_PT_override",
)


def _subclasses(cls: type) -> Iterator[type]:
    for sub in cls.__subclasses__():
        yield sub
        yield from _subclasses(sub)


def fitting_panels() -> list[type]:
    """The registered panels of Blender that this engine shows: Workbench's, without what is only its own, and the material's surface."""
    with_engines = [cls for cls in _subclasses(bpy.types.Panel) if isinstance(cls.__dict__.get("COMPAT_ENGINES"), set)]
    return [
        cls for cls in with_engines if cls.__name__ in ALSO_OURS or (MODEL in cls.COMPAT_ENGINES and not cls.__name__.startswith(NOT_OURS))
    ]


def register() -> None:
    """Let Blender show its panels for this engine."""
    for cls in fitting_panels():
        cls.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    """Take this engine out of every panel again."""
    for cls in _subclasses(bpy.types.Panel):
        engines = getattr(cls, "COMPAT_ENGINES", None)
        if isinstance(engines, set):
            engines.discard(ENGINE)
