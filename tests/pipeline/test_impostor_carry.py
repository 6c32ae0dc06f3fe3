"""Impostors that are approached: renewed at a higher resolution, with what the predictors keep carried over from the capture before."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.relief.error import predict_one
from addon.maths.relief.frame import capture_frame
from addon.maths.relief.settings import ImpostorSettings
from addon.pipeline.device import device_of
from addon.pipeline.gl.readback import read_texture
from addon.pipeline.impostors.capture import capture
from addon.pipeline.impostors.life import CARRIED, library_of
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes
from tests.pipeline.test_impostor_draw import PARTS, SIZE, orbit

SCENE = scenes.scene_of(*PARTS)
ALL = ImpostorChoice((ImpostorGroup("parts", (0, 1, 2), "Parts"),), ImpostorSettings(break_even=False))
CHEAP = Settings().replaced(fit={"kind": "scene", "size": 64}, partition={"kind": "none"})
NEARER = [orbit(0.3, distance) for distance in 16.0 * 0.94 ** np.arange(32.0)]
ONE_TEXEL = replace(ALL, settings=replace(ALL.settings, texels_per_pixel=1.0))


@pytest.fixture
def approach(renderer):
    """The reports of a film along cameras; nothing is remembered before or after."""

    def empty():
        renderer.worker.call(lambda context: library_of(device_of(context, renderer.worker)).release())

    def film(cameras, choice=ALL):
        empty()
        return [
            run(Job(SCENE, c, scenes.sun(50.0), CHEAP, SIZE, ("combined",), measure=False, impostors=choice), on=renderer).frame
            for c in cameras
        ]

    yield film
    empty()


def _hull():
    box = SCENE.bounds_ws()
    return np.array([[box[i][0], box[j][1], box[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def _captures(renderer, cameras, known_from=None):
    """Captures for cameras, the second with the edges of the first if told so: texels, predictions for each of the views, what was read."""

    def job(context):
        device = device_of(context, renderer.worker)
        draw_list, rows = device.store.sync(SCENE), np.ones(len(SCENE.instances), bool)
        made, known = [], None
        for camera in cameras:
            textures = capture(device, draw_list, rows, capture_frame(_hull(), camera, SIZE), known=known)
            known = textures.edges if known_from == "last" else None
            texels = [read_texture(t) if t.dtype != "f2" else t.read(alignment=1) for t in vars(textures.texels).values()]
            made.append((textures.edges, texels))
            textures.release()
        return made

    return renderer.worker.call(job)


def test_most_renewals_of_an_object_that_is_approached_carry_their_edges_over(approach):
    reports = [frame.impostors[0] for frame in approach(NEARER, ONE_TEXEL)]
    renewed = [r for r in reports if r.stage == "regenerated"]
    carried = [r.edges.gathered is not None for r in renewed]
    assert renewed[-1].size[0] > 2.5 * renewed[0].size[0]
    assert not carried[0]
    assert 0.5 < np.mean(carried[1:]) < 1.0
    assert [CARRIED in r.reason for r in renewed] == carried
    for report in renewed:
        first = report.edges.gathered or report.edges
        assert report.size[0] <= 2.6 * first.frame.width, "what was gathered is never stretched beyond 2.5 times its resolution"


def test_an_object_seen_from_all_round_is_gathered_anew_each_time(approach):
    reports = [frame.impostors[0] for frame in approach([orbit(angle) for angle in np.arange(0.0, 1.0, 0.1)])]
    assert sum(r.stage == "regenerated" for r in reports) > 1
    assert all(r.edges.gathered is None for r in reports)


@pytest.mark.parametrize("changed", ["edges", "back_layer"])
def test_what_was_gathered_otherwise_is_not_carried_over(approach, renderer, changed):
    """The choice changes between two frames; the captures after it are made as it says."""
    one_layer = replace(ALL.settings, back_layer=False)
    other = replace(ALL, settings=one_layer) if changed == "back_layer" else replace(ALL, edges=replace(ALL.edges, bins=4))
    approach(NEARER[:1])
    for camera in NEARER[1:]:
        frame = run(Job(SCENE, camera, scenes.sun(50.0), CHEAP, SIZE, ("combined",), measure=False, impostors=other), on=renderer).frame
        if frame.impostors[0].stage == "regenerated":
            break
    assert frame.impostors[0].edges.gathered is None
    assert (frame.impostors[0].edges.choice, frame.impostors[0].edges.has_back) == (other.edges, other.settings.back_layer)


def test_a_capture_with_known_edges_has_the_texels_of_any_other_and_about_its_predictions(renderer):
    cameras = [orbit(0.3, 8.0), orbit(0.3, 6.0)]
    (_, _), (fresh, texels) = _captures(renderer, cameras)
    (first, _), (carried, same) = _captures(renderer, cameras, "last")
    assert carried.gathered is first
    assert carried.texels == fresh.texels
    assert carried.contour == pytest.approx(fresh.contour, rel=0.25)
    for one, other in zip(texels, same, strict=True):
        np.testing.assert_array_equal(one, other)
    for angle in (-0.2, 0.1, 0.25):
        eye = orbit(0.3 + angle, 6.0)
        want, have = (predict_one(edges, eye, SIZE)["edge_fast_px"] for edges in (fresh, carried))
        assert have == pytest.approx(want, rel=0.35)


def test_a_capture_leaves_nothing_of_itself_in_the_next(renderer):
    """The samples' targets are kept: large, then small, then without the back layer gives what each gives alone."""
    sizes = [(240, 180), (80, 60), (160, 240)]

    def job(context):
        device = device_of(context, renderer.worker)
        draw_list, rows = device.store.sync(SCENE), np.ones(len(SCENE.instances), bool)

        def texels(size, with_back):
            textures = capture(device, draw_list, rows, capture_frame(_hull(), orbit(0.4, 7.0), size), with_back=with_back)
            found = [t.read(alignment=1) for t in vars(textures.texels).values()], textures.edges.edges
            textures.release()
            return found

        def emptied():
            device.attached("impostor samples", lambda: None).release()

        together = [texels(size, with_back) for size in sizes for with_back in (True, False)]
        alone = [(emptied(), texels(size, with_back))[1] for size in sizes for with_back in (True, False)]
        return together, alone

    for (one, edges), (other, same) in zip(*renderer.worker.call(job), strict=True):
        assert one == other
        np.testing.assert_array_equal(edges, same)
