"""A .blend given to the command line is a stranger's file: opened without its scripts, in a process of its own, within limits."""

import json
import os
import subprocess
import sys
import time

import pytest

from tests.blender.user_folder import SMALL, posix
from tests.conftest import ROOT

LIMITED = """
import sys, time
from addon.scene.reading.limits import Limits, held_to
with held_to(Limits({})):
    {}
print("over")
"""


def limited(limits, work):
    command = [sys.executable, "-c", LIMITED.format(limits, work)]
    return subprocess.run(command, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, timeout=100)


@posix
def test_what_takes_longer_than_its_limit_ends_without_any_python_being_run():
    begin = time.monotonic()
    assert limited("1, 0", "sum(range(10**12))").returncode == -14  # SIGALRM, in a call that never comes back to the interpreter
    assert time.monotonic() - begin < 60.0


@pytest.mark.skipif(sys.platform != "linux", reason="macOS takes a limit and does not heed it")
def test_memory_beyond_the_limit_is_refused_and_the_limit_is_taken_back():
    assert "MemoryError" in limited("0, 64", "bytes(1 << 28)").stderr
    assert limited("0, 64", "bytes(1 << 20)\nbytes(1 << 28)").stdout == "over\n"


@posix
def test_a_blend_is_opened_in_a_process_of_its_own_and_its_scripts_are_not_run(cube_scene, blend, tmp_path, user_resources, box):
    ran = tmp_path / "ran"
    script = blend.data.texts.new("script.py")
    script.write(f"open({str(ran)!r}, 'w').close()")
    script.use_module = True
    path, report = tmp_path / "scene.blend", tmp_path / "all.json"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    (tmp_path / "cut.blend").write_bytes(path.read_bytes()[:5000])
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(user_resources), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "addon", "analyse", str(box), str(tmp_path / "cut.blend"), str(path), "--report", str(report)]
    done = subprocess.run([*command, "-o", str(tmp_path), *SMALL], env=environment, capture_output=True, text=True, timeout=240)
    first, cut, whole = json.loads(report.read_text())
    assert (done.returncode, first["errors"], whole["errors"]) == (1, [], []), done.stderr
    assert len(cut["errors"]) == 1
    assert "Traceback" not in done.stderr
    assert any("scripts in this .blend" in line for line in whole["warnings"])
    assert not ran.exists()


def test_only_the_doors_open_a_blend_apart(main, room, cube_scene, blend, tmp_path, monkeypatch):
    """A process that dies at a .blend costs that one input."""
    blend.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    inputs, workers = room("cli.inputs"), room("cli.batch.workers")
    asked = []
    dies = (
        [sys.executable, "-c", "import os; os.kill(os.getpid(), 9)"]
        if os.name == "posix"
        else [sys.executable, "-c", "raise SystemExit(3)"]
    )
    monkeypatch.setattr(workers, "worker_command", lambda argv: (dies, dict(os.environ)))
    monkeypatch.setattr(inputs, "answers", lambda items, *rest: asked.append(items) or workers.answers(items, *rest))
    report = tmp_path / "r.json"
    arguments = ["analyse", str(tmp_path / "a.blend"), "-o", str(tmp_path), "--report", str(report), *SMALL]
    assert main(arguments, is_apart=True) == 1
    assert "ended unexpectedly" in json.loads(report.read_text())["errors"][0]
    assert len(asked) == 1
    assert main(arguments) == 0
    assert len(asked) == 1
