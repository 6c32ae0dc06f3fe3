"""Steps of the tour: sun, presets, search, preferences, import, and buttons that are grey."""

from collections.abc import Generator
from pathlib import Path

import bpy
import numpy as np
from harness import OUT, changed_share, click, colours, hover, picture, press, region, settle, step, until, view, window, xdotool
from room import BUTTON_PX, ENGINE, MODULE, addon, canvas, fresh_tab, header, here, plant, wait_for_picture

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


@step
def the_sun_is_placed_studied_and_animated() -> Generator:
    """Place Sun turns a sun to the place and time, Sun Study opens a sheet of the day, Animate Sun sets keyframes; undo takes them back."""
    yield from fresh_tab()
    plant()
    scene, props = bpy.context.scene, bpy.context.scene.cad_shadow
    props.sun.steps, props.map_size, props.samples = 6, 512, "1"
    scene.frame_end = 10
    with here():
        assert bpy.ops.cad_shadow.place_sun("EXEC_DEFAULT", True) == {"FINISHED"}
    sun = props.light
    assert props.light_source == "OBJECT"
    assert sun.matrix_world.col[2].z > 0.3, "the noon sun of June stands high"
    with here():
        assert bpy.ops.cad_shadow.sun_study("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from until(lambda: "CAD Shadow Preview: sun study" in bpy.data.images, "the sheet", 120)
    yield from settle(0.6)
    assert colours(picture("sun_study")) > 500
    with here():
        assert bpy.ops.cad_shadow.animate_sun("EXEC_DEFAULT", True) == {"FINISHED"}
    assert sun.animation_data.action.frame_range[1] == 10
    with here():
        bpy.ops.ed.undo()
    animation = bpy.context.scene.cad_shadow.light.animation_data
    assert animation is None or animation.action is None, "undo leaves keyframes"


@step
def presets_set_the_method() -> Generator:
    """The list of presets opens; each preset can be loaded, changes the settings, and Undo takes it back."""
    yield from fresh_tab()
    presets = addon("blender.presets")
    with here():
        bpy.ops.ed.undo_push(message="before")
    before = (bpy.context.scene.cad_shadow.map_size, bpy.context.scene.cad_shadow.partition)
    found = []
    for name, path in presets.files().items():
        with here():
            bpy.ops.script.execute_preset("EXEC_DEFAULT", True, filepath=str(path), menu_idname="CAD_SHADOW_PT_presets")
        props = bpy.context.scene.cad_shadow
        found.append((name, (props.partition, props.partitions, props.map_size, props.test, props.samples)))
        with here():
            bpy.ops.ed.undo()
        props = bpy.context.scene.cad_shadow
        assert (props.map_size, props.partition) == before, f"undo does not take {name} back"
    assert len({method for _, method in found}) == len(found) >= 6, "two presets are alike"
    r = region("WINDOW")
    yield from hover(r.x + r.width * 0.4, r.y + r.height * 0.7)
    yield from settle()
    bare = picture("presets", canvas())
    with here():
        bpy.ops.wm.call_panel("INVOKE_DEFAULT", name="CAD_SHADOW_PT_presets")
    yield from settle(0.5)
    assert changed_share(picture("presets", canvas()), bare) > 0.01, "the list does not show"
    yield from press("Escape")


@step
def search_finds_what_the_extension_can_do() -> Generator:
    """F3 finds the extension's commands by name; each has a tooltip."""
    yield from fresh_tab()
    r = region("WINDOW")
    box = (r.x + 120, r.y + r.height // 3, 640, r.height // 2)
    bare = picture("search", box)
    yield from press("F3", box[0] + box[2] / 2, box[1] + 0.9 * box[3])
    yield from xdotool("type", "--delay", "60", "cad shadow")
    yield from settle(0.6)
    assert changed_share(picture("search", box), bare) > 0.1, "the search shows nothing"
    yield from press("Escape")
    yield from press("Escape")
    for name in dir(bpy.ops.cad_shadow):
        kind = getattr(bpy.ops.cad_shadow, name).get_rna_type()
        assert len(kind.description) > 15, f"{name} does not say what it does"


@step
def grey_buttons_say_why() -> Generator:
    """With nothing to draw the buttons are grey, and a tooltip says why."""
    yield from fresh_tab()
    for ob in list(bpy.context.scene.objects):
        bpy.data.objects.remove(ob)
    yield from settle()
    x, y = header(0)
    yield from xdotool("mousemove", 400, 600)
    yield from click(x, y)
    yield from hover(x + 40, y - BUTTON_PX)
    yield 1.5
    picture("grey_tooltip")
    yield from click(x, y)
    for name in ("preview", "analyse", "light_view", "sun_study", "advise", "fit_clip", "frame_camera", "export_report", "apply_advice"):
        with here():
            try:
                getattr(bpy.ops.cad_shadow, name)("EXEC_DEFAULT")
            except RuntimeError as error:
                assert "poll() " in str(error), error
                assert ":" in str(error).partition("poll() ")[2], f"{name} does not say why it is grey: {error}"
            else:
                raise AssertionError(f"{name} runs with nothing to draw")


@step
def a_cad_file_comes_in() -> Generator:
    """Import CAD reads a file into objects, in view and none of them selected; a file that is none is refused in one line."""
    yield from fresh_tab()
    good, bad = OUT / "part.obj", OUT / "broken.glb"
    good.write_text(TETRAHEDRON)
    bad.write_bytes(b"nothing of the kind")
    with here():
        assert bpy.ops.cad_shadow.import_cad("EXEC_DEFAULT", True, filepath=str(good), units="cm", replaces_cube=True) == {"FINISHED"}
    assert "Cube" not in bpy.data.objects
    assert not bpy.context.selected_objects and bpy.context.object.type == "MESH"
    assert np.isclose(max(bpy.context.object.dimensions), 0.01)
    yield from until(lambda: view().spaces.active.region_3d.view_distance < 0.1, "the viewport to move to the part")
    yield from settle()
    picture("imported")
    with here():
        try:
            bpy.ops.cad_shadow.import_cad("EXEC_DEFAULT", filepath=str(bad))
        except RuntimeError as error:
            assert "broken.glb" in str(error)
            assert len(str(error).strip().splitlines()) == 1
        else:
            raise AssertionError("a file that is none was taken")
    for path in (good, bad):
        Path(path).unlink()


@step
def preferences_are_shown_and_used() -> Generator:
    """The preferences have a page; rendering in a process of its own gives the same picture, which goes on when that process is killed."""
    yield from fresh_tab()
    bpy.context.scene.render.engine = ENGINE
    view().spaces.active.shading.type = "RENDERED"
    yield from wait_for_picture()
    here_made = picture("in_blender", canvas())
    preferences = bpy.context.preferences.addons[MODULE].preferences
    preferences.is_separate = True
    bpy.context.scene.objects["Cube"].location.x = 1.0
    yield from wait_for_picture()
    bpy.context.scene.objects["Cube"].location.x = 0.0
    yield from wait_for_picture()
    assert changed_share(picture("in_a_process", canvas()), here_made) < 0.001, "the picture is another one"
    child = addon("pipeline.remote.renderer").shared_remote()._child
    child.process.kill()
    bpy.context.scene.objects["Cube"].location.x = 1.0
    yield from wait_for_picture()
    assert addon("pipeline.remote.renderer").shared_remote()._child is not child
    preferences.is_separate = False
    view().spaces.active.shading.type = "SOLID"
    yield from show_preferences()


def show_preferences() -> Generator:
    """The extension's page in Blender's preferences, as a picture."""
    manager = bpy.context.window_manager
    r = region("WINDOW")
    yield from hover(r.x + r.width / 2, r.y + r.height / 2)  # where the new window goes, there being no window manager
    with here():
        bpy.ops.screen.userpref_show("INVOKE_DEFAULT")
    yield from until(lambda: len(manager.windows) == 2, "the preferences' window")
    bpy.context.preferences.active_section = "ADDONS"
    manager.addon_search = "CAD Shadow"
    with bpy.context.temp_override(window=manager.windows[-1]):
        bpy.ops.preferences.addon_expand(module=MODULE)
    yield from xdotool("search", "--name", "Preferences", "windowmove", 300, 250)
    yield from settle(0.8)
    extra = manager.windows[-1]
    assert colours(picture("preferences", (300, window().height - 250 - extra.height, extra.width, extra.height))) > 100
    bpy.context.preferences.active_section = "INTERFACE"
    manager.addon_search = ""
    assert window() == manager.windows[0]
