"""The procedural deck: size as asked, the same for the same seed, sound geometry."""

import numpy as np
import pytest

from addon.errors import SettingsError
from addon.scene.default_view import outline_points
from addon.scene.mesh_prep import drawable
from addon.scene.platform_deck import build
from tests.from_cad import scene_from_model


@pytest.mark.parametrize("triangles", [10_000, 30_000, 150_000, 1_000_000])
def test_the_deck_has_about_as_many_triangles_as_asked(triangles):
    model = build(triangles)
    assert abs(model.triangle_count / triangles - 1) < (0.3 if triangles == 10_000 else 0.15)
    assert sum(len(m.triangles) for m in model.meshes) < max(triangles / 2, 8000), "shared meshes"


def test_the_same_seed_gives_the_same_deck_and_another_seed_another():
    one, two, other = build(50_000, seed=5), build(50_000, seed=5), build(50_000, seed=6)
    assert [p.name for p in one.parts] == [p.name for p in two.parts]
    assert np.array_equal(one.world_from_part(), two.world_from_part())
    assert [p.name for p in one.parts] != [p.name for p in other.parts]


def test_every_part_is_sound():
    model = build(60_000)
    for mesh in model.meshes:
        keep, defects = drawable(mesh.positions, mesh.triangles)
        assert keep.all() and not defects, mesh.name


def test_no_part_stands_twice_in_the_same_place():
    model = build(150_000)
    placed = [(p.mesh, *np.round(m, 3).ravel().tolist()) for p, m in zip(model.parts, model.world_from_part(), strict=True) if p.mesh >= 0]
    assert len(placed) == len(set(placed))


def test_solids_are_wound_outwards():
    model = build(30_000)
    for mesh in model.meshes:
        p = mesh.positions.astype(np.float64)[mesh.triangles]
        volume = np.einsum("ti,ti->t", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() / 6
        assert volume > 0, mesh.name


def test_the_length_can_be_set():
    bounds = build(200_000, length_m=240).bounds()
    assert 240 <= (bounds[1] - bounds[0])[0] < 275


def test_sizes_out_of_range_are_refused():
    for arguments in ({"triangles": 100}, {"triangles": 10**9}, {"length_m": 3.0}):
        with pytest.raises(SettingsError):
            build(**arguments)


def test_the_deck_makes_a_scene_without_blender():
    model = build(10_000)
    scene = scene_from_model(model)
    assert scene.triangle_count == model.triangle_count
    assert len(scene.object_names) == model.part_count == len(scene.instances)
    points = outline_points(scene) + scene.origin_ws
    assert np.allclose([points.min(axis=0), points.max(axis=0)], model.bounds(), atol=1e-4)
    assert {tuple(c) for c in scene.instances.base_color} <= {tuple(np.float32(m.base_color)) for m in model.materials}
