"""A first-time user's way through the extension, in a real window. Each step is a claim; the pictures serve the documentation."""

import importlib
import sys
from collections.abc import Generator
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from harness import (  # noqa: E402 - its folder is known only now
    OUT,
    box_of,
    changed_share,
    click,
    close_extra_windows,
    colours,
    hover,
    picture,
    point,
    press,
    region,
    run,
    settle,
    step,
    until,
    view,
    window,
    xdotool,
)

MODULE = "bl_ext.user_default.cad_shadow_preview"
TAB = "CAD Shadow"
ENGINE = "CAD_SHADOW_PREVIEW"
# Measured at UI scale 1: the middle of the first header below the top, from one closed header to the next, to the button below the presets.
FIRST_HEADER_PX, HEADER_PX, BUTTON_PX = 14, 28, 62


def addon(name: str):
    """A module of the installed extension."""
    return importlib.import_module(f"{MODULE}.addon.{name}")


def own_panels() -> list[type]:
    """The tab's panels, sub-panels too, as registered."""
    panels = [cls for cls in bpy.types.Panel.__subclasses__() if getattr(cls, "bl_category", "") == TAB and "bl_rna" in vars(cls)]
    return sorted(panels, key=lambda cls: cls.bl_order)


def top_panels() -> list[type]:
    """The tab's panels that are no sub-panels, from top to bottom."""
    return [cls for cls in own_panels() if not getattr(cls, "bl_parent_id", "")]


def header(index: int) -> tuple[float, float]:
    """Where the header of the panel is while all above it are closed."""
    r = region("UI")
    return r.x + 0.3 * r.width, r.y + r.height - FIRST_HEADER_PX - HEADER_PX * index


def header_of(key: str) -> tuple[float, float]:
    """The header of the panel whose class name ends so."""
    return header(next(i for i, cls in enumerate(top_panels()) if cls.__name__.endswith(key)))


def open_tab() -> Generator:
    """Show the sidebar at the extension's tab."""
    view().spaces.active.show_region_ui = True
    yield from until(lambda: region("UI").width > 50, "the sidebar's animation")
    yield 0.5
    yield from until(lambda: region("UI").active_panel_category not in ("", "UNSUPPORTED"), "the sidebar's first drawing")
    region("UI").active_panel_category = TAB  # raises when no such tab is drawn
    yield from settle()


def fresh_tab() -> Generator:
    """A new file in Blender's default window, the tab open, its panels closed (so that their places are known), sub-panels open."""
    panels = sorted(own_panels(), key=lambda cls: bool(getattr(cls, "bl_parent_id", "")))
    for cls in reversed(panels):
        bpy.utils.unregister_class(cls)
    for cls in panels:
        cls.bl_options = {"DEFAULT_CLOSED"} if not getattr(cls, "bl_parent_id", "") else set()
        bpy.utils.register_class(cls)
    bpy.ops.wm.read_homefile(app_template="")
    yield 1
    yield from open_tab()


def remember() -> object:
    """The last outcome that the extension remembers."""
    return addon("session").last()


def canvas() -> tuple[int, int, int, int]:
    """The part of the viewport that no sidebar, toolbar or header covers, as a box."""
    r = region("WINDOW")
    return r.x + 120, r.y + 20, r.width - 120 - region("UI").width - 120, r.height - 120


@step
def the_tab_opens() -> Generator:
    """The sidebar has the tab "CAD Shadow"."""
    yield from open_tab()
    picture("first_sight")


@step
def every_panel_opens() -> Generator:
    """Each panel opens with a click on its header and shows something, the last report too; sub-panels open within it."""
    yield from fresh_tab()
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
        assert bpy.ops.cad_shadow.analyse("EXEC_DEFAULT") == {"FINISHED"}
    yield from settle()
    closed = picture("panels_closed", box_of(region("UI")))
    for i, cls in enumerate(top_panels()):
        yield from click(*header(i))
        yield 0.4
        shown = picture("panel_" + cls.bl_label.lower().replace(" ", "_").replace("&", "and"), box_of(region("UI")))
        assert changed_share(shown, closed) > 0.001, f"the panel {cls.bl_label} shows nothing"
        yield from click(*header(i))
        yield 0.4
    assert changed_share(picture("panels_closed", box_of(region("UI"))), closed) < 0.0005, "a panel did not close again"


@step
def the_preview_button_makes_a_picture() -> Generator:
    """A click on Preview shows the picture in an Image Editor."""
    yield from fresh_tab()
    yield from click(*header(0))
    x, y = header(0)
    yield from hover(x + 40, y - BUTTON_PX)
    yield 1.2
    picture("tooltip")
    yield from click(x + 40, y - BUTTON_PX)
    yield from until(remember, "the preview")
    yield from settle(0.6)
    image = bpy.data.images["CAD Shadow Preview"]
    assert image.size[0] > 100
    assert image.size[1] > 100
    editors = [area for w in bpy.context.window_manager.windows for area in w.screen.areas if area.type == "IMAGE_EDITOR"]
    assert any(area.spaces.active.image == image for area in editors), "no Image Editor shows the picture"
    assert colours(picture("preview")) > 500


