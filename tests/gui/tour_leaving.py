"""The last steps of the tour: the system's own OpenGL, and leaving Blender with everything at work."""

import importlib
from collections.abc import Generator

import bpy
from harness import changed_share, close_extra_windows, colours, picture, settle, step, until, view
from room import ENGINE, MODULE, addon, canvas, command, editors, fresh_tab, here, plant, wait_for_picture, working


def choose(backend: str) -> None:
    """As a click in the preferences does; not to be saved, since the faces that follow have no X server."""
    bpy.context.preferences.use_preferences_save = False
    bpy.context.preferences.addons[MODULE].preferences.backend = backend


def platform() -> str:
    """Where the context of the worker comes from: the module that made it."""
    return addon("pipeline.gl.context").shared_worker().call(lambda context: type(context.mglo._context).__module__).rpartition(".")[2]


def show() -> Generator:
    """The live view's picture of the cube, waited for; the generator's return value."""
    bpy.context.scene.render.engine = ENGINE
    view().spaces.active.shading.type = "RENDERED"
    yield from wait_for_picture()
    return picture("native", canvas())


@step
def the_systems_own_opengl_works_in_every_state() -> Generator:
    """OpenGL: Native draws what EGL draws; chosen while it is shown, disabled, with other files and commands, Blender lives on."""
    addon_utils = importlib.import_module("addon_utils")
    yield from fresh_tab()
    through_egl = yield from show()
    assert platform() == "egl"
    for backend, module in (("native", "x11"), ("auto", "egl"), ("native", "x11")):
        choose(backend)
        bpy.context.scene.objects["Cube"].location.x += 0.5  # something to draw
        yield from wait_for_picture()
        assert platform() == module
    bpy.context.scene.objects["Cube"].location.x = 0.0
    yield from wait_for_picture()
    assert changed_share(picture("native", canvas()), through_egl) < 0.01
    addon_utils.disable(MODULE, default_set=True)
    yield from settle(0.5)
    assert addon_utils.enable(MODULE, default_set=True)
    choose("native")
    assert colours((yield from show())) > 3
    bpy.ops.wm.read_homefile(app_template="", load_ui=False)
    assert colours((yield from show())) > 3
    bpy.context.scene.cad_shadow.map_size = 256
    yield from command("preview")
    yield from until(lambda: editors() == ["CAD Shadow Preview"], "the picture")
    assert platform() == "x11"
    yield from close_extra_windows()
    with here():
        bpy.ops.cad_shadow.compare("INVOKE_DEFAULT")
    yield 0.5
    choose("auto")  # while it works
    yield from until(lambda: working() == [], "the comparison's end")
    yield from close_extra_windows()
    yield from show()
    assert platform() == "egl"


@step
def it_is_left_with_everything_at_work() -> Generator:
    """With the system's own OpenGL, the live view on a plant and a comparison at work, Blender is quit (how it ends is judged below)."""
    yield from fresh_tab()
    choose("native")
    plant()
    bpy.context.scene.render.engine = ENGINE
    view().spaces.active.shading.type = "RENDERED"
    yield from wait_for_picture()
    assert platform() == "x11"
    with here():
        assert bpy.ops.cad_shadow.compare("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from until(lambda: work_of_compare() == "tracing rays", "the rays")
    view().spaces.active.region_3d.view_distance *= 1.1
    yield 0.1


def work_of_compare() -> str:
    """The stage that the comparison is in."""
    return addon("operators.ticking")._running[0]._pending.progress[1]
