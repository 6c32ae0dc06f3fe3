"""Steps of the tour: the live view, what is drawn over it, F12, and the extension's life while they are shown."""

import importlib
from collections.abc import Generator, Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from harness import OUT, changed_share, click, colours, hover, picture, point, press, region, settle, step, until, view, window, xdotool
from room import ENGINE, MODULE, addon, canvas, fresh_tab, header, here, live_view, plant, wait_for_picture


@step
def a_plant_is_shown_with_its_shadows_and_its_error() -> Generator:
    """Rendered shading shows the example deck with shadows, and its error as a heat map."""
    yield from fresh_tab()
    plant()
    scene = bpy.context.scene
    scene.render.engine = ENGINE
    assert scene.view_settings.view_transform == "AgX"  # Blender's default, which must not touch data
    view().spaces.active.shading.type = "RENDERED"
    yield from click(*header(0))
    yield from wait_for_picture()
    shaded = picture("deck_rendered")
    scene.cad_shadow.display = "aliasing"
    yield from wait_for_picture()
    tinted = picture("deck_aliasing")
    assert changed_share(tinted, shaded) > 0.05, "the heat map does not show"
    check_legend(tinted)
    with bare(view().spaces.active):
        yield from settle()
        check_data_colours(picture("deck_aliasing_bare"))
    yield from settle()
    scene.cad_shadow.display = "partitions"
    yield from wait_for_picture()
    tinted = picture("deck_partitions")
    assert changed_share(tinted, shaded) > 0.05, "the partitions do not show"
    check_legend(tinted)


def check_legend(screen) -> None:
    """The legend's colours are on the screen where its words say, whatever the view transform."""
    legend, (left, bottom) = addon("blender.hud.legend")._legends[live_view()].placed
    r, (x, y, width, height) = region("WINDOW"), legend.colors_at
    for share in (0.1, 0.35, 0.6, 0.85):
        row, column = int(share * height), int(share * width)
        if legend.colors[row, column, 3] == 1.0:
            across, down = point(r.x + left + x + column, r.y + bottom + y + height - 1 - row)
            seen, expected = screen[down, across], legend.colors[row, column, :3]
            assert np.abs(seen - 255 * srgb(expected)).max() < 8, f"the legend shows {seen}, not {255 * srgb(expected)}"


def check_data_colours(screen) -> None:
    """What the live view's picture holds is on the screen, whatever the view transform, but for the legend over it."""
    r, (x, y, width, height) = region("WINDOW"), canvas()
    (left, top) = point(x, y + height - 1)
    seen, image = np.zeros((r.height, r.width, 3)), live_view()._image[::-1]  # row 0 at the bottom, as the region's coordinates
    inside = (slice(y - r.y, y - r.y + height), slice(x - r.x, x - r.x + width))
    seen[inside] = screen[top : top + height, left : left + width][::-1]
    is_same = np.abs(seen - 255 * srgb(image[..., :3])).max(axis=2) < 8  # llvmpipe's sRGB is off by up to 6 where it is dark
    legend, (a, b) = addon("blender.hud.legend")._legends[live_view()].placed
    counts = np.zeros(is_same.shape, dtype=bool)
    counts[inside] = True
    counts[int(b) : int(b) + legend.size[1] + 1, int(a) : int(a) + legend.size[0] + 1] = False
    assert is_same[counts].mean() > 0.97, f"only {is_same[counts].mean():.0%} of the picture's colours are on the screen"


@contextmanager
def bare(space: bpy.types.SpaceView3D) -> Iterator[None]:
    """Nothing of Blender's over the picture, how much there may be of it for the window's size; the overlays' own switch stays on."""
    holders = {
        space.overlay: (
            "show_floor",
            "show_axis_x",
            "show_axis_y",
            "show_cursor",
            "show_text",
            "show_stats",
            "show_extras",
            "show_outline_selected",
            "show_object_origins",
        ),
        space: ("show_gizmo",),
    }
    kept = [(holder, name, getattr(holder, name)) for holder, names in holders.items() for name in names]
    for holder, name, _ in kept:
        setattr(holder, name, False)
    try:
        yield
    finally:
        for holder, name, value in kept:
            setattr(holder, name, value)


