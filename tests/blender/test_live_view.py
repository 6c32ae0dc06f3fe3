"""The live view, driven with a stand-in for the worker and a clock of the test's own: it ends with the picture of what is there."""

from collections import deque
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests import scenes

COUNTS = range(1, 31)
MESHES = scenes.chair().meshes[:1]


@pytest.fixture
def viewport(room, monkeypatch):
    """The module, with `clock` [seconds] and `asked`, the stand-in of the last picture asked for, which is done when the test says so."""
    viewport, asked, clock = room("blender.viewport"), deque(maxlen=1), [100.0]

    class Making:
        def __init__(self, job):
            self.job, self.is_done, self.is_given_up, self.error = job, False, False, None
            asked.append(self)

        def done(self):
            return self.is_done

        def cancel(self):
            self.is_given_up = True

        def result(self):
            if self.is_given_up:
                raise room("errors").Cancelled("Cancelled.")
            if self.error is not None:
                raise self.error
            picture = np.full((1, 1, 4), len(self.job.scene.instances), np.float32)
            frame = SimpleNamespace(passes={"combined": picture}, plan=None, impostors=(), view_depth=None, warnings=())
            return SimpleNamespace(job=self.job, frame=frame)

    monkeypatch.setattr(viewport, "submit", Making)
    monkeypatch.setattr(viewport.session, "remember", lambda outcome, scene: None)
    monkeypatch.setattr(viewport, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    monkeypatch.setattr(viewport, "_ensure_timer", lambda: None)
    viewport.asked, viewport.clock = asked, clock
    yield viewport
    del viewport.asked, viewport.clock


@pytest.fixture
def live(viewport):
    live = viewport.LiveView()
    yield live
    live.close()


def job_of(room, scene):
    """The job of a live view of that scene."""
    camera, settings = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0), room("settings.groups").Settings()
    return room("pipeline.job").Job(scene, camera, scenes.sun(40.0), settings, (8, 8), measure=False)


def field(room, count):
    """A scene of so many triangles' places, told apart by their number."""
    rows = np.arange(count)
    kinds = room("scene.records")
    instances = kinds.Instances(np.zeros(count), np.tile(np.eye(4), (count, 1, 1)), rows, np.zeros(count), np.zeros((count, 4)))
    scene = kinds.Scene(MESHES, instances, tuple(map(str, rows)), np.zeros(3))
    return replace(scene, origin_ws=np.ones(3))  # as a reader does; the first one's memory is free for the next


def shown(live):
    """How many objects the scene had that is shown; None without a picture."""
    return None if live._image is None else int(live._image[0, 0, 0])


def test_a_scene_is_named_by_what_it_holds_and_not_by_where_it_lies(room):
    addresses, keys = {}, {}
    for count in [*COUNTS] * 20:
        job = job_of(room, field(room, count))
        assert keys.setdefault(count, job.key) == job.key
        addresses.setdefault(id(job.scene), set()).add(count)
        del job
    assert len(set(keys.values())) == len(COUNTS)
    assert max(map(len, addresses.values())) > 1, "no address was used twice: nothing was tried"


@pytest.mark.parametrize("part", ["meshes", "instances", "origin_ws", "lights", "marks"])
def test_every_part_of_a_scene_that_can_be_seen_is_in_its_name(room, part):
    scene, kinds = field(room, 3), room("scene.records")
    other = {
        "meshes": scenes.railing().meshes[:1],
        "instances": replace(scene.instances, base_color=np.ones((3, 4))),
        "origin_ws": np.zeros(3),
        "lights": (scenes.sun(40.0),),
        "marks": (None, None, kinds.Mark("object", 7)),
    }
    assert replace(scene, **{part: other[part]}).fingerprint != scene.fingerprint
    assert replace(scene).fingerprint == scene.fingerprint


def test_quick_edits_end_with_the_picture_of_the_last_one(room, viewport):
    """The first picture is done though it was given up, the second is given up for the third, whose scene may lie where the first's lay."""
    for first, second, last in np.random.default_rng(1).permutation(np.tile(COUNTS, 20)).reshape(-1, 3):
        live = viewport.LiveView()
        scene = field(room, first)
        live._ask(job_of(room, scene))
        viewport.asked[-1].cancel = lambda: None
        for count, waits in ((second, (0.01, 0.3)), (last, (0.05,))):
            scene = field(room, count)
            for seconds in waits:
                viewport.clock[0] += seconds
                live._ask(job_of(room, scene))
                viewport.asked[-1].is_done |= count == second and seconds == 0.01
        for _ in range(4):
            viewport.asked[-1].is_done = True
            viewport.clock[0] += 0.3
            live._ask(job_of(room, scene))
        assert shown(live) == last
        live.close()


