"""The command line's streams and signals: what cannot be shown or is stopped is said, and costs nothing else."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.blender.user_folder import BOX, SMALL, below, posix
from tests.conftest import ROOT


def run(*arguments, **options):
    command = [sys.executable, "-m", "addon", *arguments]
    return subprocess.run(command, cwd=options.pop("cwd", ROOT), stdin=subprocess.DEVNULL, timeout=120, **options)


THEORY = ("theory", "--near", "1", "--far", "10")


@posix
@pytest.mark.parametrize("form", [(), ("--json",)])
def test_a_standard_output_that_takes_nothing_is_a_failure_of_one_line(form):
    with Path("/dev/full").open("wb") as full:
        done = run(*THEORY, *form, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert done.stderr.decode().splitlines() == ["cad_shadow: standard output cannot be written (No space left on device)."]
    reader, writer = os.pipe()
    os.close(reader)
    done = run(*THEORY, *form, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert done.returncode == 1
    assert done.stderr.decode().splitlines() == ["cad_shadow: standard output cannot be written (Broken pipe)."]


@posix
def test_closed_streams_cost_only_what_they_were_to_show():
    assert run(*THEORY, preexec_fn=lambda: os.close(1), stderr=subprocess.PIPE).returncode == 1
    assert run(*THEORY, preexec_fn=lambda: os.close(2), stdout=subprocess.PIPE).stdout.startswith(b"view")
    assert run(*THEORY, "--quiet", preexec_fn=lambda: os.closerange(0, 3)).returncode == 0


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-8"])
def test_every_text_can_be_shown_in_every_encoding(encoding):
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    for words in (THEORY, ("preview", "--help"), ("theory", "--help")):
        done = run(*words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        assert done.returncode == 0, done.stderr
        assert done.stderr == b""
        assert len(done.stdout.decode(encoding)) > 100
    assert json.loads(run(*THEORY, "--json", env=environment, stdout=subprocess.PIPE).stdout)


def test_a_worker_takes_no_code_from_the_current_folder(room, tmp_path):
    (tmp_path / "tomllib.py").write_text("raise SystemExit('code of the current folder runs')\n")
    command, environment = room("cli.batch.workers").worker_command([*THEORY, "--quiet"])
    assert command.pop() == "--worker"
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")


@posix
@pytest.mark.parametrize(("number", "jobs"), [(signal.SIGINT, 1), (signal.SIGTERM, 1), (signal.SIGTERM, 2)])
def test_a_batch_that_is_stopped_keeps_what_is_done_and_says_what_is_not(box, tmp_path, user_resources, number, jobs):
    for i in range(40):
        (box.parent / f"b{i}.obj").write_text(BOX)
    out, report = tmp_path / "out", tmp_path / "all.json"
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(user_resources), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "addon", "preview", str(box.parent), "-o", str(out), "--report", str(report), "--jobs", str(jobs)]
    process = subprocess.Popen(
        [*command, "--size", "320x240", "--samples", "4", "--map-size", "64"],
        env=environment,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # a shell's background jobs ignore it
    )
    deadline = time.monotonic() + 90.0
    while len(list(out.glob("*_report.json"))) <= jobs and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 1, said
    assert "Traceback" not in said
    assert "stopped;" in said
    reports = json.loads(report.read_text())
    assert len(reports) == 41
    done = [Path(one["input"]).stem for one in reports if not one["errors"]]
    assert 1 <= len(done) < 41
    assert all(one["errors"] == ["Not done: the run was stopped."] for one in reports if one["errors"])
    whole = {f"{name}_{kind}" for name in done for kind in ("combined.png", "report.json")}
    assert whole <= set(below(out))
    assert not [name for name in below(out) if name.startswith(".")]
    assert len(set(below(out)) - whole) <= 2 * jobs, "those that were at hand may have got some of their files, whole ones"


def test_a_render_under_way_is_given_up_when_asked_to_stop(main, room, box, monkeypatch):
    """In this process: the signal comes while Blender renders, where nothing may be raised."""
    stopping, calls = room("studies.stopping"), []

    engine = room("blender.engine").CadShadowEngine
    deliver = engine._outcome

    def outcome(self, *job):
        calls.append(len(calls))
        os.kill(os.getpid(), signal.SIGINT)
        return deliver(self, *job)

    monkeypatch.setattr(engine, "_outcome", outcome)
    assert main(["analyse", str(box), str(box.parent / "gone.obj"), *SMALL]) == 1
    assert calls == [0]
    assert not stopping.is_asked()
