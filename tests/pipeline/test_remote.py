"""The renderer in a process of its own gives what the one in this process gives, and outlives a process that dies."""

import errno
import io
import os
import pickle
import signal
import subprocess
import time
from dataclasses import replace

import numpy as np
import pytest

from addon.cli.batch.workers import worker_command
from addon.errors import Cancelled, GpuError, SceneError
from addon.pipeline.bake import bake_all
from addon.pipeline.bare_passes import release_kept, timed
from addon.pipeline.gl import machine
from addon.pipeline.gl.machine import Machine
from addon.pipeline.job import Job
from addon.pipeline.remote.child import Server
from addon.pipeline.remote.renderer import RemoteRenderer
from addon.pipeline.remote.words import receive, send
from addon.pipeline.render_passes import DATA_PASSES
from addon.scene.child_python import started
from addon.scene.records import Instances, Scene
from addon.settings.groups import Settings
from addon.studies.impostors.asked import choice_for, whole
from tests import scenes

CAMERA, SUN = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0), scenes.sun(40.0)
SMALL = Settings().replaced(fit={"size": 64})
SIZE = (48, 32)
WAIT_S = 60.0


@pytest.fixture(scope="module")
def remote():
    remote = RemoteRenderer()
    yield remote
    remote.close()


def asked(scene, size=SIZE, settings=SMALL):
    return Job(scene, CAMERA, SUN, settings, size, ("combined", *DATA_PASSES))


def test_frames_are_the_same_to_the_last_bit_for_one_scene_after_the_other(renderer, remote):
    for scene in (scenes.railing(), scenes.chair(), scenes.railing()):
        there, ticket = remote.submit(asked(scene))
        here, _ = renderer.submit(asked(scene))
        frame, expected = there.result(WAIT_S), here.result(WAIT_S)
        assert ticket.stage == "readback"
        assert set(frame.passes) == set(expected.passes)
        for name, image in expected.passes.items():
            assert np.array_equal(frame.passes[name], image, equal_nan=True), name
        assert frame.measured == expected.measured
        there_maps, here_maps = (np.array([p.clip_from_world for p in f.plan.projections]) for f in (frame, expected))
        assert np.array_equal(there_maps, here_maps)


def test_a_mesh_goes_over_once(remote):
    scene = scenes.railing()
    remote.submit(asked(scene))[0].result(WAIT_S)
    child, sent = remote._child, []
    post = child.process.stdin.write
    child.process.stdin.write = lambda data: (sent.append(len(data)), post(data))[1]
    moved = Scene(scene.meshes, scene.instances, scene.object_names, scene.origin_ws + 1.0)
    remote.submit(asked(moved))[0].result(WAIT_S)
    del child.process.stdin.write
    assert 0 < sum(sent) < 0.5 * sum(mesh.positions.nbytes + mesh.normals.nbytes + mesh.triangles.nbytes for mesh in scene.meshes) + 20_000


def test_users_errors_come_through_and_the_process_goes_on(remote):
    nothing = Instances(*(np.empty((0, *shape)) for shape in ((), (4, 4), (), (), (4,))))
    with pytest.raises(SceneError, match="nothing to draw"):
        remote.submit(asked(Scene((), nothing, (), np.zeros(3))))[0].result(WAIT_S)
    process = remote._child.process
    remote.submit(asked(scenes.railing()))[0].result(WAIT_S)
    assert remote._child.process is process


def test_impostors_are_baked_there_as_here(renderer, remote):
    scene = scenes.chair()
    choice = choice_for(whole(scene, "chair"), SMALL.impostor)
    there, here = (one.submit(asked(scene), bake_all, choice)[0].result(WAIT_S) for one in (remote, renderer))
    for name in ("color", "depth_m", "back_m", "mask", "normal", "object_id"):
        assert np.array_equal(getattr(there[0], name), getattr(here[0], name)), name
    nothing = replace(choice, groups=(replace(choice.groups[0], object_ids=()),))
    (error,) = remote.submit(asked(scene), bake_all, nothing)[0].result(WAIT_S)
    assert isinstance(error, SceneError)


def test_the_bench_times_what_is_drawn_there(remote):
    ours, bare = remote.submit(asked(scenes.railing()), timed)[0].result(WAIT_S)
    assert min(*ours, *bare) > 0.0
    assert remote.submit(asked(scenes.railing()), release_kept)[0].result(WAIT_S) is None


def test_a_frame_under_way_can_be_given_up(remote):
    large = asked(scenes.railing(), (1600, 1200), SMALL.replaced(shading={"samples": 16}))
    future, ticket = remote.submit(large)
    while ticket.stage == "waiting":
        time.sleep(0.005)
    ticket.is_cancelled = True
    with pytest.raises(Cancelled):
        future.result(WAIT_S)