def draw(room, live, scene):
    """What Blender's redraw of the viewport does before it draws; `scene` None: the model has been deleted."""
    if scene is None:
        empty = replace(field(room, 0), meshes=())
        live._scene = SimpleNamespace(job=lambda *_: empty.bounds_ws())
    else:
        live._scene = SimpleNamespace(job=lambda *_: job_of(room, scene))
    live._look(SimpleNamespace(area=SimpleNamespace(regions=[]), scene=None), None)


def finish(room, viewport, live, scene):
    """The picture asked for is done, and those that are asked for then, each taken over by the next redraw."""
    while live._pending is not None:
        viewport.asked[-1].is_done = True
        viewport.clock[0] += 0.3
        draw(room, live, scene)


def test_an_emptied_scene_shows_nothing_but_the_reason_and_a_new_model_is_shown(room, viewport, live):
    draw(room, live, field(room, 3))
    finish(room, viewport, live, field(room, 3))
    assert shown(live) == 3
    draw(room, live, None)
    assert shown(live) is None and "nothing to draw" in live.message
    draw(room, live, field(room, 5))
    finish(room, viewport, live, field(room, 5))
    assert shown(live) == 5 and live.message == ""


def test_of_an_empty_scene_nothing_fails_but_for_the_word_that_it_is_empty(room):
    empty, based_near = replace(field(room, 0), meshes=()), room("scene.local_origin").based_near
    assert empty.instance_bounds_ws().shape == (0, 2, 3)
    with pytest.raises(room("errors").SceneError, match="nothing to draw"):
        based_near(empty, scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0), scenes.sun(40.0))


def test_the_live_view_of_an_emptied_scene_says_so(room, viewport, live):
    """Of Blender's part nothing is needed here: the worker has read the scene."""
    reader = room("blender.live_scene").LiveScene()
    reader._scene, reader._is_stale = replace(field(room, 0), meshes=()), False
    live._scene = reader
    context = SimpleNamespace(region=SimpleNamespace(width=8, height=8), space_data=None, region_data=None)
    live._look(context, None)
    assert "nothing to draw" in live.message and "report this" not in live.message


def test_what_was_in_the_making_when_the_scene_was_emptied_is_never_shown(room, viewport, live):
    draw(room, live, field(room, 3))
    draw(room, live, None)
    assert viewport.asked[-1].is_given_up
    viewport.asked[-1].is_done = True
    draw(room, live, None)
    assert shown(live) is None


@pytest.mark.parametrize("kind", ["GpuError", None], ids=["a user's error", "a defect"])
def test_a_picture_that_fails_leaves_no_other_scenes_picture_and_is_not_asked_for_again(room, viewport, live, kind, caplog):
    draw(room, live, field(room, 3))
    finish(room, viewport, live, field(room, 3))
    draw(room, live, field(room, 4))
    viewport.asked[-1].error = getattr(room("errors"), kind)("Too large: lower it.") if kind else RuntimeError("Too large: lower it.")
    finish(room, viewport, live, field(room, 4))
    assert shown(live) is None and "Too large" in live.message
    last = viewport.asked[-1]
    for _ in range(3):
        viewport.clock[0] += 1.0
        draw(room, live, field(room, 4))
    assert viewport.asked[-1] is last
    assert any(record.exc_info for record in caplog.records) == (kind is None)  # a defect's traceback goes to the console


def test_the_coarse_picture_of_a_view_stays_when_its_fine_one_fails(room, viewport, live):
    draw(room, live, field(room, 3))
    finish(room, viewport, live, field(room, 3))
    draw(room, live, field(room, 4))
    viewport.asked[-1].is_done = True
    viewport.clock[0] += 0.01
    draw(room, live, field(room, 4))
    assert shown(live) == 4 and live._shown.coarseness > 1
    viewport.clock[0] += 0.3
    draw(room, live, field(room, 4))
    viewport.asked[-1].error = room("errors").GpuError("Too large: lower it.")
    finish(room, viewport, live, field(room, 4))
    assert shown(live) == 4 and "Too large" in live.message


def test_a_view_whose_engine_blender_has_dropped_is_not_taken_for_the_one_that_is_shown(room, viewport, live):
    """Rendered shading left and chosen again: the old engine object may live on for a while."""
    region = SimpleNamespace(as_pointer=lambda: 4711)
    live._take_place(4711)
    draw(room, live, field(room, 3))
    finish(room, viewport, live, field(room, 3))
    newer = viewport.LiveView()
    newer._take_place(4711)
    assert viewport.live_view_in(region) is newer and shown(live) is None
    elsewhere = viewport.LiveView()
    elsewhere._take_place(815)
    assert viewport.live_view_in(region) is newer
    for view in (newer, elsewhere):
        view.close()


