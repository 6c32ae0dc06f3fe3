"""The worker and what it owns: life, limits, leaks, and uploads."""

import ctypes
import threading
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from addon.errors import Cancelled, GpuError
from addon.pipeline import context as context_module
from addon.pipeline.context import THREAD_NAME, GpuWorker
from addon.pipeline.device import device_of
from addon.pipeline.gl_raw import live_objects
from addon.pipeline.renderer import Renderer
from addon.pipeline.scene import Instances, Scene
from addon.pipeline.settings import Settings
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
            renderer.render(scenes.railing(), CAMERA, SUN, chosen, size, ("combined", "aliasing", "texel"))
    assert len(worker.call(all_names)) > len(before) + 10

    def release(context):
        context.extra["device"].release()
        context_module._collect(context)
        return all_names(context), live_objects(context)

    left, raw = worker.call(release)
    assert left <= before
    assert raw == 0
    worker._at_close.clear()
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


def test_jobs_queued_behind_close_are_cancelled_not_lost():
    worker = GpuWorker()
    gate = threading.Event()
    first = worker.submit(lambda context: gate.wait(5.0))
    second = worker.submit(lambda context: None)
    closer = threading.Thread(target=worker.close)
    second.cancel()
    closer.start()
    gate.set()
    closer.join()
    assert first.result() is True
    assert second.cancelled()


def test_a_failed_context_names_the_missing_library(monkeypatch):
    def fail(**_):
        raise Exception("(detail) libEGL.so.1 not loaded")  # as glcontext does

    monkeypatch.setattr(context_module.moderngl, "create_context", fail)
    worker = GpuWorker()
    with pytest.raises(GpuError, match=r"libEGL.so.1 not loaded.*(apt install|driver)"):
        worker.call(lambda context: None)
    worker.close()


def test_cancelling_stops_between_stages(renderer):
    with pytest.raises(Cancelled):
        renderer.render(scenes.railing(), CAMERA, SUN, SMALL.replaced(shading={"samples": 16}), (640, 480), cancelled=lambda: True)
    assert renderer.render(scenes.railing(), CAMERA, SUN, SMALL, (16, 16)).passes["combined"].shape == (16, 16, 4)


def test_maps_beyond_the_driver_are_refused_with_its_limit(renderer):
    limit = renderer.worker.call(lambda context: context.info["GL_MAX_TEXTURE_SIZE"])
    if limit >= 16384:
        with pytest.raises(GpuError, match=str(limit)):
            renderer.render(scenes.railing(), CAMERA, SUN, SMALL, (limit + 1, 16))
    else:
        with pytest.raises(GpuError, match=str(limit)):
            renderer.render(scenes.railing(), CAMERA, SUN, SMALL.replaced(fit={"size": 16384}), (16, 16))


def uploads(renderer) -> int:
    return renderer.worker.call(lambda context: device_of(context, renderer.worker).store.uploaded_meshes)


def test_unchanged_meshes_are_not_uploaded_again(renderer):
    scene = scenes.railing()
    renderer.render(scene, CAMERA, SUN, SMALL, (32, 32))
    count = uploads(renderer)
    moved = scene.instances.world_from_object.copy()
    moved[:, 2, 3] += 0.5
    again = replace(scene, instances=replace(scene.instances, world_from_object=moved))
    first = renderer.render(again, CAMERA, SUN, SMALL, (32, 32)).passes["combined"]
    assert uploads(renderer) == count
    fresh = Renderer(GpuWorker())
    assert np.array_equal(first, fresh.render(again, CAMERA, SUN, SMALL, (32, 32)).passes["combined"])
    fresh.worker.close()


@pytest.mark.parametrize("bake", [0, 10**9])
def test_baked_and_instanced_drawing_give_the_same_picture(renderer, monkeypatch, bake):
    scene = scenes.chair()
    eye = np.tile(np.eye(4), (6, 1, 1))
    eye[:, 0, 3] = np.arange(6) - 2.5
    eye[1, :3, :3] *= -0.7
    many = Scene(
        scene.meshes,
        Instances(np.zeros(6, np.int32), eye, np.arange(6), np.zeros(6), np.tile([0.5, 0.4, 0.3, 1.0], (6, 1))),
        tuple("abcdef"),
        scene.origin_ws,
    )
    reference = renderer.render(many, CAMERA, SUN, SMALL, (96, 64), ("combined", "object", "normal")).passes
    monkeypatch.setattr("addon.pipeline.geometry.BAKE_TRIANGLES", bake)
    fresh = Renderer(GpuWorker())
    other = fresh.render(many, CAMERA, SUN, SMALL, (96, 64), ("combined", "object", "normal")).passes
    fresh.worker.close()
    assert np.mean(other["object"] != reference["object"]) < 2e-3
    same = other["object"] == reference["object"]
    assert np.mean(np.abs(other["combined"][same] - reference["combined"][same]).max(axis=-1) > 2e-3) < 5e-3