def srgb(linear: np.ndarray) -> np.ndarray:
    """0…1 as a screen shows linear values."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


@step
def the_error_is_drawn_as_a_graph() -> Generator:
    """After an analysis, Error Graph in the Overlays popover draws the error over depth; the popover has the switches."""
    manager, shown = bpy.context.window_manager, view()
    bpy.context.scene.cad_shadow.display = "shaded"
    with bpy.context.temp_override(window=window(), area=shown, region=region("WINDOW")):
        assert bpy.ops.cad_shadow.analyse("EXEC_DEFAULT") == {"FINISHED"}
    yield from wait_for_picture()
    bare = picture("graph_off", canvas())
    manager.cad_shadow_graph = True
    yield from settle(0.6)
    picture("error_graph")
    assert 0.02 < changed_share(picture("graph_on", canvas()), bare) < 0.3, "the graph does not show"
    r = region("WINDOW")
    yield from hover(r.x + r.width * 0.5, r.y + r.height * 0.9)
    with bpy.context.temp_override(window=window(), area=shown, region=r):
        bpy.ops.wm.call_panel("INVOKE_DEFAULT", name="VIEW3D_PT_overlay")
    yield from settle(0.5)
    picture("overlays_popover")
    yield from press("Escape")
    manager.cad_shadow_graph = False
    yield from settle(0.5)
    assert changed_share(picture("graph_off", canvas()), bare) < 0.005, "the graph stays"


@step
def what_the_light_sees_is_a_picture() -> Generator:
    """Light's View opens a picture of the plant as the light sees it, in the colours of its maps."""
    view().spaces.active.shading.type = "SOLID"
    with here():
        assert bpy.ops.cad_shadow.light_view("EXEC_DEFAULT") == {"FINISHED"}
    yield from settle(0.6)
    assert colours(picture("light_view")) > 300


@step
def the_overlay_shows_where_the_maps_lie() -> Generator:
    """After an analysis, Overlay draws the splits and the maps in the viewport, seen from elsewhere; Off takes them away."""
    manager = bpy.context.window_manager
    with here():
        bpy.ops.cad_shadow.analyse("EXEC_DEFAULT")
        bpy.ops.view3d.view_orbit(angle=0.6, type="ORBITRIGHT")
        bpy.ops.view3d.view_orbit(angle=0.5, type="ORBITUP")
    view().spaces.active.region_3d.view_distance *= 2.5
    yield from settle(0.6)
    bare = picture("overlay_off", canvas())
    shown = {}
    for what in ("SPLITS", "MAPS", "BOTH"):
        manager.cad_shadow_overlay = what
        yield from settle(0.6)
        shown[what] = picture("overlay_" + what.lower(), canvas())
        assert changed_share(shown[what], bare) > 0.001, f"{what} shows nothing"
    picture("overlays_both")
    assert changed_share(shown["BOTH"], shown["SPLITS"]) > 0.0005, "the maps are missing in Both"
    manager.cad_shadow_overlay = "OFF"
    yield from settle(0.6)
    assert changed_share(picture("overlay_off", canvas()), bare) < 0.0005, "lines stay"


