"""Opening what the command line is given, a .blend, a CAD file or the procedural deck, as the open Blender scene."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..errors import CadFileError, SceneError
from ..scene.cad.formats import BY_SUFFIX
from ..scene.cad.sniff import checked_path
from ..scene.cad_model import CadModel
from ..scene.plain_text import shown_name
from ..scene.reading import apart as reading
from ..scene.user_files import note, opened
from ..studies import stopping
from .cad_import import to_blender
from .own_importers import imported, is_for_blender

NO_SCRIPTS = "The scripts in this .blend, and drivers that need them, are not run: open it in Blender, look at them, and render there."
BLEND_MAGICS = (b"BLENDER", b"\x28\xb5\x2f\xfd", b"\x1f\x8b")


def open_input(source: str, units: str | None = None, up: str | None = None) -> tuple[bpy.types.Scene, tuple[str, ...]]:
    """The scene that `source` holds, now open in Blender in place of what was, and what the user should know about it.

    Raises `CadFileError`; the open file is replaced only after the new one could be read.
    """
    if not source:
        raise CadFileError("An input without a name was given: leave the empty argument out.")
    path = Path(source)
    if path.suffix.lower() == ".blend":
        scene = open_blend(path)
        return scene, (NO_SCRIPTS,) if bpy.app.autoexec_fail else ()
    if is_for_blender(path):
        checked_path(path, BY_SUFFIX)
        scene = _empty_scene()
        return scene, imported(path, scene.collection, units, up)[1]
    return open_model(reading.read(path, units, up, stopping.check))


def open_blend(path: Path) -> bpy.types.Scene:
    """The active scene of a .blend file. Its scripts are not run. Raises `CadFileError` for what is not a readable .blend."""
    try:
        with opened(path) as file:
            start = file.read(8)
    except OSError as error:
        raise CadFileError(f"{path} cannot be read ({error.strerror}): check the path and the permissions.") from error
    except ValueError as error:
        raise CadFileError(f"{shown_name(str(path))} is no name that a file can have: check the path.") from error
    if not start.startswith(BLEND_MAGICS):
        raise CadFileError(
            f"{path.name} is not a Blender file, whatever its name says: give it its true suffix, or save it again from Blender."
        )
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except UnicodeEncodeError as error:
        raise CadFileError(f"{shown_name(path.name)} lies under a name that Blender cannot take: rename it in plain letters.") from error
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error: ").split())
        raise CadFileError(f"{path.name} cannot be opened by Blender {bpy.app.version_string} ({reason}).") from error
    _note_files()
    return bpy.context.scene


def activated(scene: bpy.types.Scene, name: str | None) -> bpy.types.Scene:
    """The scene of that name (None: `scene`), now the active one. Raises `SceneError` naming those there are."""
    if name is None or name == scene.name:
        return scene
    wanted = bpy.data.scenes.get(name)
    if wanted is None:
        raise SceneError(f"There is no scene '{name}': choose one of {', '.join(repr(one.name) for one in bpy.data.scenes)}.")
    for window in bpy.context.window_manager.windows:
        window.scene = wanted
    return wanted


def _note_files() -> None:
    """Count what the open .blend links and shows as inputs: libraries and images."""
    for one in (*bpy.data.libraries, *bpy.data.images):
        if one.filepath and not one.packed_file:
            note(Path(bpy.path.abspath(one.filepath, library=one.library)), is_read=isinstance(one, bpy.types.Library))


def open_deck(triangles: int) -> tuple[bpy.types.Scene, tuple[str, ...]]:
    """The procedural platform deck of about so many triangles, as a new scene."""
    from ..scene.platform_deck import build

    return open_model(build(triangles))


def open_model(model: CadModel) -> tuple[bpy.types.Scene, tuple[str, ...]]:
    """A new scene that holds only this CAD model. Colours are shown as the file gives them (view transform Standard)."""
    scene = _empty_scene()
    to_blender(model, scene.collection)
    return scene, model.warnings


def _empty_scene() -> bpy.types.Scene:
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 1280, 720, 100
    return scene
