"""The nearest surface wins, at any clip range: with clip control, and without it as on macOS."""

import numpy as np
import pytest

from addon.errors import GpuError
from addon.maths import anchored_camera, spaces
from addon.maths.depth_projection import DepthProjection
from addon.maths.view import Camera
from addon.pipeline.gl.depth_buffer import has_clip_control, nearest_wins
from addon.pipeline.gl.gl_raw import raw_gl
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.scene.local_origin import based_near
from addon.scene.records import Instances, Mesh, Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import plates, scenes

SETTINGS = Settings().replaced(fit={"size": 64}, partition={"kind": "none"})
ALLOWED = 0.003


@pytest.fixture(params=[True, False], ids=["clip control", "no clip control"])
def eye(request, worker):
    """Renders what a camera sees of a scene: the data images. The driver has clip control, or is one without."""
    control = worker.call(lambda context: raw_gl(context).ClipControl)
    if not request.param:
        worker.call(lambda context: setattr(raw_gl(context), "ClipControl", None))
    elif control is None:
        pytest.skip("this driver has no clip control")
    yield (
        lambda scene, camera, size=plates.SIZE: (
            run(Job(scene, camera, None, SETTINGS, size, ("depth", "normal", "object")), on=Renderer(worker)).frame.passes
        )
    )
    assert worker.call(has_clip_control) == request.param
    worker.call(lambda context: setattr(raw_gl(context), "ClipControl", control))
    assert worker.call(lambda context: context.error) == "GL_NO_ERROR"


@pytest.mark.parametrize("case", list(plates.named()), ids=lambda case: case.name)
def test_the_nearer_of_two_surfaces_shows(eye, case):
    seen = eye(case.scene, case.camera)
    assert (case.nearest >= 0).mean() > 0.1
    assert case.wrong_share(seen["object"]) <= ALLOWED


@pytest.mark.parametrize("largest", [0.7, 3.7])
@pytest.mark.parametrize("seeds", [range(15), range(36, 51)], ids=str)
def test_the_nearer_of_two_plates_drawn_at_random_shows(eye, seeds, largest):
    """Up to five times, and up to 5,000 times as large as what the picture shows of them."""
    cases = [plates.drawn(seed, largest=largest) for seed in seeds]
    shares = {case.name: case.wrong_share(eye(case.scene, case.camera)["object"]) for case in cases}
    assert {name: share for name, share in shares.items() if share > ALLOWED} == {}


def test_a_road_a_tenth_of_a_millimetre_above_a_hundred_kilometres_of_ground_shows(eye):
    """On a slope, seen by a walker at 1.7 m, far/near 1e6. What float32 makes of the ground's corners is off by half a centimetre."""
    slope = spaces.rotation((1.0, 2.0, 0.5), 0.4)
    view = spaces.look_at((12000.0, -10000.0, 1.7), (12005.0, -9994.0, 0.0)) @ np.linalg.inv(slope)
    placed = [(plates.square(5e4), slope), (plates.square(4.0), slope @ spaces.translation((12005.0, -9994.0, 1e-4)))]
    case = plates.case_of("road", placed, Camera(view, plates.lens(35.0, 0.01, 1e4), 0.01, 1e4))
    scene, camera, _ = based_near(case.scene, case.camera, None)
    assert (case.nearest == 1).mean() > 0.2
    assert case.wrong_share(eye(scene, camera)["object"]) <= ALLOWED


@pytest.mark.parametrize("is_parallel", [True, False])
@pytest.mark.parametrize("make", [scenes.closed_box, scenes.sphere, scenes.staircase])
def test_cutting_every_triangle_to_the_view_changes_no_picture(eye, monkeypatch, make, is_parallel):
    """Baked and instanced, with smooth normals; the eye is among them, so many are cut."""
    clip = spaces.orthographic(1.5, 1.5, 0.02, 30.0) if is_parallel else spaces.perspective(0.7, 1.5, 0.02, 30.0)
    camera = Camera(spaces.look_at((-1.9, -2.9, 1.5), (0.0, 0.6, 0.7)), clip, 0.02, 30.0)
    scene = bent(make())
    whole = eye(scene, camera, (150, 100))
    monkeypatch.setattr(anchored_camera, "LARGE", 1e-9)
    cut = eye(scene, camera, (150, 100))
    assert (whole["object"] >= 0).mean() > 0.3
    assert (whole["object"] != cut["object"]).mean() < 1e-3
    same = (whole["object"] == cut["object"]) & (whole["object"] >= 0)
    assert np.quantile(np.abs(whole["normal"] - cut["normal"])[same], 0.999) < 2e-3
    assert np.quantile(np.abs(whole["depth"][same] / cut["depth"][same] - 1.0), 0.999) < 2e-5


