"""Steps of the tour: windows, and whether what stands in them agrees. A command opens at most one window, once, and ends."""

import importlib
from collections.abc import Generator

import bpy
import numpy as np
from harness import (
    OUT,
    changed_share,
    close_extra_windows,
    picture,
    press,
    region,
    settle,
    step,
    until,
    view,
    window,
    xdotool,
)
from mathutils import Euler
from room import (
    ENGINE,
    MODULE,
    addon,
    agree,
    called,
    canvas,
    click_away,
    command,
    editors,
    fresh_tab,
    here,
    live_key,
    live_view,
    plant,
    present_job,
    wait_for_picture,
    working,
    write_box,
)

PICTURES = {
    "preview": "CAD Shadow Preview",
    "light_view": "CAD Shadow Preview: light's view",
    "compare": "CAD Shadow Preview: difference from ray-traced truth",
    "sun_study": "CAD Shadow Preview: sun study",
}


def small_pictures() -> None:
    """Settings with which every command is quick."""
    scene = bpy.context.scene
    scene.render.engine, scene.render.resolution_percentage = ENGINE, 40
    scene.cad_shadow.map_size, scene.cad_shadow.samples, scene.cad_shadow.sun.steps = 256, "1", 2


@step
def commands_share_one_window_and_f12_is_seen() -> Generator:
    """Commands that show a picture end, share one window however often they are called, and F12 shows its render in it, uncovered."""
    yield from fresh_tab()
    small_pictures()
    for name in (*PICTURES, "preview", "compare"):
        yield from command(name)
        yield from until(lambda title=PICTURES[name]: title in editors(), f"the picture of {name}")
        assert len(bpy.context.window_manager.windows) == 2, f"{name}: {editors()}"
    done = []
    bpy.app.handlers.render_complete.append(lambda *_: done.append(True))
    yield from press("F12")
    yield from until(lambda: done, "the render")
    bpy.app.handlers.render_complete.pop()
    yield from settle(0.6)
    assert editors() == ["Render Result"] and len(bpy.context.window_manager.windows) == 2
    seen = picture("f12_after_commands")
    yield 2
    assert working() == [] and editors() == ["Render Result"], "something goes on after its command"
    assert changed_share(picture("f12_after_commands"), seen) < 0.001
    yield from command("preview")
    yield from until(lambda: editors() == [PICTURES["preview"]], "the picture after F12")
    assert len(bpy.context.window_manager.windows) == 2


@step
def a_picture_goes_to_an_image_editor_that_is_open() -> Generator:
    """With an Image Editor in the window no other window opens; one that shows an image of the user's, or is pinned, is left alone."""
    yield from fresh_tab()
    small_pictures()
    area = next(area for area in window().screen.areas if area.type == "DOPESHEET_EDITOR")
    area.type = "IMAGE_EDITOR"
    yield from settle()
    yield from command("preview")
    yield from until(lambda: editors() == [PICTURES["preview"]], "the picture in the window's editor")
    assert len(bpy.context.window_manager.windows) == 1
    mine = bpy.data.images.new("Mine", 8, 8)
    area.spaces.active.image = mine
    yield from command("light_view")
    yield from until(lambda: PICTURES["light_view"] in editors(), "the picture in a window of its own")
    assert len(bpy.context.window_manager.windows) == 2
    assert area.spaces.active.image == mine


@step
def picture_panels_and_report_agree_after_every_kind_of_change() -> Generator:
    """After presets, Apply, a script, undo, redo, import and delete the live view shows the scene and settings as they are without a nudge,
    measures it, and panels read as a forced redraw would show them."""
    yield from fresh_tab()
    bpy.ops.mesh.primitive_plane_add(size=9, location=(0, 0, -1))
    bpy.context.scene.render.engine = ENGINE
    view().spaces.active.shading.type = "RENDERED"
    yield from click_away()
    yield from agree("the start")
    with here():
        assert bpy.ops.cad_shadow.analyse("EXEC_DEFAULT") == {"FINISHED"}
    yield from agree("an analysis")
    presets = addon("blender.presets").files()
    for name in ("fast", "balanced", "oil-platform", "balanced"):
        with here():
            bpy.ops.script.execute_preset("EXEC_DEFAULT", True, filepath=str(presets[name]), menu_idname="CAD_SHADOW_PT_presets")
        yield from agree(f"the preset {name}")
    yield from advice_is_applied()
    for what in ("undo", "redo"):
        with here():
            getattr(bpy.ops.ed, what)()
        yield from agree(what)
    bpy.context.scene.cad_shadow.map_size = 128  # as a script sets it
    yield from agree("a setting from a script")
    part = OUT / "part.obj"
    write_box(part, 1.0)
    with here():
        assert bpy.ops.cad_shadow.import_cad("EXEC_DEFAULT", True, filepath=str(part)) == {"FINISHED"}
    yield from until(lambda: bpy.data.objects.get("part"), "the import")
    yield 1  # the view's way to the part
    yield from agree("an import")
    with here():
        bpy.ops.object.delete("EXEC_DEFAULT", True)
    yield from agree("a deletion")
    with here():
        bpy.ops.ed.undo()
    yield from agree("the deletion undone")
    part.unlink()


