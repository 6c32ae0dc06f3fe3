"""Python ends with the extension attached, busy or not, whatever made the OpenGL context: at once, and with its own exit code.

Each claim is tried in a process of its own: what failed was a segmentation fault, or a wait of ten seconds.
"""

import os
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
import trimesh

from addon.blender.registering import is_python_module
from tests.conftest import ROOT

ATTACHED = """
import sys, time, bpy, addon
from addon.pipeline.gl.machine import Machine, choose
choose(Machine("{backend}"))
addon.register()
"""
RENDERED = """
scene = bpy.context.scene
scene.render.engine = "CAD_SHADOW_PREVIEW"
scene.render.resolution_x = scene.render.resolution_y = 64
bpy.ops.render.render()
"""
STATES = {
    "never rendered": "",
    "rendered": RENDERED,
    "detached": RENDERED + "addon.unregister()\n",
    "detached and attached again": RENDERED + "addon.unregister()\naddon.register()\n" + RENDERED,
    "another file": RENDERED + "bpy.ops.wm.read_homefile(use_factory_startup=True)\n" + RENDERED,
    "another choice of OpenGL": RENDERED + "choose(Machine('auto'))\nfrom addon.studies.run import stop_worker\nstop_worker()\n" + RENDERED,
}
BUSY = """
from addon.blender import sources
from addon.blender.cad_import import to_blender
from addon.studies.run import submit
from addon.scene.platform_deck import build
scene = bpy.context.scene
to_blender(build(50_000), scene.collection)
scene.render.resolution_x = scene.render.resolution_y = 2000
scene.cad_shadow.samples, scene.cad_shadow.map_size = "16", 2048
pending = submit(sources.ViewReading().job(bpy.context))
while pending.progress[1] in ("waiting", "upload"):
    time.sleep(0.01)
"""
SAYS_WHEN = "print(time.time(), flush=True)\n"


def left(program, backend="auto", **environment):
    """The finished process, and the seconds that it took to end."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | environment
    command = [sys.executable, "-X", "faulthandler", "-c", ATTACHED.format(backend=backend) + program + SAYS_WHEN]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240)
    now = time.time()
    assert done.returncode == 0, done.stdout + done.stderr
    return done, now - float(done.stdout.split()[-1])


@pytest.mark.parametrize("state", STATES)
def test_python_ends_well_with_the_extension_attached(state):
    left(STATES[state])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="GLX")
@pytest.mark.parametrize("state", STATES)
def test_python_ends_well_with_the_systems_own_opengl(x_display, state):
    left(STATES[state], "native", DISPLAY=x_display)


@pytest.mark.parametrize(
    ("app", "expected"),
    [
        (SimpleNamespace(binary_path="/usr/bin/blender"), False),  # Blender 4.2 and 4.3
        (SimpleNamespace(binary_path="/usr/bin/blender", module=False), False),
        (SimpleNamespace(binary_path="", module=True), True),
    ],
)
def test_a_blender_that_cannot_say_whether_it_is_a_module_is_known_by_its_program(app, expected):
    assert is_python_module(app) is expected


def test_the_exit_code_of_a_script_that_fails_is_its_own():
    program = ATTACHED.format(backend="auto") + RENDERED + "sys.exit(7)\n"
    done = subprocess.run([sys.executable, "-c", program], env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, timeout=240)
    assert done.returncode == 7, done.stderr


@pytest.mark.parametrize("is_separate", [False, True], ids=["in Blender", "in a process of its own"])
def test_a_busy_worker_is_left_within_a_stage(is_separate):
    choice = f"choose(Machine(is_separate={is_separate}))\n"
    _, seconds = left(choice + BUSY)
    assert seconds < 6.0


def test_a_rendering_process_that_does_not_answer_is_left_soon():
    stopped = (
        "choose(Machine(is_separate=True))\n"
        + BUSY
        + (
            "import os, signal\nfrom addon.pipeline.remote.renderer import shared_remote\n"
            "os.kill(shared_remote()._child.process.pid, signal.SIGSTOP)\n"
        )
    )
    _, seconds = left(stopped)
    assert seconds < 6.0


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="GLX")
@pytest.mark.parametrize("is_separate", [False, True], ids=["one process", "worker processes"])
def test_the_command_line_ends_well_where_there_is_an_x_server_but_no_egl(x_display, tmp_path, is_separate):
    for name in ("a.stl", "b.stl"):
        trimesh.creation.box().export(tmp_path / name)
    environment = os.environ | {"PYTHONPATH": str(ROOT), "DISPLAY": x_display, "__EGL_VENDOR_LIBRARY_FILENAMES": "/none"}
    command = [sys.executable, "-m", "addon", "preview", "a.stl", "b.stl", "-o", "out", "--size", "64x48"]
    command += ["--jobs", "2"] if is_separate else []
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(list((tmp_path / "out").glob("*.png"))) == 2