def bent(scene):
    """The scene 20 times over, 60 m apart, so that meshes of some size are drawn instanced; normals that turn from corner to corner."""
    meshes = []
    for mesh in scene.meshes:
        normals = mesh.normals + 0.3 * np.sin(7.0 * np.round(mesh.positions[:, [1, 2, 0]], 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        meshes.append(Mesh((mesh.key, "bent"), mesh.positions, normals, mesh.triangles))
    i, n = scene.instances, 20
    matrices = np.concatenate([i.world_from_object] * n)
    matrices[:, 0, 3] += np.repeat(60.0 * np.arange(n), len(i))
    index, ids, slots = (np.tile(column, n) for column in (i.mesh_index, i.object_id, i.material_slot))
    instances = Instances(index, matrices, ids, slots, np.tile(i.base_color, (n, 1)))
    return Scene(tuple(meshes), instances, scene.object_names, scene.origin_ws)


def test_the_depth_pass_is_that_of_the_nearer_plate(eye):
    case = plates.pair(50.0, 0.001, 0.01, 1000.0)
    seen, nearest = eye(case.scene, case.camera), case.hits.min(axis=0)
    both = np.isfinite(nearest) & np.isfinite(seen["depth"])
    assert both.mean() > 0.1
    assert np.abs(seen["depth"][both] / nearest[both] - 1.0).max() < 1e-6


@pytest.mark.parametrize("is_parallel", [True, False])
@pytest.mark.parametrize(("near", "far", "shown"), [(0.01, 1e6, {0, 1, 2}), (9.5, 1e6, {1, 2}), (0.01, 20.5, {0, 1}), (9.5, 20.5, {1})])
def test_the_cameras_clip_is_a_section(eye, is_parallel, near, far, shown):
    """Three upright plates at 9, 20 and 30 m, each beside the next; far/near up to 1e8."""
    clip = spaces.orthographic(6.0, 1.0, near, far) if is_parallel else spaces.perspective(0.3, 1.0, near, far)
    camera = Camera(spaces.look_at((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)), clip, near, far)
    places = (-2.5, 9.0), (-0.7, 20.0), (1.0, 30.0)
    sheets = [scenes.sheet((x, y, -5.0), (x + 1.5, y, -5.0), (x + 1.5, y, 5.0), (x, y, 5.0)) for x, y in places]
    seen = eye(scenes.scene_of(*sheets), camera, (96, 96))["object"]
    assert set(np.unique(seen)) - {-1} == shown


@pytest.mark.parametrize("is_parallel", [True, False])
def test_a_plate_through_the_near_plane_is_cut_where_the_plane_lies(eye, is_parallel):
    """A floor from behind the eye to far away: its first pixel row lies at the near plane, its depth falls short of it nowhere."""
    near, far = 2.0, 1e5
    clip = spaces.orthographic(6.0, 1.0, near, far) if is_parallel else spaces.perspective(0.6, 1.0, near, far)
    camera = Camera(spaces.look_at((0.0, 0.0, 1.0), (0.0, 1.0, 0.9)), clip, near, far)
    floor = scenes.sheet((-50.0, -50.0, 0.0), (50.0, -50.0, 0.0), (50.0, 50.0, 0.0), (-50.0, 50.0, 0.0))
    depth = eye(scenes.scene_of(floor), camera, (64, 256))["depth"]
    shown = depth[np.isfinite(depth)]
    assert shown.min() > near * (1.0 - 1e-5) and shown.min() < near * 1.2
    assert len(shown) > 500


def test_an_orthographic_view_may_begin_behind_its_eye(eye):
    """Blender's parallel viewports: near = −far."""
    camera = Camera(spaces.look_at((0.0, -3.0, 0.0), (0.0, 0.0, 0.0)), spaces.orthographic(3.0, 1.0, -5e4, 5e4), -5e4, 5e4)
    sheets = [scenes.sheet((-1.0, y, -1.0), (1.0, y, -1.0), (1.0, y, 1.0), (-1.0, y, 1.0)) for y in (-9.0, -9.00001, 4.0)]
    seen = eye(scenes.scene_of(*sheets), camera, (64, 64))
    assert set(np.unique(seen["object"])) == {-1, 1}
    assert np.allclose(seen["depth"][np.isfinite(seen["depth"])], -6.00001, atol=2e-6)


def test_a_draw_that_fails_leaves_clip_control_as_other_passes_want_it(worker, monkeypatch):
    def job(context):
        calls, raw = [], raw_gl(context)
        monkeypatch.setattr(raw, "ClipControl", lambda _, range_: calls.append(hex(range_)))
        with pytest.raises(GpuError), nearest_wins(context, DepthProjection(0.1, 10.0, False)):
            raise GpuError("no memory")
        return calls

    zero_to_one, minus_one_to_one = "0x935f", "0x935e"
    assert worker.call(job) == [zero_to_one, minus_one_to_one]
