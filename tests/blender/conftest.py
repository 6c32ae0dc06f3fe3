"""Blender with the extension enabled from this checkout, under the name it has in Blender: bl_ext.user_default.cad_shadow_preview."""

import importlib

import pytest

from tests.blender.impostor_rig import SIZE
from tests.blender.user_folder import BOX
from tests.conftest import ROOT

MODULE = "bl_ext.user_default.cad_shadow_preview"


def _raise(error: Exception) -> None:
    raise error


@pytest.fixture(scope="session")
def extension(user_resources):
    """The extension's `addon` package, enabled from a link to the sources; disabled at the end (bpy 4.5 hangs at exit otherwise)."""
    import bpy  # noqa: F401 - addon_utils exists once bpy is loaded

    addon_utils = importlib.import_module("addon_utils")
    link = user_resources / "extensions" / "user_default" / "cad_shadow_preview"
    link.parent.mkdir(parents=True, exist_ok=True)
    link.symlink_to(ROOT, target_is_directory=True)
    assert addon_utils.enable(MODULE, default_set=True, handle_error=_raise)
    yield importlib.import_module(MODULE + ".addon")
    addon_utils.disable(MODULE, default_set=True, handle_error=_raise)


@pytest.fixture
def blend(extension):
    """`bpy` with an empty file and factory settings; the extension stays enabled."""
    import bpy

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return bpy


@pytest.fixture
def cube_scene(blend):
    """A cube on a plane under a sun, seen by a camera, in a small picture; gives the scene."""
    bpy = blend
    bpy.ops.mesh.primitive_plane_add(size=8)
    bpy.ops.mesh.primitive_cube_add(size=2, location=(0, 0, 1))
    bpy.ops.object.light_add(type="SUN", rotation=(0.6, 0.3, 0.2))
    bpy.ops.object.camera_add(location=(6, -6, 5), rotation=(1.02, 0, 0.785))
    scene = bpy.context.scene
    scene.camera = bpy.context.object
    scene.render.engine = "CAD_SHADOW_PREVIEW"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 96, 64, 100
    scene.view_settings.view_transform = "Standard"
    scene.render.dither_intensity = 0
    return scene


@pytest.fixture
def room(extension):
    """The extension's module of that name."""
    return lambda name: importlib.import_module(f"{extension.__name__}.{name}")


@pytest.fixture
def main(room):
    """The command line: its exit code."""
    return room("cli.main").main


@pytest.fixture
def api(room):
    """The extension's `api`."""
    return room("api")


@pytest.fixture
def ball(cube_scene, blend):
    """A ball beside the cube, dense enough to be worth an impostor, drawn as one whatever it costs."""
    blend.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1.0, location=(2.5, 1, 1.2))
    cube_scene.cad_shadow.impostor_break_even = False
    return blend.context.object


@pytest.fixture
def view(api, room):
    """What the life cycle makes of the present view (F12 in the settings below captures anew each time)."""

    def draw(**arguments):
        result = api.preview(size=SIZE, samples=1, map_size=128, **({"impostor_fresh": False} | arguments))
        return result, {report.name: report for report in result.impostors}

    yield draw
    room("blender.session").clear()


@pytest.fixture
def box(tmp_path):
    """A model in in/."""
    path = tmp_path / "in" / "box.obj"
    path.parent.mkdir()
    path.write_text(BOX)
    return path