def asked_for(viewport):
    """Size, samples, and whether numbers are wanted, of the last picture asked for."""
    job = viewport.asked[-1].job
    return job.size, job.settings.shading.samples, job.measure


def test_a_view_that_stands_still_gets_finer_pictures_and_at_last_its_numbers(room, viewport, live, monkeypatch):
    told = []
    monkeypatch.setattr(viewport.session, "remember", lambda outcome, scene: told.append(outcome.job.measure))
    context = SimpleNamespace(area=SimpleNamespace(regions=[]), scene=None)
    live._ask(job_of(room, field(room, 2)))
    steps = [asked_for(viewport)]
    for _ in range(5):
        viewport.asked[-1].is_done = True
        viewport.clock[0] += 0.3
        live._ask(job_of(room, field(room, 2)))
        live._tell(context)
        steps.append(asked_for(viewport))
    assert steps[:3] == [((8, 8), 1, False), ((8, 8), 4, False), ((8, 8), 4, True)]
    assert set(steps[3:]) == {steps[2]} and told == [True]
    assert {"combined", "depth", "aliasing"} <= set(viewport.asked[-1].job.passes)  # also what the error graph is drawn from
    assert not live.needs_redraw


def test_a_view_that_moves_gets_coarse_pictures_then_fine_ones(room, viewport, live):
    live._ask(job_of(room, field(room, 2)))
    sizes = []
    for count in (3, 4):
        viewport.asked[-1].is_done = True
        viewport.clock[0] += 0.01
        live._ask(job_of(room, field(room, count)))
        sizes.append(asked_for(viewport))
    assert sizes == [((4, 4), 1, False)] * 2
    viewport.asked[-1].is_done = True
    viewport.clock[0] += 0.3
    live._ask(job_of(room, field(room, 4)))
    assert asked_for(viewport) == ((8, 8), 1, False)


@pytest.mark.parametrize("is_parallel", [False, True])
def test_a_picture_in_space_lies_where_it_was_seen(room, is_parallel):
    """Every corner of the mesh is seen by the camera at its place in the picture; that of another view is where that view sees it."""
    mesh_of, spaces = room("blender.reprojection").picture_mesh, room("maths.spaces")
    camera = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0)
    if is_parallel:
        camera = replace(camera, clip_from_view=spaces.orthographic(4.0, 3.0, 1.0, 60.0))
    size = (160, 120)
    job = room("pipeline.job").Job(scenes.chair(), camera, None, room("settings.groups").Settings(), size, keeps_depth=True)
    depth = room("studies.run").run(job).frame.view_depth
    places, uvs, triangles = mesh_of(depth, camera, most=size[0] * size[1])
    used = np.unique(triangles)
    clip = np.concatenate([places[used], np.ones((len(used), 1))], axis=1) @ camera.clip_from_world.T
    assert np.abs(0.5 * clip[:, :2] / clip[:, 3:] + 0.5 - uvs[used]).max() < 1e-6
    seen = depth[::-1].reshape(-1)
    assert set(np.flatnonzero(seen)) <= set(used) or np.isin(np.flatnonzero(seen), used).mean() > 0.97
    exact = used[seen[used] > 0.0]
    assert np.allclose(-(camera.view_from_world @ np.append(places[exact[0]], 1.0))[2], seen[exact[0]], rtol=1e-5)


def test_the_mesh_of_a_picture_is_drawn_from_far_to_near_and_has_no_more_corners_than_allowed(room):
    depth = np.zeros((300, 400), np.float32)
    depth[50:250, 80:320] = np.linspace(3.0, 9.0, 240)
    camera = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0)
    places, _, triangles = room("blender.reprojection").picture_mesh(depth, camera, most=5000)
    assert len(places) <= 5400 and len(triangles)
    far = (-(camera.view_from_world[2, :3] @ places.T) - camera.view_from_world[2, 3])[triangles].min(axis=1)
    assert (np.diff(far) <= 1e-4).all()
    empty = room("blender.reprojection").picture_mesh(np.zeros((30, 40), np.float32), camera)
    assert len(empty[2]) == 0


def test_the_live_views_pixels_are_as_large_as_the_scene_says(room, blend):
    """Every size that Blender offers, and by itself two on a screen of fine pixels."""
    size_of = room("blender.live_scene").pixel_size
    offered = [item.identifier for item in blend.types.RenderSettings.bl_rna.properties["preview_pixel_size"].enum_items]
    assert [size_of(one, 2.0) for one in offered] == [2, 1, 2, 4, 8]
    assert [size_of("AUTO", screen) for screen in (1.0, 1.5, 2.0)] == [1, 1, 2]
