"""Presets of the method, in Blender's own preset system: the shipped ones in `cad_shadow_preview/`, the user's in Blender's user folder.

A preset holds how shadows are made and how many samples a pixel gets; lights, colours, what is shown and impostors belong to the scene.
Before one is loaded everything it may hold goes back to its default, so a file needs to name only what differs, and old files stay whole.
"""

from __future__ import annotations

import ast
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ...errors import SettingsError
from ...scene.user_files import note, read_bytes
from ...settings.option import Option
from ...settings.options import OPTIONS
from ..redraw import redraw

SUBDIR = "cad_shadow_preview"
SEARCH_PATH = Path(__file__).resolve().parents[1]  # Blender looks for `presets/SUBDIR` below it
MOST = 1 << 20
SHIPPED = Path(__file__).resolve().parent / SUBDIR


METHOD = ("warp", "partition", "fit", "test")
"""The groups of settings that presets hold: how shadows are made. Looks hold colours, edges and ground (`settings/looks.py`)."""


def _belongs(option: Option) -> bool:
    return option.name == "samples" or option.targets[0][0] in METHOD


HELD = tuple(name for o in OPTIONS if _belongs(o) for name in ((o.name, "use_" + o.name) if o.is_optional else (o.name,)))


def folders() -> list[str]:
    """Where presets lie, the shipped ones first (Blender 4.2 does not ask for them by itself)."""
    return list(dict.fromkeys([str(SHIPPED), *bpy.utils.preset_paths(SUBDIR)]))


def reset(props: bpy.types.PropertyGroup) -> None:
    """Everything that a preset may hold back to its default. Unlike setting a value, unsetting it tells nobody."""
    for name in HELD:
        props.property_unset(name)
    redraw(bpy.context)


def files() -> dict[str, Path]:
    """Every preset's file by its name in lower case, words apart by a dash: 'oil-platform'."""
    found = [path for folder in reversed(folders()) for path in sorted(Path(folder).glob("*.py")) if path.is_file()]
    return {_key(path.stem): path for path in found}


def _key(name: str) -> str:
    return name.strip().lower().replace("_", "-").replace(" ", "-")


def content(name: str) -> str | None:
    """The text of a preset; None when there is none of that name, or it cannot be read."""
    path = files().get(_key(name))
    try:
        return None if path is None else read_bytes(path, MOST).decode("utf-8", "replace")
    except OSError:
        return None


def preset_of(props: bpy.types.PropertyGroup) -> str | None:
    """The name of the preset that a scene has: a file all of whose values it has, and the defaults of what the file does not name."""
    held = _held_values(props)
    for path in files().values():
        wanted = _defaults() | _values_in(path)
        if all(_same(held[name], wanted[name]) for name in HELD if name in wanted):
            return path.stem.replace("_", " ")
    return None


def _held_values(props: bpy.types.PropertyGroup) -> dict[str, object]:
    values = {name: getattr(props, name) for name in HELD}
    return {name: tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value for name, value in values.items()}


def _same(one: object, other: object) -> bool:
    """Equal as far as Blender keeps numbers: 32 bits."""
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return abs(one - other) <= 1e-6 * max(abs(one), 1.0) if isinstance(one, float) else one == other


@cache
def _defaults() -> dict[str, object]:
    properties = bpy.types.PropertyGroup.bl_rna_get_subclass_py("CadShadowSettings").bl_rna.properties
    return {name: tuple(p.default_array) if getattr(p, "is_array", False) else p.default for name in HELD for p in (properties[name],)}


@lru_cache(maxsize=64)
def _parsed(path: Path, changed_ns: int) -> dict[str, object]:
    """The values that a preset's file sets, read without running it; what is not plain is passed over."""
    values = {}
    for node in ast.parse(read_bytes(path, MOST)).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
            with suppress(ValueError):
                value = ast.literal_eval(node.value)
                values[node.targets[0].attr] = tuple(value) if isinstance(value, list) else value
    return values


def _values_in(path: Path) -> dict[str, object]:
    try:
        return _parsed(path, path.stat().st_mtime_ns)
    except (OSError, SyntaxError, ValueError):
        return {"": None}


def apply(scene: bpy.types.Scene, name: str) -> None:
    """Load a preset by name into the scene, which must be the active one. Raises `SettingsError` naming those there are."""
    known = files()
    path = known.get(_key(name))
    if path is None:
        raise SettingsError(f"There is no preset '{name}': choose one of {', '.join(sorted(known))}.")
    note(path)
    reset(scene.cad_shadow)
    bpy.utils.execfile(str(path))


class CAD_SHADOW_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Keep the present warp, partition, map, filter and samples under a name, or remove a preset made so"""

    bl_idname = "cad_shadow.preset_add"
    bl_label = "Add CAD Shadow Preset"
    preset_menu = "CAD_SHADOW_PT_presets"
    preset_subdir = SUBDIR
    preset_defines = ("settings = bpy.context.scene.cad_shadow",)
    preset_values = tuple(f"settings.{name}" for name in HELD)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """As Blender does it, but shipped files are safe also where Blender does not know them for part of an extension (a checkout)."""
        name = CAD_SHADOW_PT_presets.bl_label if self.remove_active else self.name
        if (self.remove_name or self.remove_active) and files().get(_key(name), Path()).parent == SHIPPED:
            self.report({"WARNING"}, "Presets that came with the extension cannot be removed")
            return {"CANCELLED"}
        return super().execute(context)


class CAD_SHADOW_PT_presets(PresetPanel, bpy.types.Panel):
    """Presets of the CAD shadow preview"""

    bl_label = "CAD Shadow Presets"
    preset_subdir = SUBDIR
    preset_operator = "script.execute_preset"
    preset_add_operator = "cad_shadow.preset_add"

    @staticmethod
    def reset_cb(context: bpy.types.Context, _filepath: str) -> None:
        """Blender calls this before it loads a preset."""
        reset(context.scene.cad_shadow)

    @staticmethod
    def post_cb(_context: bpy.types.Context, _filepath: str) -> None:
        """Blender calls this when it has loaded one: make it a step that Undo takes back."""
        if bpy.ops.ed.undo_push.poll():
            bpy.ops.ed.undo_push(message="CAD Shadow Preset")

    def draw(self, _context: bpy.types.Context) -> None:
        """List the presets, and a line to add one."""
        self.layout.emboss = "PULLDOWN_MENU"
        self.layout.operator_context = "EXEC_DEFAULT"
        self.path_menu(
            folders(),
            self.preset_operator,
            props_default={"menu_idname": self.bl_idname},
            filter_ext=lambda extension: extension == ".py",
            add_operator=self.preset_add_operator,
        )


_classes = (CAD_SHADOW_OT_preset_add, CAD_SHADOW_PT_presets)


def register() -> None:
    """Offer the presets."""
    for cls in _classes:
        bpy.utils.register_class(cls)
    if hasattr(bpy.utils, "register_preset_path"):  # since Blender 4.3
        bpy.utils.register_preset_path(str(SEARCH_PATH))


def unregister() -> None:
    """Take them back; the user's own files stay."""
    if hasattr(bpy.utils, "register_preset_path"):
        bpy.utils.unregister_preset_path(str(SEARCH_PATH))
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
