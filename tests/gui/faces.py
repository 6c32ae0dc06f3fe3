"""The same scene through every face of the extension, in the chroot's one Blender: each must give the same floats.

The window's F12 has left `scene.blend` and `f12.exr` in the folder; the other faces run here, in the background. PyPI's bpy is another
build of Blender with another Mesa; its faces are compared with each other by tests/blender.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

MODULE = "bl_ext.user_default.cad_shadow_preview.addon"
# sha256 and size of each picture's floats, without colour management: a channel's name or a file's date is no difference.
DIGEST = """
import bpy, hashlib, json, numpy, pathlib, sys
folder, found = pathlib.Path(sys.argv[sys.argv.index("--") + 1]), {}
for path in sorted(folder.rglob("*.exr")):
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    pixels = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(pixels)
    found[str(path.relative_to(folder))] = [hashlib.sha256(pixels.tobytes()).hexdigest(), list(image.size), len(numpy.unique(pixels))]
(folder / "digests.json").write_text(json.dumps(found))
"""


def commands(folder: str) -> dict[str, tuple[str, ...]]:
    """The words of each face's command, all for the file scene.blend, by the picture that it makes in the folder."""
    scene = f"{folder}/scene.blend"
    console = f"from {MODULE} import api; api.preview().save({folder + '/console.exr'!r}, ('combined',))"
    arguments = ["addon", "preview", scene, "--format", "exr", "-o", f"{folder}/module"]
    module = f"import runpy, sys; sys.argv = {arguments!r}; runpy.run_module({MODULE!r}, run_name='__main__')"
    return {
        "background_0001.exr": ("-b", scene, "-E", "CAD_SHADOW_PREVIEW", "-F", "OPEN_EXR", "-o", f"{folder}/background_", "-f", "1"),
        "command/scene_combined.exr": ("--command", "cad_shadow", "preview", scene, "--format", "exr", "-o", f"{folder}/command"),
        "console.exr": ("-b", scene, "--python-exit-code", "3", "--python-expr", console),
        "module/scene_combined.exr": ("-b", "--python-exit-code", "3", "--python-expr", module),
    }


def same_from_every_face(run: Callable, folder: Path, inside: str) -> list[dict[str, object]]:
    """The results of the two claims, as the window's steps have them. `run` runs a command in the chroot, where `folder` is `inside`."""
    made = {"f12.exr"}
    try:
        for name, words in commands(inside).items():
            run("blender", *words)
            made.add(name)
        (folder / "digest.py").write_text(DIGEST)
        run("blender", "-b", "--factory-startup", "--python-exit-code", "3", "--python", f"{inside}/digest.py", "--", inside)
        found = json.loads((folder / "digests.json").read_text())
        error = None if set(found) == made else f"pictures: {sorted(found)}"
    except SystemExit as failure:
        return [_result("blender --command, blender -b, the console and the module run", str(failure))]
    same = {digest for digest, _, _ in found.values()}
    is_picture = all(colors > 100 for _, _, colors in found.values())
    differ = None if len(same) == 1 and is_picture else json.dumps(found, indent=1)
    return [
        _result("blender --command, blender -b, the console and the module run", error),
        _result("F12, blender -b -f 1, --command, python -m addon and the console give the same floats", differ),
    ]


def _result(name: str, error: str | None) -> dict[str, object]:
    return {"name": name, "ok": error is None, "error": error}
