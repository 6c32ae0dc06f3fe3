"""Impostors and geometry a hair apart: the nearer one shows, in the picture and in the capture, with clip control and without."""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from addon.maths import spaces
from addon.maths.relief.frame import capture_frame
from addon.maths.view import Camera
from addon.pipeline.device import device_of
from addon.pipeline.gl.gl_raw import raw_gl
from addon.pipeline.gl.readback import read_texture
from addon.pipeline.impostors.capture import capture
from addon.pipeline.impostors.draw import draw_impostor
from addon.pipeline.passes.gbuffer import GBuffer, draw_gbuffer
from tests import plates, scenes
from tests.maths.relief.rigs import chosen, corners

CASES = {
    "lens": plates.pair(50.0, 0.001, 0.01, 1000.0, half=0.1),
    "parallel": plates.pair(10.0, 0.001, 0.1, 1e5, None, half=0.1),
    "facing": plates.pair(50.0, 0.001, 0.01, 1000.0, half=0.1, towards_eye=(0.0, 0.0, 0.9)),
}


class Rig:
    """A case on the worker: impostors of chosen objects, pictures as objects per pixel."""

    def __init__(self, context, worker, case):
        self.context, self.device, self.case = context, device_of(context, worker), case
        self.draw_list = self.device.store.sync(case.scene)

    def hull(self, rows):
        bounds = self.case.scene.instance_bounds_ws()[rows]
        return corners(bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0))

    @contextmanager
    def captured(self, rows, camera, **choice):
        frame = capture_frame(self.hull(rows), camera, plates.SIZE, chosen(texels_per_pixel=2.0, max_texels=2048, **choice))
        impostor = capture(self.device, self.draw_list, rows, frame)
        yield impostor
        impostor.release()

    def objects(self, camera, rows, impostor, **options):
        """(h, w) what shows: geometry of the other rows, and the impostor."""
        target = GBuffer(self.context, plates.SIZE)
        draw_gbuffer(self.context, self.device.programs, target, self.draw_list, camera, ~rows)
        draw_impostor(self.device, target, impostor, self.hull(rows), camera, **options)
        slots = read_texture(target.ids)[..., 0].astype(int)
        self.device.unbind()
        target.release()
        row = self.draw_list.rows_of_slot[slots - 1]
        return np.where(slots > 0, self.case.scene.instances.object_id[row], -1)


@pytest.fixture(params=[True, False], ids=["clip control", "no clip control"])
def rig(request, worker):
    """Runs a function of a `Rig` of a case on the worker."""
    control = worker.call(lambda context: raw_gl(context).ClipControl)
    if request.param and control is None:
        pytest.skip("this driver has no clip control")
    worker.call(lambda context: setattr(raw_gl(context), "ClipControl", control if request.param else None))
    yield lambda case, job: worker.call(lambda context: job(Rig(context, worker, case)))
    worker.call(lambda context: setattr(raw_gl(context), "ClipControl", control))
    assert worker.call(lambda context: context.error) == "GL_NO_ERROR"


def inner(shown, by=4):
    """Without the rim, where a texel's edge may fall otherwise than the ray."""
    out = shown.copy()
    for axis in (0, 1):
        for step in range(1, by + 1):
            out &= np.roll(shown, step, axis) & np.roll(shown, -step, axis)
    return out


@pytest.mark.parametrize("method", ["inverse", "sprite"])
@pytest.mark.parametrize("captured", [0, 1], ids=["the lower plate", "the upper plate"])
@pytest.mark.parametrize("kind", CASES)
def test_a_plate_drawn_as_an_impostor_and_one_drawn_as_geometry_hide_each_other_rightly(rig, kind, captured, method):
    """1 mm apart at 50 m, clip 0.01–1000, and in a parallel view that ends 100 km away; at the capture's eye and from beside. (The texts'
    forward warp is left out: it moves texels, whose depth is one number each.)"""
    case, rows = CASES[kind], np.arange(2) == captured
    turned = replace(case, camera=case.camera.carried((0.0, 0.0, 0.0), 0.05))
    seen_from = (case, turned) if method != "sprite" else (case,)

    def job(r):
        with r.captured(rows, case.camera) as impostor:
            return [r.objects(seen.camera, rows, impostor, method=method) for seen in seen_from]

    for seen, objects in zip(seen_from, rig(case, job), strict=True):
        clear = inner(np.isfinite(seen.hits).all(axis=0))
        assert clear.sum() > 2000
        assert (objects != seen.nearest)[clear].mean() <= 0.003


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("kind", CASES)
def test_a_capture_holds_the_nearer_of_two_plates(rig, kind, perspective):
    case, rows = CASES[kind], np.ones(2, bool)

    def job(r):
        with r.captured(rows, case.camera, perspective=perspective) as impostor:
            return r.objects(case.camera, rows, impostor)

    clear = inner(np.isfinite(case.hits).all(axis=0))
    assert (rig(case, job) != case.nearest)[clear].mean() <= 0.003


@pytest.mark.parametrize(("near", "far", "shown"), [(0.1, 1e6, True), (21.0, 1e6, False), (0.1, 19.0, False), (19.0, 21.0, True)])
def test_the_cameras_clip_cuts_impostors_too(rig, near, far, shown):
    sheet = scenes.sheet((-2.0, 20.0, -2.0), (2.0, 20.0, -2.0), (2.0, 20.0, 2.0), (-2.0, 20.0, 2.0))
    view = spaces.look_at((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    free, cut = (Camera(view, spaces.perspective(0.2, plates.ASPECT, *clip), *clip) for clip in ((0.1, 1e6), (near, far)))
    case, rows = plates.PlateCase("clip", scenes.scene_of(sheet), free), np.ones(1, bool)

    def job(r):
        with r.captured(rows, free) as impostor:
            return r.objects(cut, rows, impostor)

    assert (rig(case, job) >= 0).any() == shown


@pytest.mark.parametrize("kind", CASES)
def test_an_impostor_that_lies_a_little_behind_its_box_is_drawn_whole(rig, kind):
    """The old texture during a crossfade does, and nothing in the scene lies farther back."""
    case, rows = CASES[kind], np.ones(2, bool)

    def job(r):
        with r.captured(rows, case.camera) as impostor:
            return [r.objects(case.camera, rows, impostor, behind_texels=texels) >= 0 for texels in (0.0, 2.0)]

    whole, behind = rig(case, job)
    assert whole.sum() > 2000 and np.array_equal(whole, behind)
