"""Steps of the tour: impostors, from the mark to the live view."""

from collections.abc import Generator

import bpy
import numpy as np
from harness import box_of, changed_share, click, close_extra_windows, picture, press, region, settle, step, until, view
from mathutils import Euler
from room import ENGINE, HEADER_PX, addon, canvas, fresh_tab, header_of, here, wait_for_picture

MAIN_PART_PX = 640  # the panel without its sub-panels ends so far below the sidebar's top
RED = (255, 51, 26)  # of the critical points


def two_marked() -> None:
    """Two objects of many triangles on a floor, marked as impostors; nothing selected."""
    scene = bpy.context.scene
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    scene.objects["Light"].data.type = "SUN"
    scene.objects["Light"].data.energy = 2.0
    scene.view_settings.view_transform = "Standard"
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1))
    for make, name, x in ((bpy.ops.mesh.primitive_monkey_add, "Pump", -1.5), (bpy.ops.mesh.primitive_torus_add, "Valve wheel", 1.5)):
        make(location=(x, 0, 0.2), rotation=(0.6, 0.3, 0.2))
        ob = bpy.context.object
        ob.name = name
        ob.modifiers.new("Fine", "SUBSURF").levels = 3
    with here():
        bpy.ops.object.select_all(action="DESELECT")
        for name in ("Pump", "Valve wheel"):
            bpy.data.objects[name].select_set(True)
        assert bpy.ops.cad_shadow.impostor_create("EXEC_DEFAULT") == {"FINISHED"}
        bpy.ops.object.select_all(action="DESELECT")
    scene.cad_shadow.impostor_break_even = False


@step
def the_impostors_panel_lists_what_is_marked() -> Generator:
    """What is marked stands in the Impostors panel with its numbers, before a picture and after, its sub-panels open."""
    yield from fresh_tab()
    yield from click(*header_of("impostors"))
    yield from settle(0.6)
    picture("impostors_none", box_of(region("UI")))
    two_marked()
    yield from settle(0.6)
    empty = picture("impostors_marked", box_of(region("UI")))
    with here():
        assert bpy.ops.cad_shadow.analyse("EXEC_DEFAULT") == {"FINISHED"}
    rv3d = view().spaces.active.region_3d
    rv3d.view_rotation.rotate(Euler((0.0, 0.0, 0.1)))
    rv3d.update()
    yield from settle(0.4)
    with here():
        assert bpy.ops.cad_shadow.analyse("EXEC_DEFAULT") == {"FINISHED"}
    bpy.context.window_manager.cad_shadow_impostor_index = 1
    yield from settle(0.6)
    assert changed_share(picture("impostors_panel_all", box_of(region("UI"))), empty) > 0.005, "the numbers are not shown"
    x, y, width, height = box_of(region("UI"))
    picture("impostors_panel", (x, y + height - MAIN_PART_PX, width, MAIN_PART_PX - HEADER_PX * 7))


@step
def the_impostor_report_shows_critical_points() -> Generator:
    """The report opens the texture with its critical points, and the viewport shows them on the objects; the switch takes them away."""
    yield from fresh_tab()
    two_marked()
    yield from settle(0.5)
    plain = picture("impostors_viewport_before", canvas())
    with here():
        assert bpy.ops.cad_shadow.impostor_report("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from until(lambda: "CAD Shadow Preview: critical points" in bpy.data.images, "the texture's picture")
    yield from settle(0.8)
    picture("impostors_texture")
    yield from close_extra_windows()
    shown = picture("impostors_points", canvas())
    assert reds(shown) - reds(plain) > 100, "no critical point in the viewport"
    bpy.context.window_manager.cad_shadow_impostor_points = False
    yield from settle(0.5)
    assert reds(picture("impostors_points_off", canvas())) - reds(plain) < 50


def reds(image: np.ndarray) -> int:
    """Pixels in the colour of the critical points."""
    return int((np.abs(image.astype(int) - RED).max(axis=2) < 30).sum())


@step
def the_live_view_draws_impostors() -> Generator:
    """Rendered shading draws marked objects as impostors, follows the view, and looks as the geometry does."""
    yield from fresh_tab()
    two_marked()
    bpy.context.scene.render.engine = ENGINE
    view().spaces.active.shading.type = "RENDERED"
    yield from wait_for_picture()
    session = addon("blender.session")
    captured = {"regenerated", "sprite", "warp"}
    yield from until(lambda: [r.stage in captured for r in session.impostors()] == [True, True], "both captured, one by one")
    yield from press("KP_4")
    yield from wait_for_picture()
    shown = picture("impostors_live", canvas())
    assert {r.stage for r in session.impostors()} <= {"regenerated", "sprite", "warp"}
    bpy.context.scene.cad_shadow.impostor_use = "off"
    yield from wait_for_picture()
    truth = picture("impostors_live_geometry", canvas())
    assert changed_share(shown, truth, 40) < 0.02, "the live view with impostors does not look like the geometry"
    view().spaces.active.shading.type = "SOLID"
