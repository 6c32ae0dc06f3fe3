"""Steps of the tour: the tab, its panels and their buttons."""

from collections.abc import Generator

import bpy
import numpy as np
from harness import (
    box_of,
    changed_share,
    click,
    colours,
    hover,
    picture,
    press,
    region,
    settle,
    step,
    until,
    view,
    window,
)
from room import BUTTON_PX, MODULE, addon, file_name, fresh_tab, header, header_of, here, open_tab, remember, top_panels


@step
def the_tab_opens() -> Generator:
    """The sidebar has the tab "CAD Shadow"."""
    yield from open_tab()
    picture("first_sight")


@step
def every_panel_opens() -> Generator:
    """Each panel opens with a click on its header and shows something, the last report too; sub-panels open within it."""
    yield from fresh_tab()
    bpy.context.scene.objects["Light"].data.type = "SUN"
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1.2))
    with here():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.context.scene.objects["Cube"].select_set(True)
        assert bpy.ops.cad_shadow.impostor_create("EXEC_DEFAULT") == {"FINISHED"}
        assert bpy.ops.cad_shadow.analyse("EXEC_DEFAULT") == {"FINISHED"}
    yield from settle()
    closed = picture("panels_closed", box_of(region("UI")))
    for i, cls in enumerate(top_panels()):
        yield from click(*header(i))
        yield 0.4
        x, y, width, height = box_of(region("UI"))
        shown = picture("panel_" + file_name(cls.bl_label), (x, y, width, height))
        assert changed_share(shown, closed) > 0.001, f"the panel {cls.bl_label} shows nothing"
        used = np.flatnonzero((np.abs(shown.astype(int) - closed).max(axis=2) > 12).any(axis=1))[-1] + 12
        picture("panel_" + file_name(cls.bl_label), (x, y + height - min(used, height), width, min(used, height)))
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
def advice_works_while_the_window_lives() -> Generator:
    """Advise searches beside the window, the panel shows the table, Apply writes the settings."""
    yield from fresh_tab()
    props = bpy.context.scene.cad_shadow
    props.map_size = 128
    with here():
        assert bpy.ops.cad_shadow.advise("EXEC_DEFAULT", goal="TEXELS", texels=1.0, seconds=20.0) == {"RUNNING_MODAL"}
    yield from until(lambda: addon("blender.session").last_advice(), "the advice", 90)
    yield from click(*header_of("advice"))
    yield from settle(0.6)
    picture("advice", box_of(region("UI")))
    bpy.ops.cad_shadow.apply_advice()
    assert props.map_size == addon("blender.session").last_advice()["proposal"]["map_size"]
    yield from click(*header_of("advice"))


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
