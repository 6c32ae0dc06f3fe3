"""CAD files read in a process of its own: the same model comes back, and what goes wrong there is one line here."""

import io
import os
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import CadFileError, Cancelled
from addon.scene import cad
from addon.scene.cad_model import CadMaterial, CadMesh, CadModel, CadPart
from addon.scene.child_python import EXTENSION
from addon.scene.reading import limits, process, wire
from addon.scene.reading.apart import Reading, read
from addon.scene.reading.limits import TOO_MUCH, Limits, memory_bytes
from addon.scene.reading.process import shutdown
from addon.scene.user_files import is_input, run_of_inputs

posix = pytest.mark.skipif(os.name != "posix", reason="stops a process by a signal")
OFF = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"


@pytest.fixture(autouse=True)
def _no_process_is_left():
    yield
    shutdown()


@pytest.fixture
def body(tmp_path):
    """A tetrahedron's path."""
    path = tmp_path / "body.off"
    path.write_text(OFF)
    return path


def same(one, other):
    """Whether two records hold the same."""
    if is_dataclass(one):
        return type(one) is type(other) and all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


def sent(message):
    """A message, sent and received."""
    stream = io.BytesIO()
    wire.send(stream, message)
    stream.seek(0)
    return wire.receive(stream)


names = st.text(st.characters(), max_size=8)
numbers = st.floats(-1e6, 1e6, width=32)


@st.composite
def models(draw):
    """Any model: names of any letters, empty meshes, groups in groups, with and without normals and slots."""
    colors = st.tuples(*[st.floats(0, 1)] * 4)
    materials = draw(st.lists(st.builds(CadMaterial, names, colors), max_size=3))
    meshes = []
    for _ in range(draw(st.integers(0, 3))):
        count = draw(st.integers(0, 4))
        positions = np.array(draw(st.lists(st.tuples(numbers, numbers, numbers), min_size=count, max_size=count)), float).reshape(-1, 3)
        triangles = np.array(draw(st.lists(st.integers(0, max(count - 1, 0)), min_size=count, max_size=count)), int)[:, None].repeat(3, 1)
        normals = positions if draw(st.booleans()) else None
        slots = np.zeros(count, int) if draw(st.booleans()) else None
        meshes.append(CadMesh(draw(names), positions, triangles, normals, tuple(range(len(materials))), slots))
    parts = [
        CadPart(draw(names), draw(st.integers(-1, i - 1)), draw(st.integers(-1, len(meshes) - 1)), np.eye(4) * draw(numbers))
        for i in range(draw(st.integers(0, 4)))
    ]
    warnings = tuple(draw(st.lists(names, max_size=2)))
    return CadModel(draw(names), tuple(meshes), tuple(parts), tuple(materials), "mm", draw(numbers), "Y", warnings)


@given(models())
def test_a_model_arrives_as_it_was_sent(model):
    assert same(model, sent({"model": model})["model"])


@given(st.binary(max_size=200))
def test_bytes_that_are_no_message_are_refused_and_name_no_code(data):
    with pytest.raises((EOFError, ValueError, KeyError, TypeError)):
        wire.receive(io.BytesIO(len(data).to_bytes(8, "little") + data))


def test_what_is_no_data_is_not_sent():
    with pytest.raises(TypeError, match="cannot be sent"):
        sent(io.BytesIO())
    with pytest.raises(ValueError, match="an array of"):
        sent(np.array([object()]))


def test_a_file_read_apart_is_the_one_read_here_and_counts_as_an_input(body):
    with run_of_inputs():
        model = read(body, units="cm", up="Y")
        assert is_input(body)
    assert same(model, cad.read(body, "cm", "Y"))


def test_a_mistake_in_a_file_is_the_same_line_as_here(tmp_path):
    path = tmp_path / "bad.off"
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n")
    with pytest.raises(CadFileError) as here:
        cad.read(path)
    with pytest.raises(CadFileError) as apart:
        read(path)
    assert str(here.value) == str(apart.value)