def advice_is_applied() -> Generator:
    """Search, then press Apply."""
    with here():
        bpy.ops.ed.undo_push(message="before the advice")
        assert bpy.ops.cad_shadow.advise("EXEC_DEFAULT", goal="TEXELS", texels=0.5, seconds=8.0) == {"RUNNING_MODAL"}
    yield from until(lambda: working() == [] and addon("blender.session").last_advice(), "the advice", 90)
    yield from agree("the advice")
    with here():
        assert bpy.ops.cad_shadow.apply_advice("EXEC_DEFAULT", True) == {"FINISHED"}
    yield from agree("Apply")


@step
def an_emptied_scene_shows_nothing_of_the_old_model() -> Generator:
    """The live view of a scene whose objects were deleted shows no model, and the model again when that is undone; maps and errors too."""
    yield from fresh_tab()
    bpy.context.scene.render.engine = ENGINE
    bpy.context.scene.cad_shadow.display = "aliasing"
    view().spaces.active.shading.type = "RENDERED"
    view().spaces.active.region_3d.view_distance = 6.0
    yield from wait_for_picture()
    r = region("WINDOW")
    box = (r.x + 120, r.y + 20, r.width // 2, r.height // 2)
    model = picture("emptied_before", box)
    with here():
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.ed.undo_push(message="deleted")
    live = live_view()
    yield from until(lambda: "nothing to draw" in live.message, "the word that there is nothing to draw")
    yield from settle()
    empty = picture("emptied", box)
    assert live._image is None
    assert changed_share(empty, model) > 0.02, "the old model stays"
    view().spaces.active.shading.type = "SOLID"
    yield from settle()
    view().spaces.active.shading.type = "RENDERED"
    yield from settle()
    assert changed_share(picture("emptied_anew", box), empty) < 0.002, "something of the old model stays"
    with here():
        bpy.ops.ed.undo()
    yield from wait_for_picture()
    assert changed_share(picture("emptied_undone", box), model) < 0.005


@step
def the_automatic_sun_stands_in_the_world() -> Generator:
    """Without a light that reaches the plant, the sun stays where it is while the view turns; Follows the View turns it."""
    yield from fresh_tab()
    plant()
    bpy.context.scene.render.engine = ENGINE
    view().spaces.active.shading.type = "RENDERED"
    found = {}
    for source in ("AUTOMATIC", "VIEW"):
        bpy.context.scene.cad_shadow.light_source = source
        for turn in (0.0, 1.0, 2.0):
            rv3d = view().spaces.active.region_3d
            rv3d.view_rotation.rotate(Euler((0.0, 0.0, turn)))
            rv3d.update()
            yield from wait_for_picture()
            assert live_key() == present_job().key
            found.setdefault(source, []).append(present_job().light.direction_ws)
            picture(f"sun_{source.lower()}_{turn:.0f}", canvas())
    assert np.ptp(found["AUTOMATIC"], axis=0).max() == 0.0
    assert np.ptp(found["VIEW"], axis=0).max() > 0.3
    assert addon("blender.light_kind").light_type(bpy.context) == "SUN"
    bpy.context.scene.cad_shadow.light_source = "AUTOMATIC"


@step
def a_plant_after_a_small_part_is_seen_as_well_as_before() -> Generator:
    """A part of some millimetres is seen from near; what is imported after it is seen with the near distance that it would have had."""
    yield from fresh_tab()
    space = view().spaces.active
    before = space.clip_start, space.clip_end
    for size, name in ((0.004, "bolt.obj"), (120.0, "hall.obj")):
        path = OUT / name
        write_box(path, size)
        with here():
            assert bpy.ops.cad_shadow.import_cad("EXEC_DEFAULT", True, filepath=str(path), replaces_cube=True) == {"FINISHED"}
        yield 1
        yield from settle()
        picture("clip_" + path.stem, canvas())
        assert space.clip_start < size / 50, f"near {space.clip_start} cuts into {name}"
        path.unlink()
    assert space.clip_start == before[0] and space.clip_end >= before[1]


@step
def it_can_be_disabled_while_commands_work() -> Generator:
    """Disabled during a comparison, a preview or a search, it leaves no operator and no window behind, and can be enabled again."""
    addon_utils = importlib.import_module("addon_utils")
    yield from fresh_tab()
    plant()
    small_pictures()
    yield from click_away()
    for name, options in (("compare", {}), ("preview", {}), ("advise", {"goal": "TEXELS", "texels": 1.0, "seconds": 60.0})):
        call = "EXEC_DEFAULT" if name == "advise" else "INVOKE_DEFAULT"
        yield from xdotool("mousemove_relative", "--", -5 if name == "preview" else 5, 3)  # see `takes_operators`
        with here():
            assert getattr(bpy.ops.cad_shadow, name)(call, **options) == {"RUNNING_MODAL"}
        yield 0.7
        addon_utils.disable(MODULE, default_set=True)
        yield from settle(0.5)
        assert called() == []
        assert addon_utils.enable(MODULE, default_set=True)
        assert len(bpy.context.window_manager.windows) == 1
        yield from settle()
    yield from command("preview")  # no event since the search was dropped
    yield from until(lambda: editors() == [PICTURES["preview"]], "a picture after all that")
    yield from close_extra_windows()
