"""The system's own OpenGL (GLX here, WGL and CGL elsewhere): its contexts end without taking the process along.

Each claim about a real context is tried in a process of its own under a virtual X screen, since what failed was a segmentation fault.
"""

import os
import subprocess
import sys

import pytest

from addon.errors import GpuError
from addon.pipeline.gl import context as context_module
from addon.pipeline.gl import machine
from tests.conftest import ROOT

LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="GLX")
LIVES = """
from addon.pipeline.gl.context import GpuWorker
worker = GpuWorker("{backend}")
for _ in range(3):
    module, drawn = worker.call(lambda c: (type(c.mglo._context).__module__, c.texture((64, 64), 4).read()))
    assert module == "{module}", module
    worker.close()
    assert not worker.is_running
print("ended")
"""
HANDLER = """
import ctypes, ctypes.util
from addon.pipeline.gl.context import GpuWorker
x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
x11.XOpenDisplay.restype = ctypes.c_void_p
display, errors = ctypes.c_void_p(x11.XOpenDisplay(None)), []
handler = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(lambda *_: errors.append(1) or 0)
x11.XSetErrorHandler(handler)
worker = GpuWorker("native")
worker.call(lambda context: None)
worker.close()
x11.XDestroyWindow(display, ctypes.c_ulong(0x7FFFFFFF))  # there is no such window
x11.XSync(display, 0)
print("errors handled:", len(errors))
"""


def run(program, display, **environment):
    """A Python of its own, on that screen."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "DISPLAY": display} | environment
    command = [sys.executable, "-X", "faulthandler", "-c", program]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)


@LINUX
@pytest.mark.parametrize(
    ("backend", "module", "environment"),
    [
        ("native", "x11", {}),
        ("egl", "egl", {}),
        ("auto", "egl", {}),
        ("auto", "x11", {"__EGL_VENDOR_LIBRARY_FILENAMES": "/none"}),
    ],
    ids=["native", "egl", "automatic", "automatic without EGL"],
)
def test_a_worker_ends_and_begins_again_whatever_made_its_context(x_display, backend, module, environment):
    done = run(LIVES.format(backend=backend, module=module), x_display, **environment)
    assert (done.returncode, done.stdout) == (0, "ended\n"), done.stderr


@LINUX
def test_an_x_error_after_a_native_context_still_goes_to_the_handler_of_the_process(x_display):
    done = run(HANDLER, x_display)
    assert (done.returncode, done.stdout) == (0, "errors handled: 1\n"), done.stderr


class Context:
    """Stands in for a context of one platform; `current` is what the thread has current."""

    def __init__(self, is_egl):
        self.is_egl, self.current, self.before, self.objects, self.log = is_egl, "own", "never written", [], []

    def __enter__(self):
        self.before, self.current = self.current, "own"
        return self

    def __exit__(self, *_):
        self.current = None if self.is_egl else self.before
        assert self.current != "never written"

    def release(self):
        """EGL's leaves a current context as it is, the others' makes none current."""
        if not self.is_egl:
            self.current = None
        self.log.append(self.current)


@pytest.mark.parametrize("is_egl", [True, False], ids=["EGL", "GLX, WGL, CGL"])
def test_no_context_is_current_when_it_is_freed(is_egl):
    context = Context(is_egl)
    context_module.destroy_context(context)
    assert context.log == [None]


def test_egl_is_offered_only_where_there_is_one():
    offered = {platform: machine.backends_on(platform) for platform in ("linux", "win32", "darwin")}
    assert offered == {"linux": ("auto", "egl", "native"), "win32": ("auto", "native"), "darwin": ("auto", "native")}


@LINUX
@pytest.mark.parametrize(("backend", "advice"), [("native", "X server"), ("auto", "apt install"), ("egl", "apt install")])
def test_without_a_context_the_advice_is_about_what_was_asked_for(monkeypatch, backend, advice):
    def fail(**_):
        raise Exception("cannot open display")  # as glcontext does

    monkeypatch.setattr(context_module.moderngl, "create_context", fail)
    with pytest.raises(GpuError, match=advice):
        context_module.create_context(backend)
