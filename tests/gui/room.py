"""The tour's room: the extension's tab in Blender's default window, and how its steps find their way about it."""

import importlib
from collections.abc import Generator
from contextlib import suppress
from pathlib import Path

import bpy
from harness import box_of, changed_share, hover, picture, redraw, region, settle, until, view, window

MODULE = "bl_ext.user_default.cad_shadow_preview"
TAB = "CAD Shadow"
ENGINE = "CAD_SHADOW_PREVIEW"
# Measured at UI scale 1: the middle of the first header below the top, from one closed header to the next, to the button below the presets.
FIRST_HEADER_PX, HEADER_PX, BUTTON_PX = 14, 28, 36


def addon(name: str):
    """A module of the installed extension."""
    return importlib.import_module(f"{MODULE}.addon.{name}")


def own_panels() -> list[type]:
    """The tab's panels, sub-panels too, as registered."""
    panels = [cls for cls in bpy.types.Panel.__subclasses__() if getattr(cls, "bl_category", "") == TAB and "bl_rna" in vars(cls)]
    return sorted(panels, key=lambda cls: getattr(cls, "bl_order", 0))


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


def plant() -> None:
    """The example deck in place of the start-up objects, framed by the viewport."""
    scene = bpy.context.scene
    for name in ("Cube", "Light", "Camera"):
        bpy.data.objects.remove(scene.objects[name])
    addon("blender.cad_import").to_blender(addon("scene.platform_deck").build(20_000), scene.collection)
    view().spaces.active.overlay.show_relationship_lines = False
    with here():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.view3d.view_all()


def remember() -> object:
    """The last outcome that the extension remembers."""
    return addon("blender.session").last()


def canvas() -> tuple[int, int, int, int]:
    """The part of the viewport that no sidebar, toolbar or header covers, as a box."""
    r = region("WINDOW")
    return r.x + 120, r.y + 20, r.width - 120 - region("UI").width - 120, r.height - 120


def here():
    """The context that operators called from the viewport have."""
    return bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW"))


def file_name(title: str) -> str:
    """A panel's title as part of a file name."""
    return title.lower().replace(" ", "_").replace("&", "and")


def wait_for_picture() -> Generator:
    """Until the live view shows the fine picture of the scene, the view and the settings as they are now."""
    yield from settle(0.3)
    yield from until(lambda: live_key() is not None and live_key() == present_job().key, "the live view's fine picture")
    yield from settle(0.3)


def write_box(path: Path, size: float) -> None:
    """A box of that size in metres as .obj, away from the origin."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
    lines = [f"v {size * x} {size * y} {size * (z + 2)}" for x, y, z in corners]
    path.write_text("\n".join([*lines, *("f " + " ".join(map(str, face)) for face in faces)]) + "\n")


def called() -> list[str]:
    """The extension's operators that Blender calls at every event, in any window."""
    names = []
    for one in [operator for w in bpy.context.window_manager.windows for operator in w.modal_operators]:
        with suppress(ValueError):  # of a class that was unregistered: Blender has yet to drop its place in the list
            names.append(one.bl_idname)
    return [name for name in names if "CAD_SHADOW" in name]


def working() -> list[str]:
    """Those, and the ones that have not been ended."""
    return called() + [type(operator).__name__ for operator in addon("operators.ticking")._running]


def command(name: str, **options: object) -> Generator:
    """Call an operator as its button does, and wait until it has ended."""
    with here():
        getattr(bpy.ops.cad_shadow, name)("INVOKE_DEFAULT", **options)
    yield from until(lambda: working() == [], f"the end of {name}", 180)


def editors() -> list[str]:
    """What the Image Editors of all windows show, by name."""
    areas = [area for w in bpy.context.window_manager.windows for area in w.screen.areas if area.ui_type == "IMAGE_EDITOR"]
    return [area.spaces.active.image.name for area in areas if area.spaces.active.image is not None]


def live_view() -> object | None:
    """The one live view that is on the screen."""
    shown = region("WINDOW").as_pointer()
    return next((live for live in list(addon("blender.viewport")._views) if live.region == shown), None)


def live_key() -> tuple | None:
    """What the picture that the live view shows was made of, as `Job.key` has it; None while it shows none, or a coarse one."""
    live = live_view()
    is_fine = live is not None and live._shown is not None and live._shown.coarseness <= 1 and live._image is not None
    return live._shown.key if is_fine else None


def present_job() -> object:
    """The job of the viewport as everything is now, read anew."""
    with here():
        return addon("blender.sources").ViewReading().job(bpy.context)


def click_away() -> Generator:
    """The mouse where it changes nothing: over the middle of the viewport."""
    x, y, width, height = canvas()
    yield from hover(x + width / 2, y + height / 2)


def panels() -> list[tuple[int, int, int, int]]:
    """The boxes of what shows settings: the sidebar and the properties editor."""
    properties = next(area for area in window().screen.areas if area.type == "PROPERTIES")
    return [box_of(region("UI")), box_of(region("WINDOW", properties))]


def agree(after: str) -> Generator:
    """Wait, without having anything drawn anew, until the live view shows what is there and measured it; the panels are held to that."""
    name, session = "agree_" + file_name(after).replace("-", "_"), addon("blender.session")
    yield 0.2
    yield from until(lambda: live_key() == present_job().key, f"the live view to show the scene after {after}", 60)
    yield from until(lambda: session.last() and session.is_last_current(bpy.context.scene), f"the live view's numbers after {after}", 60)
    yield 0.3
    shown = [picture(f"{name}_{i}", box) for i, box in enumerate(panels())]
    redraw()
    yield 0.3
    for i, box in enumerate(panels()):
        assert changed_share(picture(f"{name}_{i}_redrawn", box), shown[i]) < 0.0005, f"a panel is old after {after}"
    last = session.last().job
    assert last.settings == addon("blender.sources").settings_of(bpy.context.scene), f"after {after} an old report is called current"
    assert last.scene.fingerprint == present_job().scene.fingerprint, f"after {after} a report of another scene is called current"
