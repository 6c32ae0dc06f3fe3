"""Run by test_package.py in a process of its own: a user's life with the zip. Arguments: the zip, an output folder. Prints JSON.

Install into an empty user folder → enable → render a cube → disable; and what is in Blender before and after.
"""

import importlib
import json
import sys
from collections import Counter
from pathlib import Path

import bpy
from inventory import MODULE, difference, inventory, site_folder  # beside this file

BUNDLED = ("moderngl", "glcontext", "trimesh", "fast_simplification", "cascadio", "DracoPy")

commands = {}
real_register, real_unregister = bpy.utils.register_cli_command, bpy.utils.unregister_cli_command


def register_cli_command(name, execute):
    """Blender has no list of its commands: keep one."""
    handle = real_register(name, execute)
    commands[handle] = name
    return handle


def unregister_cli_command(handle):
    """The counterpart."""
    commands.pop(handle, None)  # Blender's own add-ons made theirs before
    real_unregister(handle)


def full_inventory() -> dict[str, Counter]:
    """The inventory and the commands."""
    return {**inventory(), "commands": Counter(commands.values())}


def render_cube(path: Path) -> dict[str, float]:
    """A cube with the extension's engine, written by Blender; gives the spread of the picture."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CAD_SHADOW_PREVIEW"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 96, 64, 100
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(str(path))
    reds = sorted(picture.pixels[:][0::4])
    return {"pixels": len(reds), "low": reds[len(reds) // 50], "high": reds[-len(reds) // 50]}


def main() -> None:
    """The tour; stops with a traceback at the first thing that fails."""
    package, output = Path(sys.argv[1]), Path(sys.argv[2])
    bpy.utils.register_cli_command, bpy.utils.unregister_cli_command = register_cli_command, unregister_cli_command
    before = full_inventory()
    bpy.ops.extensions.package_install_files(filepath=str(package), repo="user_default", enable_on_install=True)
    picture = render_cube(output / "cube.png")
    added = difference(before, full_inventory())
    files = {name: importlib.import_module(name).__file__ for name in BUNDLED}
    importlib.import_module("addon_utils").disable(MODULE, default_set=True)
    left = difference(before, full_inventory())
    print(json.dumps({"picture": picture, "added": added, "left": left, "files": files, "site": str(site_folder())}))


main()
