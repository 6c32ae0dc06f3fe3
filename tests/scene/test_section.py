"""Sections: what the planes take away is gone, closed bodies get caps of the right area, open ones a warning."""

import numpy as np
import pytest

from addon.scene.looks import CAP, HIDDEN
from addon.scene.records import Instances
from addon.scene.section.caps import area_triangles
from addon.scene.section.closed import solid_of
from addon.scene.section.cut import cut
from tests import scenes
from tests.bodies import torus, tube

X, Y, Z = np.eye(3)


def plane(point, normal):
    return (*map(float, point), *map(float, normal))


def triangles_of(scene, row):
    mesh, world = scene.meshes[scene.instances.mesh_index[row]], scene.instances.world_from_object[row]
    return (mesh.positions.astype(np.float64) @ world[:3, :3].T + world[:3, 3])[mesh.triangles]


def area(corners):
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()


def cap_area(scene):
    return sum(area(triangles_of(scene, row)) for row in np.flatnonzero(scene.instances.flags & CAP))


def volume(scene):
    """Of everything, by the divergence theorem; right where caps close what was cut and all faces point outwards."""
    total = 0.0
    for row in range(len(scene.instances)):
        a, b, c = np.moveaxis(triangles_of(scene, row), 1, 0)
        outwards = np.cross(b - a, c - a)
        mesh = scene.meshes[scene.instances.mesh_index[row]]
        outwards *= np.sign((outwards * mesh.normals[mesh.triangles[:, 0]]).sum(axis=1, keepdims=True))
        total += (a * outwards).sum() / 6.0
    return total


@pytest.mark.parametrize(
    ("part", "at", "normal", "expected"),
    [
        (scenes.box((-1, -2, 0), (1, 2, 3)), (0, 0, 1.2), Z, 8.0),
        (scenes.box((-1, -2, 0), (1, 2, 3)), (0, 0, 1.2), (0.0, 1.0, 1.0), 2.0 * 3.0 * np.sqrt(2.0)),
        (tube(2.0, 1.5, 4.0), (0, 0, 1.0), Z, np.pi * (4.0 - 2.25)),
        (tube(2.0, 1.5, 4.0), (0, 0, 1.0), X, 4.0 * (4.0 - 3.0)),
        (torus(3.0, 1.0), (0, 0, 0), X, 2.0 * np.pi),
        (torus(3.0, 1.0), (0, 0, 0), Z, np.pi * (16.0 - 4.0)),
        (scenes.ball((0, 0, 0), 1.0, 256, 128), (0, 0, 0.5), Z, np.pi * 0.75),
    ],
)
def test_a_cap_has_the_area_of_the_cut(part, at, normal, expected):
    done = cut(scenes.scene_of(part), plane(at, normal))
    assert cap_area(done) == pytest.approx(expected, rel=5e-3)
    assert not done.warnings
    assert not (done.instances.flags & HIDDEN).any()


@pytest.mark.parametrize("normal", [Z, -Z, X, (0.3, -0.5, 0.8), (1.0, 1.0, 1.0)])
@pytest.mark.parametrize("part", [scenes.box((-1, -2, 0), (1, 2, 3)), tube(2.0, 1.5, 4.0, 64), torus(3.0, 1.0, 48, 24)])
def test_both_halves_of_a_section_make_up_the_whole(part, normal):
    scene = scenes.scene_of(part)
    at = scene.bounds_ws().mean(axis=0) + [0.1, 0.05, 0.2]
    halves = [cut(scene, plane(at, side * np.array(normal))) for side in (1.0, -1.0)]
    assert sum(map(volume, halves)) == pytest.approx(volume(scene), rel=1e-5)


def test_nothing_is_left_on_the_side_the_normal_points_to(rng):
    scene = scenes.scene_of(
        scenes.floor(), scenes.box((-1, -1, 0), (1, 1, 2)), scenes.ball((3, 0, 1), 1.0), scenes.rod((0, 3, 0), (2, 3, 2), 0.1)
    )
    for _ in range(5):
        at, normal = rng.uniform(-1, 1, 3), rng.normal(size=3)
        left = cut(scene, plane(at, normal))
        for row in range(len(left.instances)):
            assert ((triangles_of(left, row) - at) @ (normal / np.linalg.norm(normal))).max() < 1e-4


def test_three_planes_take_a_corner_and_its_three_caps_meet():
    scene = scenes.scene_of(scenes.box((0, 0, 0), (2, 2, 2)))
    planes = (*plane((0.5, 0, 0), X), *plane((0, 1.0, 0), Y), *plane((0, 0, 1.5), Z))
    left = cut(scene, planes)
    assert volume(left) == pytest.approx(0.5 * 1.0 * 1.5)
    assert cap_area(left) == pytest.approx(1.0 * 1.5 + 0.5 * 1.5 + 0.5 * 1.0)


def test_a_plane_in_a_face_takes_nothing_and_caps_nothing():
    scene = scenes.scene_of(scenes.box((-1, -1, 0), (1, 1, 2)))
    left = cut(scene, plane((0, 0, 2), Z))
    assert cap_area(left) == 0.0
    assert volume(left) == pytest.approx(8.0)
    assert len(cut(scene, plane((0, 0, 0), Z)).instances) == 0


