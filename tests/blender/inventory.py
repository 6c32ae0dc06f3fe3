"""What is in Blender now: everything an extension can leave behind, by kind. Imported by tests and by package_tour.py."""

import gc
import sys
import threading
import types
from collections import Counter
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.cad_shadow_preview"


def inventory() -> dict[str, Counter]:
    """Names and how often they occur, by kind; Blender's own are included, so compare two of them."""
    classes = {name: getattr(bpy.types, name) for name in dir(bpy.types)}
    structs = {name: kind for name, kind in classes.items() if hasattr(kind, "bl_rna")}
    menus = {name: kind for name, kind in classes.items() if getattr(getattr(kind, "draw", None), "_draw_funcs", None)}
    handlers = {name: listed for name in dir(bpy.app.handlers) if isinstance(listed := getattr(bpy.app.handlers, name), list)}
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    keymaps = keyconfig.keymaps if keyconfig else []
    found = {
        "classes": {*classes, *registered_classes()},
        "properties": [f"{name}.{p.identifier}" for name, kind in structs.items() for p in kind.bl_rna.properties],
        "operators": [f"{group}.{name}" for group in dir(bpy.ops) for name in dir(getattr(bpy.ops, group))],
        "menu entries": [f"{name}: {full_name(f)}" for name, kind in menus.items() for f in added_draws(kind)],
        "handlers": [f"{name}: {full_name(f)}" for name, listed in handlers.items() for f in listed],
        "timers": [full_name(f) for f in own_functions() if bpy.app.timers.is_registered(f)],
        "threads": [thread.name for thread in threading.enumerate()],
        "key maps": [f"{keymap.name}: {item.idname}" for keymap in keymaps for item in keymap.keymap_items],
        "wheels": [path.name for path in site_folder().glob("*.dist-info")],
    }
    return {kind: Counter(names) for kind, names in found.items()}


def added_draws(menu: type) -> list:
    """What was appended to a menu; Blender's list also has the menu's own draw function, from the first append on and for good."""
    return [function for function in menu.draw._draw_funcs if full_name(function) != f"{menu.__module__}.{menu.__qualname__}.draw"]


def registered_classes() -> set[str]:
    """The extension's classes that Blender knows, also the kinds that bpy.types does not list (engines, preferences, groups)."""
    todo, found = [bpy.types.bpy_struct], set()
    while todo:
        kind = todo.pop()
        todo += type.__subclasses__(kind)
        if kind.__module__.startswith(MODULE) and "bl_rna" in vars(kind):
            found.add(kind.__name__)
    return found


def own_functions() -> list:
    """All functions of the extension's modules that are alive: Blender has no list of its timers, it can only be asked for one."""
    functions = [thing for thing in gc.get_objects() if type(thing) in (types.FunctionType, types.MethodType)]
    return [function for function in functions if (function.__module__ or "").startswith(MODULE)]


def full_name(function: object) -> str:
    """Module and name of a callable."""
    return f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', function)}"


def site_folder() -> Path:
    """Where Blender unpacks the wheels of extensions."""
    python = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    return Path(bpy.utils.user_resource("EXTENSIONS"), ".local", "lib", python, "site-packages")


def difference(before: dict[str, Counter], after: dict[str, Counter]) -> dict[str, list[str]]:
    """What `after` has and `before` has not, kinds without any left out."""
    return {kind: sorted((after[kind] - before[kind]).elements()) for kind in before if after[kind] - before[kind]}
