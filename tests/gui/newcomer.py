"""`./dev gui-test newcomer`: from the zip and the README alone to a useful picture, in a Blender that was never started before.

What a person adds, reading and moving the mouse, is not in the times; what the machine needs for each step of the README is. The zip and
a CAD file (tests/gui/sample.py) lie in $OUT.
"""

import os
import sys
import time
from collections.abc import Generator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from harness import OUT, click, close_extra_windows, colours, hover, picture, press, region, results, run, settle, step, until, view  # noqa: E402
from room import BUTTON_PX, ENGINE, TAB, addon, canvas, header, here, remember, wait_for_picture  # noqa: E402

numbers = results.setdefault("numbers", {})
_begun = [float(os.environ["STARTED"])]


def mark(what: str) -> None:
    """Note the seconds since the last mark."""
    now = time.time()
    numbers[what] = round(now - _begun[0], 1)
    _begun[0] = now


def again() -> None:
    """What follows is timed from now on: a picture for this test was taken meanwhile."""
    _begun[0] = time.time()


@step
def from_the_zip_to_a_picture() -> Generator:
    """By the README's steps the zip is installed, a CAD file comes in without the start-up cube, and a press of the button shows it."""
    mark("Blender's start")
    yield from press("Escape")  # the splash
    again()
    package = next(OUT.glob("*.zip"))
    with here():
        done = bpy.ops.extensions.package_install_files(filepath=str(package), repo="user_default", enable_on_install=True)
    assert done == {"FINISHED"}
    mark("install from disk")
    yield from drop()
    with here():
        bpy.ops.ed.undo_push(message="imported")
    yield from press("n")
    yield from until(lambda: region("UI").width > 50, "the sidebar's animation")
    yield from until(lambda: region("UI").active_panel_category not in ("", "UNSUPPORTED"), "the sidebar's first drawing")
    region("UI").active_panel_category = TAB
    yield from settle()
    picture("newcomer_sidebar")
    x, y = header(0)
    yield from hover(x + 40, y - BUTTON_PX)
    again()
    yield from click(x + 40, y - BUTTON_PX)
    yield from until(remember, "the picture")
    mark("CAD Shadow Preview, until the picture is there")
    yield from settle(0.6)
    assert colours(picture("newcomer_picture")) > 500
    numbers["triangles"] = remember().report["geometry"]["triangles"]
    numbers["warnings"] = remember().report["warnings"]


def drop() -> Generator:
    """The CAD file dropped into the viewport: Blender calls the importer so, and shows its options; Return confirms."""
    r = region("WINDOW")
    yield from hover(r.x + r.width / 2, r.y + r.height / 2)
    with here():
        path = OUT / "plant.glb"
        bpy.ops.cad_shadow.import_cad("INVOKE_DEFAULT", filepath=str(path), directory=f"{OUT}/", files=[{"name": path.name}])
    yield from settle(0.5)
    picture("newcomer_import")
    again()
    yield from press("Return", r.x + r.width / 2 + 5, r.y + r.height / 2 + 5)
    yield from until(lambda: "plant" in bpy.data.collections, "the file")
    mark("import of the CAD file")
    assert "Cube" not in bpy.data.objects
    yield from settle(0.6)
    picture("newcomer_imported")


@step
def the_live_view_needs_two_choices() -> Generator:
    """With the engine chosen, Rendered shading shows the plant."""
    yield from close_extra_windows()
    again()
    bpy.context.scene.render.engine = ENGINE
    view().spaces.active.shading.type = "RENDERED"
    yield from until(lambda: any(live._shown for live in addon("blender.viewport")._views), "the first picture")
    mark("Rendered shading, until the first picture is there")
    yield from wait_for_picture()
    assert colours(picture("newcomer_live", canvas())) > 500


run(sys.argv[sys.argv.index("--") + 1 :])