def test_one_process_reads_file_after_file(body):
    first, second = Reading(body), None
    first.result(60.0)
    second = Reading(body)
    second.result(60.0)
    assert second._process is first._process and second._process.is_alive


def test_a_process_that_was_prepared_is_the_one_that_reads(body):
    shutdown()
    process.prepare(Limits(60))
    process.prepare(Limits(60))
    (prepared,) = process._kept
    assert Reading(body, limits=Limits(60)).result(60).triangle_count > 0
    assert process._kept == [prepared]
    shutdown()


@posix
def test_a_process_that_crashes_costs_one_line_and_the_next_file_is_read(body):
    reading = Reading(body)
    reading._process._process.send_signal(signal.SIGSEGV)
    with pytest.raises(CadFileError, match=r"body.off cannot be read: .*SIGSEGV.*Export it again"):
        reading.result(60.0)
    assert read(body).triangle_count == 4


@posix
def test_a_process_that_hangs_is_ended_after_its_time(body):
    reading = Reading(body, limits=Limits(seconds=1))
    reading._process._process.send_signal(signal.SIGSTOP)
    with pytest.raises(CadFileError, match=r"body.off was not read within 1 s: raise the limit"):
        reading.result(60.0)
    assert not reading._process.is_alive


@posix
def test_a_reading_given_up_ends_its_process(body):
    reading = Reading(body)
    reading._process._process.send_signal(signal.SIGSTOP)
    assert not reading.done() and "Reading body.off" in reading.progress[1]
    reading.cancel()
    with pytest.raises(Cancelled):
        reading.result(60.0)
    assert not reading._process.is_alive


@posix
def test_who_waits_may_stop(body):
    def check():
        raise KeyboardInterrupt

    first = Reading(body)
    first.result(60.0)
    first._process._process.send_signal(signal.SIGSTOP)
    with pytest.raises(KeyboardInterrupt):
        read(body, check=check)
    assert first._process._process.wait(10.0) == -signal.SIGKILL


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the limit is the kernel's")
def test_a_file_beyond_the_memory_allowed_is_refused_with_the_limit(tmp_path):
    path = tmp_path / "large.stl"
    count = 60_000_000
    path.write_bytes(b"\0" * 80 + count.to_bytes(4, "little"))
    os.truncate(path, 84 + 50 * count)  # a sparse file: 3 GB
    with pytest.raises(CadFileError, match=r"large.stl needs more than the 1,500 MiB of memory that reading may take"):
        Reading(path, limits=Limits(memory_mib=1500)).result(120.0)


@posix
def test_a_process_that_looks_after_itself_ends_with_its_own_exit_code():
    code = "from addon.scene.reading.limits import watch; import time; watch(1); time.sleep(30)"
    assert subprocess.run([sys.executable, "-c", code], cwd=EXTENSION).returncode == TOO_MUCH


def test_limits_are_checked_and_the_computer_s_memory_is_the_last():
    with pytest.raises(ValueError, match="not a limit"):
        Limits(seconds=-1)
    assert memory_bytes(Limits(memory_mib=3)) == 3 << 20
    if os.name == "posix":
        assert 0 < memory_bytes(Limits()) < os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def test_nothing_is_left_in_the_folder_for_temporary_files(body, tmp_path, monkeypatch):
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    read(body)
    reading = Reading(body)
    reading.cancel()
    with suppress(Cancelled):
        reading.result(60.0)
    shutdown()
    assert not list(scratch.iterdir())


def test_without_proc_work_is_held_to_its_time_alone(monkeypatch, tmp_path):
    resource = pytest.importorskip("resource")
    monkeypatch.setattr(limits, "STATM", tmp_path / "statm")
    before = resource.getrlimit(resource.RLIMIT_AS)
    with limits.held_to(Limits(seconds=60, memory_mib=1000)):
        assert resource.getrlimit(resource.RLIMIT_AS) == before
    assert resource.getrlimit(resource.RLIMIT_AS) == before