def test_a_plane_through_corners_caps_as_one_beside_them():
    ball = scenes.scene_of(scenes.ball((0, 0, 0), 1.0, 64, 32))
    for at in (0.0, 1e-4):  # the equator is a ring of corners
        assert cap_area(cut(ball, plane((0, 0, at), Z))) == pytest.approx(32 * np.sin(2 * np.pi / 64), rel=1e-3)


def test_an_open_body_has_no_cap_and_is_named():
    scene = scenes.scene_of(scenes.rod((0, 0, 0), (0, 0, 2), 0.5), scenes.box((2, 0, 0), (3, 1, 2)))
    left = cut(scene, plane((0, 0, 1), Z))
    assert left.warnings == ("No cap where the section cuts 'part 0': not closed.",)
    assert cap_area(left) == pytest.approx(1.0)


def test_a_body_in_two_materials_is_one_body():
    positions, triangles = scenes.box((-1, -1, 0), (1, 1, 2))
    scene = scenes.scene_of((positions, triangles[:6]), (positions, triangles[6:]))
    old = scene.instances
    joined = Instances(old.mesh_index, old.world_from_object, [0, 0], [0, 1], old.base_color)
    scene = type(scene)(scene.meshes, joined, ("part",), np.zeros(3))
    left = cut(scene, plane((0, 0, 1), Z))
    assert not left.warnings
    assert cap_area(left) == pytest.approx(4.0)


def test_an_instance_is_cut_where_it_stands_in_the_world():
    turned = np.array([[0.0, -2.0, 0.0, 5.0], [2.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    scene = scenes.scene_of(scenes.box((-1, -1, 0), (1, 1, 2)), matrices=[turned])
    moved = type(scene)(scene.meshes, scene.instances, scene.object_names, np.array([100.0, 0.0, 0.0]))
    left = cut(moved, plane((105.0, 0.0, 0.0), X))
    assert cap_area(left) == pytest.approx(4.0 * 2.0)
    assert left.bounds_ws()[1, 0] == pytest.approx(5.0)


def test_a_wrongly_wound_body_is_capped_by_counting():
    positions, triangles = scenes.box((-1, -1, 0), (1, 1, 2))
    triangles = triangles.copy()
    triangles[::3] = triangles[::3, ::-1]
    body = solid_of(positions.astype(np.float32), triangles)
    assert body.is_closed and not body.is_oriented
    assert cap_area(cut(scenes.scene_of((positions, triangles)), plane((0, 0, 1), Z))) == pytest.approx(4.0)


def test_a_cavity_stays_empty_and_overlapping_solids_fill_once():
    outer, inner = scenes.box((-2, -2, -2), (2, 2, 2)), scenes.box((-1, -1, -1), (1, 1, 1))
    hollow = scenes.joined(outer, (inner[0], inner[1][:, ::-1]))
    assert cap_area(cut(scenes.scene_of(hollow), plane((0, 0, 0), Z))) == pytest.approx(16.0 - 4.0)
    overlapping = scenes.joined(scenes.box((0, 0, 0), (2, 2, 2)), scenes.box((1, 1, 0), (3, 3, 2)))
    assert cap_area(cut(scenes.scene_of(overlapping), plane((0, 0, 1), Z))) == pytest.approx(7.0)


def test_corners_a_little_apart_still_close_a_body(rng):
    positions, triangles = scenes.box((-1, -1, 0), (1, 1, 2))
    shaken = positions + rng.uniform(-1e-6, 1e-6, positions.shape)
    left = cut(scenes.scene_of((shaken, triangles)), plane((0, 0, 1), Z))
    assert not left.warnings
    assert cap_area(left) == pytest.approx(4.0, rel=1e-4)


def test_uncut_shadows_keep_what_is_cut_away_for_the_light_alone():
    scene = scenes.closed_box()
    done = cut(scene, plane((0, 0, 1), Z), casts_whole=True)
    flags = done.instances.flags
    assert sorted(flags) == [0, 0, HIDDEN, CAP]
    hidden = np.flatnonzero(flags == HIDDEN)
    assert triangles_of(done, hidden[0])[..., 2].max() == 2.0


def test_equal_sections_give_equal_scenes():
    scene = scenes.scene_of(torus(3.0, 1.0, 48, 24))
    one, two = (cut(scene, plane((0, 0, 0.2), Z)) for _ in range(2))
    assert one.fingerprint == two.fingerprint
    assert one.fingerprint != cut(scene, plane((0, 0, 0.3), Z)).fingerprint


def test_an_area_with_holes_and_islands_is_exact(rng):
    def square(half, turn=1):
        corners = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])[::turn]
        return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)

    for _ in range(5):
        angle = rng.uniform(0, np.pi)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        lines = np.concatenate([square(3.0), square(2.0, -1), square(1.0)]) @ turn
        for is_oriented in (True, False):
            made = area_triangles(lines, is_oriented)
            flat = np.concatenate([made, np.zeros((*made.shape[:2], 1))], axis=-1)
            assert area(flat) == pytest.approx(36.0 - 16.0 + 4.0, rel=1e-5)
