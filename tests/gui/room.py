"""The tour's room: the extension's tab in Blender's default window, and how its steps find their way about it."""

import importlib
from collections.abc import Generator

import bpy
from harness import region, settle, until, view, window

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
    addon("cad_import").to_blender(addon("platform_deck").build(20_000), scene.collection)
    view().spaces.active.overlay.show_relationship_lines = False
    with here():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.view3d.view_all()


def remember() -> object:
    """The last outcome that the extension remembers."""
    return addon("session").last()


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
    """Until the live view shows the fine picture of the present view."""
    viewport = addon("viewport")

    def is_fine() -> bool:
        return any(live._shown and live._shown.coarseness == 1 and live._shown.key == live._wanted for live in viewport._views)

    yield from settle(0.3)
    yield from until(is_fine, "the live view's fine picture")
    yield from settle(0.3)
