"""The two laws of threads, watched at run time: bpy is never touched on the GL worker, GL is never touched on Blender's threads."""

import importlib
import sys
import threading

import pytest


def is_bpy(frame, event, argument) -> bool:
    """Whether a call runs code that could touch Blender: of a module that holds bpy, or with a Blender object among its arguments.

    (Blender's own functions are invisible to Python's profiler, so the watch looks at who could call them.)
    """
    if event != "call":
        return False
    import bpy

    return "bpy" in frame.f_globals or any(isinstance(value, bpy.types.bpy_struct) for value in frame.f_locals.values())


def is_gl(frame, event, argument) -> bool:
    """Whether a profiler event is a call into moderngl's C part, or of a moderngl method that makes, uses or frees GL objects."""
    if event == "c_call":
        owner = getattr(argument, "__self__", None)
        return type(owner).__module__ in ("mgl", "_moderngl", "egl", "glcontext.egl") or (getattr(argument, "__module__", None) or "") in (
            "mgl",
            "_moderngl",
        )
    return False


@pytest.fixture
def watched(extension, cube_scene):
    """Renders the scene with every thread's calls recorded; gives the calls (bpy on the worker, GL elsewhere, GL on the worker)."""
    context = importlib.import_module(extension.__name__ + ".pipeline.gl.context")
    context.shutdown()
    bpy_on_worker, gl_elsewhere, gl_on_worker = [], [], []
    is_worker: dict[int, bool] = {}

    def watch(frame, event, argument):
        ident = threading.get_ident()
        if ident not in is_worker:
            is_worker[ident] = any(t.ident == ident and t.name == context.THREAD_NAME for t in threading.enumerate())
        on_worker = is_worker[ident]
        if on_worker and is_bpy(frame, event, argument):
            bpy_on_worker.append((frame.f_code.co_name, argument))
        if is_gl(frame, event, argument):
            (gl_on_worker if on_worker else gl_elsewhere).append((frame.f_code.co_name, argument))

    import bpy

    threading.setprofile(watch)
    sys.setprofile(watch)
    try:
        bpy.ops.render.render()
        context.shutdown()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    return bpy_on_worker, gl_elsewhere, gl_on_worker


def test_bpy_is_never_touched_on_the_worker_nor_gl_off_it(watched):
    bpy_on_worker, gl_elsewhere, gl_on_worker = watched
    assert len(gl_on_worker) > 50  # the watch sees what it is to see
    assert bpy_on_worker == []
    assert gl_elsewhere == []


def test_the_watch_would_see_bpy(cube_scene):
    """A watch that cannot see is no guard: the same predicate on the main thread, on code that is handed a Blender object."""
    seen = []

    def touches(scene):
        return scene.name

    sys.setprofile(lambda frame, event, argument: seen.append(event) if is_bpy(frame, event, argument) else None)
    try:
        touches(cube_scene)
    finally:
        sys.setprofile(None)
    assert seen
