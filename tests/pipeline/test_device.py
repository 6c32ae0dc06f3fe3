"""The worker and what it owns: life, limits, leaks, and uploads."""

import ctypes
import threading
import time
from concurrent.futures import CancelledError
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from addon.errors import Cancelled, GpuError
from addon.pipeline.device import device_of
from addon.pipeline.gl import context as context_module
from addon.pipeline.gl.context import THREAD_NAME, GpuWorker
from addon.pipeline.gl.gl_raw import live_objects
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer, check_size
from addon.scene.records import Instances, Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes

CAMERA, SUN = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0), scenes.sun(40.0)
SMALL = Settings().replaced(fit={"size": 64})


def all_names(context) -> set[tuple[str, int]]:
    """Every GL object name alive, asked from the driver itself."""
    found = set()
    for kind in ("Texture", "Buffer", "Framebuffer", "Program", "Shader", "VertexArray", "Renderbuffer"):
        is_name = ctypes.CFUNCTYPE(ctypes.c_ubyte, ctypes.c_uint)(context.mglo._context.load_opengl_function(f"glIs{kind}"))
        found |= {(kind, i) for i in range(1, 400) if is_name(i)}
    return found


def test_every_gl_object_is_freed():
    worker = GpuWorker()
    before = worker.call(all_names)
    renderer = Renderer(worker)
    for size in ((32, 24), (48, 32)):
        for partition in ("none", "z-adaptive"):
            chosen = SMALL.replaced(partition={"kind": partition}, shading={"samples": 4})
            run(Job(scenes.railing(), CAMERA, SUN, chosen, size, ("combined", "aliasing", "texel")), on=renderer)
    assert len(worker.call(all_names)) > len(before) + 10

    def release(context):
        context.extra["device"].release()
        context_module._collect(context)
        return all_names(context), live_objects(context)

    left, raw = worker.call(release)
    assert left <= before
    assert raw == 0
    worker.call(lambda context: threading.current_thread().releases.clear())
    worker.close()


def test_a_closed_worker_leaves_no_context_behind():
    """EGL destroys a context only when it is current nowhere: a worker that ended with its own current kept 60 MB a time."""
    worker, left = GpuWorker(), []
    name = worker.call(lambda context: context.mglo._context.load_opengl_function("eglGetCurrentContext"))
    if not name:
        pytest.skip("not an EGL context")
    current = ctypes.CFUNCTYPE(ctypes.c_void_p)(name)
    assert worker.call(lambda context: current())
    release = moderngl.Context.release
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(moderngl.Context, "release", lambda context: (left.append(current()), release(context)))
        worker.close()
    assert left == [None]


def test_close_joins_the_thread_and_a_later_job_starts_afresh():
    worker = GpuWorker()
    assert worker.call(lambda context: threading.current_thread().name) == THREAD_NAME
    worker.close()
    assert not worker.is_running
    assert THREAD_NAME not in {t.name for t in threading.enumerate() if t.is_alive() and not t.daemon}
    assert worker.call(lambda context: 7) == 7
    worker.close()


def test_close_runs_no_queued_job_and_tells_their_callers():
    worker, gate, begun, ran = GpuWorker(), threading.Event(), threading.Event(), []
    first = worker.submit_plain(lambda: (begun.set(), gate.wait(20.0)))
    queued = [worker.submit_plain(lambda i=i: ran.append(i)) for i in range(5)]
    assert begun.wait(20.0)
    closer = threading.Thread(target=worker.close)
    closer.start()
    for future in queued:
        with pytest.raises(CancelledError):
            future.result(20.0)
    assert not first.done()
    gate.set()
    closer.join()
    assert first.done() and not first.cancelled()
    assert ran == []


def test_close_tells_the_running_job_to_stop():
    worker, told, begun = GpuWorker(), threading.Event(), threading.Event()
    job = worker.submit(lambda _context: (begun.set(), told.wait(60.0))[1], told.set)
    assert begun.wait(60.0)
    start = time.monotonic()
    worker.close()
    assert job.result(0.0) is True
    assert time.monotonic() - start < 5.0


def test_a_frame_under_way_is_given_up_when_the_worker_closes():
    worker = GpuWorker()
    future, ticket = Renderer(worker).submit(Job(scenes.railing(), CAMERA, SUN, SMALL.replaced(shading={"samples": 16}), (1600, 1200)))
    while ticket.stage in ("waiting", "upload"):
        time.sleep(0.005)
    worker.close()
    with pytest.raises(Cancelled):
        future.result(0.0)


def test_what_closes_late_releases_its_own_things_and_not_those_of_the_next_life():
    worker, gate, begun, released = GpuWorker(), threading.Event(), threading.Event(), []

    def slow():
        begun.set()
        gate.wait(20.0)
        worker.at_close(lambda: released.append("first"))

    first = worker.submit_plain(slow)
    assert begun.wait(20.0)
    worker.close(timeout_s=0.0)
    worker.submit_plain(lambda: worker.at_close(lambda: released.append("second"))).result(20.0)
    gate.set()
    first.result(20.0)
    deadline = time.monotonic() + 20.0
    while released != ["first"] and time.monotonic() < deadline:
        time.sleep(0.005)
    assert released == ["first"]
    worker.close()
    assert released == ["first", "second"]


