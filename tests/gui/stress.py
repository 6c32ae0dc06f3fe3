"""`./dev gui-test stress`: long use of one window, with numbers. Not part of the tour, which has to stay short.

The numbers go to result.json and to the terminal. Only leaks and crashes are judged; times are written down, since machines differ.
"""

import ctypes
import gc
import importlib
import sys
import threading
import time
from collections.abc import Generator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from harness import OUT, close_extra_windows, region, results, run, settle, step, until, view, window  # noqa: E402 - see above

MODULE = "bl_ext.user_default.cad_shadow_preview"
ENGINE = "CAD_SHADOW_PREVIEW"
KINDS = ("Texture", "Buffer", "Framebuffer", "Program", "Shader", "VertexArray", "Renderbuffer")
MOST_GL_NAMES = 4000
PREVIEWS, REGISTRATIONS, FILES, UNDOS = 200, 100, 50, 50
SHOWN_EVERY = 5


def addon(name: str):
    """A module of the installed extension."""
    return importlib.import_module(f"{MODULE}.addon.{name}")


def gl_objects() -> int:
    """GL objects alive in the worker's context, asked from the driver."""

    def count(context) -> int:
        load = context.mglo._context.load_opengl_function
        asks = [ctypes.CFUNCTYPE(ctypes.c_ubyte, ctypes.c_uint)(load(f"glIs{kind}")) for kind in KINDS]
        return sum(bool(ask(name)) for ask in asks for name in range(1, MOST_GL_NAMES))

    return addon("pipeline.gl.context").shared_worker().call(count)


def memory() -> Generator:
    """Resident MiB of this process, as the host last wrote it, with all that is free given back; the generator's return value."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    yield 3
    return int((OUT / "memory").read_text()) / 2**20


def snapshot() -> Generator:
    """What may leak, after one preview of the same view; the generator's return value."""
    preview()
    yield from close_extra_windows()
    yield from settle()
    handlers = [f for name in dir(bpy.app.handlers) if isinstance(listed := getattr(bpy.app.handlers, name), list) for f in listed]
    return {
        "GL objects": gl_objects(),
        "threads": threading.active_count(),
        "handlers": len(handlers),
        "images": len(bpy.data.images),
        "memory MiB": round((yield from memory()), 1),
    }


def preview() -> None:
    """One preview, waited for."""
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
        assert bpy.ops.cad_shadow.preview("EXEC_DEFAULT") == {"FINISHED"}


def fresh() -> Generator:
    """A new file, small maps, the engine in Rendered shading."""
    bpy.ops.wm.read_homefile(app_template="", load_ui=False)
    yield 0.5
    scene = bpy.context.scene
    scene.cad_shadow.map_size, scene.cad_shadow.samples, scene.render.engine = 256, "1", ENGINE
    view().spaces.active.shading.type = "RENDERED"
    yield from settle()


def say(what: str) -> None:
    """Into Blender's log: what begins, when, and with how much memory."""
    print(f"{time.strftime('%H:%M:%S')} {int((OUT / 'memory').read_text()) >> 20} MiB, {what}", flush=True)


def work(previews: int, registrations: int, files: int, undos: int) -> Generator:
    """So many of each, in the live view."""
    yield from fresh()
    say(f"{previews} previews")
    for _ in range(previews):
        preview()
        yield 0.0
    yield from close_extra_windows()
    say(f"{registrations} registrations")
    addon_utils = importlib.import_module("addon_utils")
    for i in range(registrations):
        addon_utils.disable(MODULE, default_set=True)
        assert addon_utils.enable(MODULE, default_set=True)
        if i % SHOWN_EVERY == 0:  # a new OpenGL context, whose shaders a software driver compiles for seconds
            view().spaces.active.shading.type = "RENDERED"
            yield from until(lambda: any(live._shown for live in addon("blender.viewport")._views), "a picture", 120)
        yield 0.05
    yield from fresh()
    names = [OUT / "a.blend", OUT / "b.blend"]
    for i, name in enumerate(names):
        bpy.context.scene.objects["Cube"].scale.x = i + 1.0
        bpy.ops.wm.save_as_mainfile(filepath=str(name), copy=True)
    say(f"{files} files")
    for i in range(files):
        bpy.ops.wm.open_mainfile(filepath=str(names[i % 2]), load_ui=False)
        view().spaces.active.shading.type = "RENDERED"
        yield 0.1
    for name in names:
        name.unlink()
    say(f"{undos} undos")
    yield from undo_and_redo(undos)
    yield from fresh()


def undo_and_redo(count: int) -> Generator:
    """Edits, undone and redone while the live view shows them."""
    bpy.ops.ed.undo_push(message="before")
    for i in range(count):
        bpy.context.scene.objects["Cube"].location.x = 0.1 * (i + 1)
        bpy.ops.ed.undo_push(message=f"moved {i}")
        yield 0.05
        for verb, expected in ((bpy.ops.ed.undo, 0.1 * i), (bpy.ops.ed.redo, 0.1 * (i + 1))):
            with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
                verb()
            yield 0.05
            assert abs(bpy.context.scene.objects["Cube"].location.x - expected) < 1e-6


@step
def long_use_leaks_nothing() -> Generator:
    """Previews, registrations, file loads, undo and redo, many times in one window: nothing is left behind, memory stays within 5 %."""
    yield from work(PREVIEWS // 10, REGISTRATIONS // 10, FILES // 10, UNDOS // 10)  # what is loaded on first use is no leak
    before = yield from snapshot()
    yield from work(PREVIEWS, REGISTRATIONS, FILES, UNDOS)
    after = yield from snapshot()
    counts = {"previews": PREVIEWS, "registrations": REGISTRATIONS, "files": FILES, "undos": UNDOS}
    results["numbers"] = {"counts": counts, "before": before, "after": after}
    assert {k: v for k, v in after.items() if k != "memory MiB"} == {k: v for k, v in before.items() if k != "memory MiB"}
    assert after["memory MiB"] < 1.05 * before["memory MiB"]


run(sys.argv[sys.argv.index("--") + 1 :])
