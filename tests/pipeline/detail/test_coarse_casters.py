"""Maps drawn with coarser casters name triangles of the casters themselves: the exact test's picture stays what it was."""

import time
from dataclasses import replace

import numpy as np
import pytest

from addon.maths.shadow.projection import ShadowProjection
from addon.pipeline.detail import kept, making
from addon.pipeline.detail.choice import coarsest, texels_per_metre
from addon.pipeline.detail.collapse import coarser
from addon.pipeline.geometry.clusters import clustered
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.settings.groups import Settings
from addon.studies.report import report_of
from addon.studies.run import run
from tests import scenes

SIZE = (192, 128)


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """Nothing is kept in the user's cache."""
    monkeypatch.setattr(kept, "folder", lambda: tmp_path)
    monkeypatch.setattr(making, "PAYS_FROM", 1000)


@pytest.fixture(autouse=True)
def made_here(monkeypatch):
    """Made in this process: the tests of the process of its own take it back."""
    made = lambda self, mesh: tuple(coarser(mesh.positions, clustered(mesh.positions, mesh.triangles)[0]))  # noqa: E731
    monkeypatch.setattr(making.CoarseMaker, "_made_apart", made)


def balls():
    """Two fine balls over a floor."""
    one, two = scenes.ball((0.0, 0.0, 1.5), 1.0, 48, 32), scenes.ball((2.5, 0.5, 0.8), 0.6, 64, 40)
    return scenes.scene_of(scenes.floor(8.0), one, two)


def many(radius=0.5):
    """A fine ball at six places, mirrored and stretched at some, over a floor: drawn instanced."""
    ball = scenes.ball((0.0, 0.0, 0.0), radius, 64, 40)
    scene = scenes.scene_of(scenes.floor(8.0), ball)
    inst = scene.instances
    matrices = [inst.world_from_object[0]]
    for k in range(6):
        m = np.diag([1.0 + 0.2 * k, -1.0 if k % 2 else 1.0, 1.0, 1.0])
        m[:3, 3] = (1.6 * (k % 3) - 1.6, 2.0 * (k // 3) - 1.0, 0.8)
        matrices.append(m)
    pick = np.array([0, *[1] * 6])
    columns = {name: getattr(inst, name)[pick] for name in inst.__dataclass_fields__ if name not in ("mesh_index", "world_from_object")}
    placed = replace(inst, mesh_index=inst.mesh_index[pick], world_from_object=np.stack(matrices), **columns)
    return replace(scene, instances=placed)


def job(scene, casters, error=1.0, **more):
    camera = scenes.look_at((6.0, -7.0, 4.0), (0.5, 0.0, 0.6))
    test = {"casters": casters, "caster_error": error}
    settings = Settings().replaced(test=test, fit={"size": 256}, shading={"samples": 1})
    return Job(scene, camera, scenes.sun(50.0), settings, SIZE, ("combined", "shadow"), **more)


@pytest.mark.parametrize("scene", [balls(), many()], ids=["baked", "instanced"])
@pytest.mark.parametrize("error", [0.25, 1.0])
def test_the_picture_is_the_same_and_maps_take_fewer_triangles(scene, error, renderer):
    full = run(job(scene, "full"), on=renderer).frame
    coarse = run(job(scene, "coarse", error), on=renderer).frame
    assert "caster_triangles" not in full.geometry
    assert 0.0 < coarse.geometry["caster_error_texels"] <= error
    assert np.count_nonzero(coarse.passes["shadow"] != full.passes["shadow"]) <= 2
    assert (full.passes["shadow"] < 0.5).any()


def test_maps_take_fewer_triangles_the_larger_the_error_may_be(renderer):
    sent = [run(job(many(), "coarse", error), on=renderer).frame.geometry["caster_triangles"] for error in (0.03, 0.1, 1.0)]
    assert sent[0] >= sent[1] >= sent[2]
    assert sent[0] > sent[2]


def test_no_error_allowed_draws_all_triangles(renderer):
    assert "caster_triangles" not in run(job(many(), "coarse", 0.0), on=renderer).frame.geometry


def test_the_report_says_what_was_drawn(renderer):
    outcome = run(job(many(), "coarse"), on=renderer)
    geometry = report_of(outcome.job, outcome.frame)["geometry"]
    assert geometry["caster_triangles"] > 0
    assert 0.0 < geometry["caster_error_texels"] <= 1.0


def test_the_live_view_does_not_wait_and_pictures_do(worker, monkeypatch):
    held = []
    made = making.CoarseMaker._made_apart

    def slowly(self, mesh):
        while not held:
            time.sleep(0.01)
        return made(self, mesh)

    monkeypatch.setattr(making.CoarseMaker, "_made_apart", slowly)
    renderer, scene = Renderer(worker), many(0.55)  # nothing was made of it before
    live = job(scene, "live", is_live=True, measure=False)
    assert "caster_triangles" not in run(live, on=renderer).frame.geometry
    held.append(True)
    for _ in range(2000):
        frame = run(live, on=renderer).frame
        if "caster_triangles" in frame.geometry:
            break
        time.sleep(0.01)
    assert "caster_triangles" in frame.geometry
    assert "caster_triangles" not in run(job(scene, "live"), on=renderer).frame.geometry


@pytest.mark.parametrize("test", ["depth", "id-depth"])
def test_tests_that_compare_depths_keep_every_triangle(test, renderer):
    asked = job(many(), "coarse")
    asked = Job(asked.scene, asked.camera, asked.light, asked.settings.replaced(test={"kind": test}), SIZE)
    assert "caster_triangles" not in run(asked, on=renderer).frame.geometry


def test_texels_per_metre_are_at_least_those_of_any_point_in_the_box(rng):
    projection = warped()
    for _ in range(50):
        low = rng.uniform(-0.4, 0.3, 3)
        box = np.stack([low, low + rng.uniform(0.05, 0.3, 3)])[None]
        most = texels_per_metre(projection, 512, box, is_sun=False)[0]
        points = rng.uniform(*box[0], (200, 3))
        inside = points[(np.abs(projected(projection, points)) <= 1.0).all(axis=1)]
        for axis in np.eye(3):
            step = (projected(projection, inside + 1e-6 * axis) - projected(projection, inside)) * 256.0 / 1e-6
            assert (np.linalg.norm(step, axis=1) <= most * (1.0 + 1e-4)).all()


def warped():
    matrix = np.array([[2.0, 0.2, 0.0, 0.1], [0.1, 1.8, 0.3, 0.2], [0.0, 0.0, 1.0, 0.0], [0.0, 0.8, 0.1, 1.0]])
    made = ShadowProjection.__new__(ShadowProjection)
    object.__setattr__(made, "clip_from_world", matrix)
    object.__setattr__(made, "log", None)
    return made


def projected(projection, points):
    h = np.column_stack([points, np.ones(len(points))]) @ projection.clip_from_world.T
    return h[:, :2] / h[:, 3:]


def test_the_coarsest_level_allowed_is_chosen():
    errors, counts = np.array([0.1, 0.2, 0.4, 0.3]), np.array([3, 0, 1])
    begins = np.cumsum(counts) - counts
    assert coarsest(errors, begins, counts, np.array([0.25, 1.0, 0.1])).tolist() == [1, -1, -1]
    assert coarsest(errors, begins, counts, np.array([9.0, 1.0, 0.3])).tolist() == [2, -1, 3]
