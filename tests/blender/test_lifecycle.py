"""Enabling and disabling: as often as one likes, at any moment, and Blender ends when it is asked to."""

import importlib
import os
import subprocess
import sys

import pytest

from tests.blender.conftest import MODULE
from tests.conftest import ROOT


@pytest.fixture
def addon_utils(extension):
    """Blender's module; the extension is enabled before and after the test."""
    module = importlib.import_module("addon_utils")
    yield module
    if not module.check(MODULE)[1]:
        module.enable(MODULE, default_set=True)


def toggle(addon_utils):
    """Disable and enable once, errors raised."""

    def fail(error):
        raise error

    addon_utils.disable(MODULE, default_set=True, handle_error=fail)
    assert not addon_utils.check(MODULE)[1]
    assert addon_utils.enable(MODULE, default_set=True, handle_error=fail)


def render(scene):
    """The scene through the extension's engine; no file is written."""
    import bpy

    assert bpy.ops.render.render(scene=scene.name) == {"FINISHED"}


def test_toggling_many_times_adds_nothing(addon_utils):
    from tests.blender.inventory import difference, inventory

    toggle(addon_utils)
    before = inventory()
    for _ in range(25):
        toggle(addon_utils)
    after = inventory()
    assert difference(before, after) == {}
    assert difference(after, before) == {}


def test_disabled_after_a_render_it_leaves_no_thread_and_renders_again_when_enabled(cube_scene, addon_utils):
    from tests.blender.inventory import inventory

    addon_utils.disable(MODULE, default_set=True)
    without = inventory()["threads"]
    addon_utils.enable(MODULE, default_set=True)
    for _ in range(3):
        cube_scene.render.engine = "CAD_SHADOW_PREVIEW"
        render(cube_scene)
        addon_utils.disable(MODULE, default_set=True)
        assert inventory()["threads"] <= without  # one from before may have ended meanwhile
        addon_utils.enable(MODULE, default_set=True)


def test_another_file_opened_after_a_render_changes_nothing_of_the_extension(cube_scene):
    import bpy

    from tests.blender.inventory import difference, inventory

    render(cube_scene)
    before = inventory()
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    assert difference(inventory(), before) == {}
    scene = bpy.context.scene
    scene.render.engine, scene.render.resolution_percentage = "CAD_SHADOW_PREVIEW", 5
    render(scene)


LEAVE_WITHOUT_DISABLING = f"""
import bpy, addon_utils
addon_utils.enable("{MODULE}", default_set=True)
scene = bpy.context.scene
scene.render.engine = "CAD_SHADOW_PREVIEW"
scene.render.resolution_x, scene.render.resolution_y = 64, 48
bpy.ops.render.render()
print("rendered", flush=True)
"""


def test_blender_ends_though_the_extension_is_enabled_and_has_rendered(tmp_path):
    link = tmp_path / "extensions" / "user_default" / "cad_shadow_preview"
    link.parent.mkdir(parents=True)
    link.symlink_to(ROOT, target_is_directory=True)
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path)}
    command = [sys.executable, "-c", LEAVE_WITHOUT_DISABLING]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240, cwd=tmp_path)
    assert "rendered" in done.stdout, done.stderr
    assert done.returncode == 0, done.stderr


def test_disabled_it_leaves_rendered_shading_of_its_engine_and_no_other(cube_scene, addon_utils):
    import bpy

    def spaces():
        return [space for screen in bpy.data.screens for area in screen.areas for space in area.spaces if space.type == "VIEW_3D"]

    bpy.ops.wm.read_homefile(use_factory_startup=True)
    assert spaces()
    for engine, expected in (("CAD_SHADOW_PREVIEW", "SOLID"), ("BLENDER_WORKBENCH", "RENDERED")):
        bpy.context.scene.render.engine = engine
        for space in spaces():
            space.shading.type = "RENDERED"
        toggle(addon_utils)
        assert {space.shading.type for space in spaces()} == {expected}
        assert bpy.context.scene.render.engine == engine