@step
def a_plant_is_shown_with_its_shadows_and_its_error() -> Generator:
    """Rendered shading shows the example deck with shadows, and its error as a heat map."""
    yield from fresh_tab()
    scene = bpy.context.scene
    for name in ("Cube", "Light", "Camera"):
        bpy.data.objects.remove(scene.objects[name])
    addon("cad_import").to_blender(addon("platform_deck").build(20_000), scene.collection)
    scene.render.engine = ENGINE
    assert scene.view_settings.view_transform == "AgX"  # Blender's default, which must not touch data
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.view3d.view_all()
    view().spaces.active.shading.type = "RENDERED"
    view().spaces.active.overlay.show_relationship_lines = False
    yield from click(*header(0))
    yield from wait_for_picture()
    shaded = picture("deck_rendered")
    scene.cad_shadow.display = "aliasing"
    yield from wait_for_picture()
    tinted = picture("deck_aliasing")
    assert changed_share(tinted, shaded) > 0.05, "the heat map does not show"
    check_legend(tinted)
    check_data_colours(tinted)
    scene.cad_shadow.display = "partitions"
    yield from wait_for_picture()
    tinted = picture("deck_partitions")
    assert changed_share(tinted, shaded) > 0.05, "the partitions do not show"
    check_legend(tinted)


def check_legend(screen) -> None:
    """The legend's colours are on the screen where its words say, whatever the view transform."""
    (legend, (left, bottom)) = next(shown.placed for shown in addon("hud.legend")._legends.values() if shown.placed)
    r, (x, y, width, height) = region("WINDOW"), legend.colors_at
    for share in (0.1, 0.35, 0.6, 0.85):
        row, column = int(share * height), int(share * width)
        if legend.colors[row, column, 3] == 1.0:
            across, down = point(r.x + left + x + column, r.y + bottom + y + height - 1 - row)
            seen, expected = screen[down, across], legend.colors[row, column, :3]
            assert np.abs(seen - 255 * srgb(expected)).max() < 8, f"the legend shows {seen}, not {255 * srgb(expected)}"


def check_data_colours(screen) -> None:
    """What the live view's picture holds is on the screen, whatever the view transform, but for Blender's lines over it."""
    (live,) = [live for live in addon("viewport")._views if live._image is not None]
    r, (x, y, width, height) = region("WINDOW"), canvas()
    image = live._image[::-1][y - r.y : y - r.y + height, x - r.x : x - r.x + width]  # row 0 at the bottom, as the window's coordinates
    (left, top) = point(x, y + height - 1)
    seen = screen[top : top + height, left : left + width][::-1]
    same = (np.abs(seen - 255 * srgb(image[..., :3])).max(axis=2) < 3).mean()
    assert same > 0.75, f"only {same:.0%} of the picture's colours are on the screen"


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
def the_overlay_shows_where_the_maps_lie() -> Generator:
    """After an analysis, Overlay draws the splits and the maps in the viewport, seen from elsewhere; Off takes them away."""
    yield from fresh_tab()
    manager = bpy.context.window_manager
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
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
    assert changed_share(shown["BOTH"], shown["SPLITS"]) > 0.0005, "the maps are missing in Both"
    manager.cad_shadow_overlay = "OFF"
    yield from settle(0.6)
    assert changed_share(picture("overlay_off", canvas()), bare) < 0.0005, "lines stay"


@step
def advice_works_while_the_window_lives() -> Generator:
    """Advise searches bit by bit, the panel shows the table, Apply writes the settings; Light's View opens its picture."""
    yield from fresh_tab()
    props = bpy.context.scene.cad_shadow
    props.map_size = 128
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
        assert bpy.ops.cad_shadow.advise("EXEC_DEFAULT", goal="TEXELS", texels=1.0, seconds=20.0) == {"RUNNING_MODAL"}
    yield from until(lambda: addon("session").last_advice(), "the advice", 90)
    yield from click(*header_of("advice"))
    yield from settle(0.6)
    picture("advice", box_of(region("UI")))
    bpy.ops.cad_shadow.apply_advice()
    assert props.map_size == addon("session").last_advice()["proposal"]["map_size"]
    yield from click(*header_of("advice"))
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
        bpy.ops.cad_shadow.light_view("EXEC_DEFAULT")
    yield from settle(0.6)
    picture("light_view")
    yield from close_extra_windows()


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


def wait_for_picture() -> Generator:
    """Until the live view shows the fine picture of the present view."""
    viewport = addon("viewport")

    def is_fine() -> bool:
        return any(live._shown and live._shown.coarseness == 1 and live._shown.key == live._wanted for live in viewport._views)

    yield from settle(0.3)
    yield from until(is_fine, "the live view's fine picture")
    yield from settle(0.3)


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
def cad_files_are_in_the_import_menu() -> Generator:
    """File > Import offers CAD files."""
    r = region("WINDOW")
    yield from hover(r.x + 300, r.y + r.height / 2)
    with bpy.context.temp_override(window=window(), area=view(), region=r):
        bpy.ops.wm.call_menu("INVOKE_DEFAULT", name="TOPBAR_MT_file_import")
    yield from settle(0.4)
    picture("import_menu")
    yield from press("Escape")
    assert any(f.__module__.startswith(MODULE) for f in bpy.types.TOPBAR_MT_file_import.draw._draw_funcs)


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


run(sys.argv[sys.argv.index("--") + 1 :])
