"""What the driver cannot give is refused with a line, and leaves nothing behind; what a shader cannot read is never handed to it."""

from dataclasses import replace

import moderngl
import numpy as np
import pytest

from addon.errors import GpuError
from addon.pipeline.device import device_of
from addon.pipeline.geometry.ranges import Ranges
from addon.pipeline.gl import allocation, gl_raw
from addon.pipeline.gl.context import GpuWorker
from addon.pipeline.gl.gl_raw import BufferTexture, live_objects
from addon.pipeline.job import Job
from addon.pipeline.passes import nsm, outline, shadow
from addon.pipeline.passes.shadow import MAX_MAPS, ShadowMaps
from addon.pipeline.renderer import Renderer
from addon.settings.groups import Settings, ShadowTestChoice
from addon.studies.run import run
from tests import scenes

CAMERA, SUN = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0), scenes.sun(40.0)
SMALL = Settings().replaced(fit={"size": 64})
TESTS = (ShadowTestChoice(), ShadowTestChoice("id-depth"), ShadowTestChoice("triangle"), ShadowTestChoice("depth", 4))


def refuse_after(monkeypatch, count: int) -> None:
    """From the `count`-th on, no layer of a map can be drawn to: as a driver without memory has it."""
    made, real = [], gl_raw.LayerFramebuffer

    def layer(*arguments):
        if len(made) == count:
            raise GpuError("no more")
        made.append(real(*arguments))
        return made[-1]

    for module in (shadow, outline, nsm):
        monkeypatch.setattr(module, "LayerFramebuffer", layer)


@pytest.mark.parametrize("test", TESTS, ids=str)
@pytest.mark.parametrize("count", [0, 1, 2])
def test_maps_that_fail_half_way_leave_nothing_on_the_gpu(worker, monkeypatch, test, count):
    refuse_after(monkeypatch, count)

    def attempt(context):
        before = live_objects(context)
        with pytest.raises(GpuError, match="no more"):
            ShadowMaps(context, 16, 3, test)
        return live_objects(context) - before

    assert worker.call(attempt) == 0


def test_maps_beyond_the_memory_say_so_and_leave_nothing(worker, software_rasteriser):
    """51 GB of maps, more than the software driver gives to one texture."""

    def attempt(context):
        device, left = device_of(context, worker), []
        for _ in range(2):  # the first time the maps of a picture before go
            with pytest.raises(GpuError, match=r"not enough graphics memory for these shadow maps: lower Map Size or Partitions"):
                device.shadow_maps(context.info["GL_MAX_TEXTURE_SIZE"], MAX_MAPS)
            assert context.error == "GL_NO_ERROR"
            left.append(live_objects(context))
        return left[1] - left[0]

    assert worker.call(attempt) == 0


def test_a_picture_beyond_the_memory_says_so_and_the_next_one_is_drawn(renderer, software_rasteriser):
    def attempt(context):
        side = context.info["GL_MAX_TEXTURE_SIZE"]
        with pytest.raises(GpuError, match="not enough graphics memory for a picture of this size: choose a smaller one"):
            device_of(context, renderer.worker).shade_target((side, side), True)

    renderer.worker.call(attempt)
    assert run(Job(scenes.railing(), CAMERA, SUN, SMALL, (16, 16)), on=renderer).frame.passes["combined"].shape == (16, 16, 4)


def test_meshes_beyond_the_memory_leave_empty_pools_and_the_next_scene_is_drawn_right(monkeypatch):
    """The driver refuses the third buffer that grows: the pools then have different lengths and must not be used."""
    fresh = Renderer(GpuWorker())
    expected = run(Job(scenes.railing(), CAMERA, SUN, SMALL, (48, 32)), on=fresh).frame.passes["combined"]
    real, asked = moderngl.Context.buffer, []

    def buffer(context, data=None, *, reserve=0, dynamic=False):
        asked.append(reserve)
        if len([n for n in asked if n >= 1 << 19]) == 3:
            return real(context, reserve=1 << 40)
        return real(context, data, reserve=reserve, dynamic=dynamic)

    large = scenes.railing()
    mesh = large.meshes[0]
    copies = 1 + 100_000 // len(mesh.positions)
    big = replace(mesh, positions=np.tile(mesh.positions, (copies, 1)), normals=np.tile(mesh.normals, (copies, 1)), key="big")
    with monkeypatch.context() as patch:
        patch.setattr(moderngl.Context, "buffer", buffer)
        with pytest.raises(GpuError, match="not enough graphics memory for the meshes of this scene: hide or simplify"):
            run(Job(replace(large, meshes=(big, *large.meshes[1:])), CAMERA, SUN, SMALL, (48, 32)), on=fresh)
    again = run(Job(scenes.railing(), CAMERA, SUN, SMALL, (48, 32)), on=fresh).frame.passes["combined"]
    fresh.worker.close()
    assert np.array_equal(again, expected)


def test_a_buffer_longer_than_shaders_can_read_is_refused(worker, monkeypatch):
    def attempt(context):
        buffer = context.buffer(reserve=4 * 1000)
        monkeypatch.setattr(allocation, "buffer_texture_limit", lambda _context: 999)
        with pytest.raises(GpuError, match="1,000 entries.*reads 999.*hide or simplify"):
            BufferTexture(context, buffer, "r32f")
        for texel_format in ("rgba32f", "rgb32ui"):
            BufferTexture(context, buffer, texel_format).release()
        buffer.release()

    before = worker.call(live_objects)
    worker.call(attempt)
    assert worker.call(live_objects) == before


def test_pools_grow_beyond_what_shaders_read_only_when_they_must():
    pool = Ranges(64, 100)
    assert pool.allocate(60) == 0
    pool.grow(20)
    assert pool.capacity == 100
    assert pool.allocate(40) == 60
    pool.grow(30)
    assert pool.capacity == 130, "the caller is told by what it then makes of it"
    assert Ranges(64, 10).capacity == 10


def test_an_error_of_before_is_not_blamed_on_what_is_made_now(worker):
    def attempt(context):
        wrong = (0x8C1A, 0, 0x8CAC, -1, 1, 1, 0, 0x1902, 0x1406, None)
        with pytest.raises(GpuError, match=r"refused it \(GL_INVALID_VALUE\): mend it"), allocation.allocating(context, "it", "mend it"):
            gl_raw.raw_gl(context).TexImage3D(*wrong)
        gl_raw.raw_gl(context).TexImage3D(*wrong)
        with allocation.allocating(context, "it", "mend it"):
            context.buffer(reserve=16).release()
        return context.error

    assert worker.call(attempt) == "GL_NO_ERROR"