def test_a_release_that_fails_keeps_nothing_else_alive(monkeypatch):
    worker, released, raised = GpuWorker(), [], []
    monkeypatch.setattr(threading, "excepthook", lambda arguments: raised.append(arguments.exc_type))
    worker.submit_plain(lambda: worker.at_close(lambda: 1 // 0)).result(20.0)
    worker.submit_plain(lambda: worker.at_close(lambda: released.append("after"))).result(20.0)
    worker.close()
    assert released == ["after"] and raised == [ZeroDivisionError]


def test_a_failed_context_names_the_missing_library(monkeypatch):
    def fail(**_):
        raise Exception("(detail) libEGL.so.1 not loaded")  # as glcontext does

    monkeypatch.setattr(context_module.moderngl, "create_context", fail)
    worker = GpuWorker()
    with pytest.raises(GpuError, match=r"libEGL.so.1 not loaded.*(apt install|driver)"):
        worker.call(lambda context: None)
    worker.close()


def test_cancelling_stops_between_stages(renderer):
    large = Job(scenes.railing(), CAMERA, SUN, SMALL.replaced(shading={"samples": 16}), (640, 480))
    with pytest.raises(Cancelled):
        run(large, cancelled=lambda: True, on=renderer)
    assert run(Job(scenes.railing(), CAMERA, SUN, SMALL, (16, 16)), on=renderer).frame.passes["combined"].shape == (16, 16, 4)


def test_pictures_beyond_the_driver_are_refused_with_its_limit(renderer):
    limit = renderer.worker.call(lambda context: context.info["GL_MAX_TEXTURE_SIZE"])
    with pytest.raises(GpuError, match=str(limit)):
        renderer.worker.call(lambda context: check_size(context, (limit + 1, 16)))


def test_maps_beyond_the_driver_are_refused_with_its_limit(renderer):
    limit = renderer.worker.call(lambda context: context.info["GL_MAX_TEXTURE_SIZE"])
    if limit >= 16384:
        pytest.skip(f"this driver takes every map that can be asked for (up to {limit})")
    with pytest.raises(GpuError, match=str(limit)):
        run(Job(scenes.railing(), CAMERA, SUN, SMALL.replaced(fit={"size": 16384}), (16, 16)), on=renderer)


def uploads(renderer) -> int:
    return renderer.worker.call(lambda context: device_of(context, renderer.worker).store.uploaded_meshes)


def test_unchanged_meshes_are_not_uploaded_again(renderer):
    scene = scenes.railing()
    run(Job(scene, CAMERA, SUN, SMALL, (32, 32)), on=renderer)
    count = uploads(renderer)
    moved = scene.instances.world_from_object.copy()
    moved[:, 2, 3] += 0.5
    again = replace(scene, instances=replace(scene.instances, world_from_object=moved))
    first = run(Job(again, CAMERA, SUN, SMALL, (32, 32)), on=renderer).frame.passes["combined"]
    assert uploads(renderer) == count
    fresh = Renderer(GpuWorker())
    assert np.array_equal(first, run(Job(again, CAMERA, SUN, SMALL, (32, 32)), on=fresh).frame.passes["combined"])
    fresh.worker.close()


@pytest.mark.parametrize("bake", [0, 10**9])
def test_baked_and_instanced_drawing_give_the_same_picture(renderer, monkeypatch, bake):
    scene = scenes.chair()
    eye = np.tile(np.eye(4), (6, 1, 1))
    eye[:, 0, 3] = np.arange(6) - 2.5
    eye[:, 2, 3] = 0.1 * np.arange(6)  # floors in one plane would be told apart by rounding alone
    eye[1, :3, :3] *= -0.7
    many = Scene(
        scene.meshes,
        Instances(np.zeros(6, np.int32), eye, np.arange(6), np.zeros(6), np.tile([0.5, 0.4, 0.3, 1.0], (6, 1))),
        tuple("abcdef"),
        scene.origin_ws,
    )
    reference = run(Job(many, CAMERA, SUN, SMALL, (96, 64), ("combined", "object", "normal")), on=renderer).frame.passes
    monkeypatch.setattr("addon.pipeline.geometry.parts.BAKE_TRIANGLES", bake)
    fresh = Renderer(GpuWorker())
    other = run(Job(many, CAMERA, SUN, SMALL, (96, 64), ("combined", "object", "normal")), on=fresh).frame.passes
    fresh.worker.close()
    assert np.mean(other["object"] != reference["object"]) < 2e-3
    same = other["object"] == reference["object"]
    assert np.mean(np.abs(other["combined"][same] - reference["combined"][same]).max(axis=-1) > 2e-3) < 5e-3
