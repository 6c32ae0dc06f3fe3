"""The extension's preferences reach the renderer at once, and are put back with it."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.blender.conftest import MODULE


@pytest.fixture
def preferences(blend):
    """The extension's preferences, put back to their defaults at the end."""
    preferences = blend.context.preferences.addons[MODULE].preferences
    yield preferences
    for name in ("backend", "is_separate", "threads", "memory_mib"):
        preferences.property_unset(name)
        setattr(preferences, name, getattr(preferences, name))  # its update is called


def combined(room):
    return room("api").preview(passes=("combined",)).combined


def test_every_preference_reaches_the_machine(preferences, room):
    machine = room("pipeline.gl.machine")
    assert machine.chosen() == machine.Machine()
    preferences.backend, preferences.is_separate, preferences.threads, preferences.memory_mib = "egl", True, 3, 512
    assert machine.chosen() == machine.Machine("egl", 3, 512, True)


def test_a_process_of_its_own_makes_the_same_picture_and_ends_with_the_choice(preferences, cube_scene, room):
    here = combined(room)
    room("pipeline.gl.context").shutdown()
    preferences.is_separate = True
    there = combined(room)
    assert np.array_equal(here, there)
    assert room("pipeline.gl.context")._worker is None  # no OpenGL in Blender's own process
    process = room("pipeline.remote.renderer").shared_remote()._child.process
    assert process.poll() is None
    preferences.is_separate = False
    assert process.poll() == 0


def test_the_memory_limit_is_said_to_the_user(preferences, cube_scene, blend):
    preferences.memory_mib = 1
    cube_scene.cad_shadow.map_size = 2048
    with pytest.raises(RuntimeError, match="192 MiB of graphics memory, more than the 1 MiB allowed: lower Map Size"):
        blend.ops.cad_shadow.preview()


def test_a_software_driver_uses_so_many_threads(preferences, cube_scene, room):
    preferences.is_separate = True
    counts = []
    for wanted in (1, 3):
        preferences.threads = wanted
        renderer = room("api").preview().outcome.frame.gl["renderer"]
        threads = Path(f"/proc/{room('pipeline.remote.renderer').shared_remote()._child.process.pid}/task")
        if "llvmpipe" not in renderer or not threads.is_dir():
            pytest.skip(f"counts the threads of Mesa's llvmpipe; this is {renderer}")
        counts.append(sum((task / "comm").read_text().startswith("llvmpipe") for task in threads.iterdir()))
    assert counts == [1, 3]


def test_only_ways_to_opengl_that_there_are_can_be_chosen_and_another_machines_choice_is_automatic(preferences, room):
    machine, module = room("pipeline.gl.machine"), room("blender.preferences")
    offered = {item.identifier: item.value for item in preferences.bl_rna.properties["backend"].enum_items}
    assert tuple(offered) == machine.backends_on(sys.platform)
    numbers = {platform: {item[0]: item[4] for item in module.backend_items(platform)} for platform in ("linux", "win32", "darwin")}
    assert numbers["win32"] == numbers["darwin"] == {"auto": 0, "native": 2} and numbers["linux"] == {"auto": 0, "egl": 1, "native": 2}
    module.apply(SimpleNamespace(backend="", threads=0, memory_mib=0, is_separate=False, import_seconds=0, import_memory_mib=0))
    assert machine.chosen().backend == "auto"


@pytest.fixture
def no_opengl_here(room, monkeypatch):
    """This process may make no OpenGL context of its own."""
    room("pipeline.gl.context").shutdown()

    def refuse(_backend):
        raise AssertionError("a context in Blender's own process")

    monkeypatch.setattr(room("pipeline.gl.context"), "create_context", refuse)


WAYS = {
    "baked": lambda room, blend, folder: room("api").impostors(size=(64, 48))[0].color,
    "exported": lambda room, blend, folder: blend.ops.cad_shadow.impostor_export(directory=str(folder), to="FILES"),
    "reported": lambda room, blend, folder: blend.ops.cad_shadow.impostor_report(),
    "timed": lambda room, blend, folder: room("cli.main").main(
        ["bench", str(folder / "cube.blend"), "--frames", "1", "--quiet", "--size", "64x48", "--report", str(folder / "r.json")]
    ),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_process_of_its_own_does_all_that_opengl_does(preferences, cube_scene, blend, ball, room, tmp_path, no_opengl_here, way):
    blend.ops.cad_shadow.impostor_create()
    blend.ops.wm.save_as_mainfile(filepath=str(tmp_path / "cube.blend"))
    preferences.is_separate = True
    done = WAYS[way](room, blend, tmp_path)
    assert done is not None
    assert room("pipeline.remote.renderer").shared_remote()._child.process.poll() is None
