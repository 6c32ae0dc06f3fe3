"""The extension's preferences: how this computer is used for rendering. They hold for every file; how shadows are made is the scene's."""

from __future__ import annotations

import sys

import bpy

from ..pipeline.gl.machine import BACKENDS, Machine, backends_on, choose
from ..scene.reading import limits
from ..scene.reading.limits import Limits
from ..studies import diagnostics
from ..studies.run import stop_worker

EXTENSION = __package__.removesuffix(".blender").rpartition(".")[0]  # what Blender enables; empty where nothing was enabled
BACKEND_WORDS = {
    "auto": ("Automatic", "EGL on Linux, the system's own elsewhere"),
    "egl": ("EGL", "Works without a window system, on Wayland and on servers"),
    "native": ("Native", "GLX on X11, WGL on Windows, CGL on macOS: try it when EGL fails"),
}


def backend_items(platform: str) -> list[tuple[str, str, str, str, int]]:
    """What can be chosen on a platform. Its number in Blender's files is the same on each."""
    return [(key, *BACKEND_WORDS[key], "NONE", BACKENDS.index(key)) for key in backends_on(platform)]


def _changed(self: bpy.types.AddonPreferences, _context: bpy.types.Context) -> None:
    apply(self)


class CAD_SHADOW_preferences(bpy.types.AddonPreferences):
    """How the extension uses this computer."""

    bl_idname = EXTENSION or "cad_shadow_preview"

    backend: bpy.props.EnumProperty(
        name="OpenGL",
        description="How the extension gets its own OpenGL 3.3, apart from Blender's",
        items=backend_items(sys.platform),
        update=_changed,
    )
    is_separate: bpy.props.BoolProperty(
        name="Render in a Process of Its Own",
        description="For graphics drivers that crash: a crash then costs a picture, not Blender. Pictures take a little longer to arrive",
        update=_changed,
    )
    threads: bpy.props.IntProperty(
        name="Software Threads",
        description="Processor threads for Mesa's software OpenGL, where there is no graphics card (0: all). Graphics cards ignore it. "
        "In use from the next start of Blender on, at once with a process of its own",
        min=0,
        soft_max=64,
        update=_changed,
    )
    memory_mib: bpy.props.IntProperty(
        name="Memory Limit (MiB)",
        description="MiB of graphics memory for the maps and images of one picture (0: no limit). "
        "A picture that needs more is refused with a message instead of slowing down or crashing the driver",
        min=0,
        soft_max=16384,
        step=64,
        update=_changed,
    )

    import_seconds: bpy.props.IntProperty(
        name="Import: Time Limit (s)",
        description="Seconds that reading one CAD file may take (0: no limit). Files are read in a process of their own: one that "
        "hangs or crashes it costs that file, not Blender",
        default=Limits().seconds,
        min=0,
        soft_max=3600,
        update=_changed,
    )
    import_memory_mib: bpy.props.IntProperty(
        name="Import: Memory Limit (MiB)",
        description="MiB of memory that reading one CAD file may take (0: three quarters of what the computer has)",
        min=0,
        soft_max=65536,
        step=256,
        update=_changed,
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """One column; a word on what is in use."""
        layout = self.layout
        layout.use_property_split = True
        for name in ("backend", "is_separate", "threads", "memory_mib", "import_seconds", "import_memory_mib"):
            layout.prop(self, name)
        layout.operator("cad_shadow.copy_diagnostics", icon="COPYDOWN")


def apply(preferences: CAD_SHADOW_preferences) -> None:
    """Use the computer so from the next picture on."""
    limits.choose(Limits(preferences.import_seconds, preferences.import_memory_mib))
    backend = preferences.backend or "auto"  # empty: what another machine's preferences hold is not offered here
    if choose(Machine(backend, preferences.threads, preferences.memory_mib, preferences.is_separate)):
        stop_worker()


def register() -> None:
    """Offer the preferences and use them."""
    diagnostics.register()
    bpy.utils.register_class(CAD_SHADOW_preferences)
    enabled = bpy.context.preferences.addons.get(EXTENSION)
    if enabled is not None and enabled.preferences is not None:
        apply(enabled.preferences)


def unregister() -> None:
    """Take them back; Blender keeps the values."""
    bpy.utils.unregister_class(CAD_SHADOW_preferences)
    diagnostics.unregister()
    choose(Machine())
    limits.choose(Limits())