def test_a_process_that_dies_costs_its_frame_and_is_replaced(remote):
    remote.submit(asked(scenes.railing()))[0].result(WAIT_S)
    child = remote._child
    future, ticket = remote.submit(asked(scenes.railing(), (1600, 1200), SMALL.replaced(shading={"samples": 16})))
    while ticket.stage == "waiting":
        time.sleep(0.005)
    child.process.kill()
    with pytest.raises(GpuError, match="ended unexpectedly"):
        future.result(WAIT_S)
    assert remote.submit(asked(scenes.railing()))[0].result(WAIT_S).passes["combined"].shape == (32, 48, 4)
    assert remote._child is not child


def test_a_frame_asked_of_a_process_that_is_dead_already_is_made_by_the_next(remote):
    remote.submit(asked(scenes.railing()))[0].result(WAIT_S)
    child = remote._child
    child.process.send_signal(signal.SIGSTOP)  # what is asked for now is not begun
    futures = [remote.submit(asked(scene))[0] for scene in (scenes.railing(), scenes.chair())]
    child.process.kill()
    for future in futures:
        assert future.result(WAIT_S).passes["combined"].shape == (32, 48, 4)
    assert remote._child is not child


class Evil:
    """What a message must not be: a call."""

    def __init__(self, call, *arguments):
        self.call = call, arguments

    def __reduce__(self):
        return self.call


@pytest.mark.parametrize("call", [(os.mkdir, "made"), (print, "said"), (started, "pipeline.remote.child", (), ()), (replace, 1)])
@pytest.mark.parametrize("takes_tasks", [False, True])
def test_a_message_calls_nothing(call, takes_tasks):
    stream = io.BytesIO()
    send(stream, ("done", Evil(*call)))
    stream.seek(0)
    with pytest.raises(pickle.UnpicklingError, match="is not for messages"):
        receive(stream, "addon", takes_tasks)


def test_tasks_are_taken_only_where_they_are_done():
    stream = io.BytesIO()
    send(stream, ("render", bake_all))
    stream.seek(0)
    assert receive(stream, "addon", takes_tasks=True) == ("render", bake_all)
    stream.seek(0)
    with pytest.raises(pickle.UnpicklingError):
        receive(stream, "addon")


class Deaf(io.BytesIO):
    """A pipe that nobody reads, as Windows has it: no BrokenPipeError, but errno 22."""

    def write(self, _data):
        raise OSError(errno.EINVAL, "Invalid argument")


def test_a_server_that_nobody_listens_to_does_not_fail():
    Server(Deaf())._report(0, "progress", (0.5, "shade"))


def test_close_ends_the_process_and_its_threads(remote):
    remote.submit(asked(scenes.railing()))[0].result(WAIT_S)
    child = remote._child
    remote.close()
    assert child.process.returncode == 0
    assert not any(thread.is_alive() for thread in child._threads)


STRANGERS = ("moderngl.py", "numpy.py", "queue.py", "addon/__init__.py")


@pytest.fixture
def strangers(tmp_path, monkeypatch):
    """A current folder with Python files of others, bearing names of what is imported; gives the file that they would leave."""
    trace = tmp_path / "ran"
    for name in STRANGERS:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"open({str(trace)!r}, 'a').write(__name__)\nraise SystemExit(9)\n")
    monkeypatch.chdir(tmp_path)
    return trace


def test_no_code_of_the_current_folder_runs(strangers):
    remote = RemoteRenderer()
    try:
        remote.submit(asked(scenes.railing()))[0].result(WAIT_S)
    finally:
        remote.close()
    assert not strangers.exists()


def test_no_code_of_the_current_folder_runs_in_a_worker_of_a_batch(strangers):
    command, environment = worker_command(["preview", "--help"])
    assert subprocess.run(command, env=environment, capture_output=True, timeout=60).returncode == 0
    assert not strangers.exists()


@pytest.fixture
def limited():
    """Puts the machine back."""
    before = machine.chosen()
    yield lambda mib: machine.choose(Machine(memory_mib=mib))
    machine.choose(before)


def test_a_picture_beyond_the_memory_limit_is_refused_with_what_to_do(renderer, limited):
    limited(8)
    with pytest.raises(GpuError, match="choose a smaller size"):
        renderer.submit(asked(scenes.railing(), (1024, 768)))[0].result(WAIT_S)
    with pytest.raises(GpuError, match="lower Map Size"):
        renderer.submit(asked(scenes.railing(), settings=Settings().replaced(fit={"size": 2048})))[0].result(WAIT_S)
    assert renderer.submit(asked(scenes.railing()))[0].result(WAIT_S)
    limited(0)
    assert renderer.submit(asked(scenes.railing(), settings=Settings().replaced(fit={"size": 2048})))[0].result(WAIT_S)
