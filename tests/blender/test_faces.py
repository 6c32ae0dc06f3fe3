"""One scene through the five faces of the extension, with PyPI's bpy: F12, a background render in a process of its own, the command, the
module `python -m addon`, the console. (tests/gui/faces.py does the same with a windowed Blender.)"""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ROOT

TASK = Path(__file__).with_name("farm_task.py")


@pytest.fixture
def saved(cube_scene, blend, tmp_path):
    """The cube scene as a file that writes exact floats."""
    image = cube_scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"
    path = tmp_path / "cube.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def process(*words, cwd, **environment):
    """A Python process that must succeed."""
    command = [sys.executable, *map(str, words)]
    done = subprocess.run(command, cwd=cwd, env=os.environ | environment, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stdout + done.stderr


def pixels(blend, path):
    """A file's values, without colour management."""
    image = blend.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    blend.data.images.remove(image)
    return values


def rendered(blend, path):
    """F12, written to a file of the suffix's format."""
    render = blend.context.scene.render
    render.filepath = str(path)
    render.image_settings.file_format = {".png": "PNG", ".exr": "OPEN_EXR"}[path.suffix]
    blend.ops.render.render(write_still=True)
    return pixels(blend, path)


def test_f12_the_command_the_module_and_the_console_give_the_same_floats(saved, extension, blend, tmp_path):
    blend.ops.wm.open_mainfile(filepath=str(saved))
    f12 = rendered(blend, tmp_path / "f12.exr")
    importlib.import_module(extension.__name__ + ".api").preview().save(tmp_path / "console.exr", ("combined",))
    words = ("preview", str(saved), "--format", "exr", "--quiet", "-o")
    assert importlib.import_module(extension.__name__ + ".cli.main").main([*words, str(tmp_path / "command")]) == 0
    process("-m", "addon", *words, tmp_path / "module", cwd=ROOT)
    assert len(np.unique(f12)) > 50, "shaded, so that a difference could show"
    for name in ("console.exr", "command/cube_combined.exr", "module/cube_combined.exr"):
        assert np.array_equal(pixels(blend, tmp_path / name), f12), name


def test_a_background_render_in_a_process_of_its_own_is_f12(saved, blend, tmp_path):
    link = tmp_path / "user" / "extensions" / "user_default" / "cad_shadow_preview"
    link.parent.mkdir(parents=True)
    link.symlink_to(ROOT, target_is_directory=True)
    process(TASK, saved, tmp_path / "######", 1, 1, cwd=tmp_path, BLENDER_USER_RESOURCES=str(tmp_path / "user"))
    blend.ops.wm.open_mainfile(filepath=str(saved))
    f12 = rendered(blend, tmp_path / "f12.png")
    assert np.array_equal(pixels(blend, tmp_path / "000001.png"), f12)
    assert len(np.unique(f12)) > 8