@step
def rendered_shading_follows_the_view() -> Generator:
    """View3D's Rendered shading shows the engine's picture, follows an orbit by mouse, and refines when still."""
    yield from fresh_tab()
    bpy.ops.mesh.primitive_plane_add(size=9, location=(0, 0, -1))
    bpy.context.scene.render.engine = ENGINE
    solid = picture("solid", canvas())
    view().spaces.active.shading.type = "RENDERED"
    yield from wait_for_picture()
    first = picture("rendered", canvas())
    assert colours(first) > 3
    assert changed_share(first, solid) > 0.05, "the shading did not change"
    r = region("WINDOW")
    yield from hover(r.x + r.width * 0.4, r.y + r.height * 0.5)
    yield from xdotool("mousedown", 2, "sleep", "0.2", "mousemove_relative", 60, 20, "sleep", "0.2", "mousemove_relative", 90, 10)
    yield 0.3
    picture("orbiting", canvas())
    yield from xdotool("mouseup", 2)
    yield from wait_for_picture()
    second = picture("orbited", canvas())
    assert changed_share(second, first) > 0.02, "the picture did not follow the orbit"
    yield 1
    assert changed_share(picture("still", canvas()), second) < 0.01, "the picture goes on changing though nothing moves"


@step
def edits_undo_and_redo_show() -> Generator:
    """The live view follows an edit, its undo and its redo."""
    before = picture("edit_before", canvas())
    bpy.ops.ed.undo_push(message="before")
    bpy.context.scene.objects["Cube"].scale = (2, 2, 0.5)
    bpy.ops.ed.undo_push(message="scaled")
    yield from wait_for_picture()
    edited = picture("edit_done", canvas())
    assert changed_share(edited, before) > 0.005
    yield from press("ctrl+z")
    yield from wait_for_picture()
    assert changed_share(picture("edit_undone", canvas()), before) < 0.005, "undo does not show"
    yield from press("ctrl+shift+z")
    yield from wait_for_picture()
    assert changed_share(picture("edit_redone", canvas()), edited) < 0.005, "redo does not show"


@step
def f12_renders_while_the_window_lives() -> Generator:
    """F12 renders with the engine on Blender's render thread and shows the result."""
    yield from fresh_tab()
    bpy.ops.mesh.primitive_plane_add(size=9, location=(0, 0, -1.2))  # of two coinciding surfaces, which one shows is not laid down
    bpy.context.scene.render.engine = ENGINE
    done, folder, scene = [], OUT / "faces", bpy.context.scene
    scene.render.resolution_percentage = 50
    folder.mkdir()
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), copy=True)
    bpy.app.handlers.render_complete.append(lambda *_: done.append(True))
    yield from press("F12")
    yield from until(lambda: done, "the render")
    bpy.app.handlers.render_complete.pop()
    yield from settle(0.6)
    assert colours(picture("f12")) > 500
    bpy.data.images["Render Result"].save_render(str(folder / "f12.exr"))  # for run.py, which compares it with the other faces


@step
def it_can_be_disabled_and_enabled_while_it_is_shown() -> Generator:
    """Disabled while the viewport shows its picture, it leaves a working Blender; enabled again, the picture is back."""
    addon_utils = importlib.import_module("addon_utils")
    view().spaces.active.shading.type = "RENDERED"
    yield from wait_for_picture()
    for _ in range(3):
        addon_utils.disable(MODULE, default_set=True)
        assert view().spaces.active.shading.type == "SOLID"  # else Blender would go on with EEVEE
        yield from settle(0.5)
        assert colours(picture("disabled", canvas())) > 3
        assert addon_utils.enable(MODULE, default_set=True)
        assert bpy.context.scene.render.engine == ENGINE
        view().spaces.active.shading.type = "RENDERED"
        yield from wait_for_picture()
    assert colours(picture("enabled_again", canvas())) > 3


@step
def another_file_opens_while_it_is_shown() -> Generator:
    """A new file, opened while Rendered shading is on, starts clean."""
    for _ in range(3):
        bpy.ops.wm.read_homefile(app_template="", load_ui=False)
        bpy.context.scene.render.engine = ENGINE
        view().spaces.active.shading.type = "RENDERED"
        yield from settle(0.3)
        yield from wait_for_picture()
    assert colours(picture("after_new_file")) > 500
