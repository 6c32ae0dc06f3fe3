"""mesh_prep and mesh_pieces against their definitions: brute-force oracles, invariances, bad input."""

from math import cos, pi, radians

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from addon.scene.mesh_pieces import RawMesh, prepare_all
from addon.scene.mesh_prep import Defects, drawable, shade_by_corners, shade_by_crease, weld
from tests.margins import at_most
from tests.scenes import ball, box, rod


def soup(seed: int, points: int, faces: int) -> tuple[np.ndarray, np.ndarray]:
    """Random triangles on few random points, so that many meet at each; zero-area ones left out."""
    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(points, 3)).astype(np.float32)
    triangles = np.array([rng.permutation(points)[:3] for _ in range(faces)])
    return positions, triangles[drawable(positions, triangles)[0]]


def face_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    p = positions.astype(np.float64)[triangles]
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def crease_oracle(positions: np.ndarray, triangles: np.ndarray, angle: float) -> tuple[np.ndarray, float]:
    """(T, 3, 3) corner normals by the definition, and how close any pair of faces comes to the angle."""
    p = positions.astype(np.float64)
    normals = face_normals(positions, triangles)
    out, closest = np.empty((len(triangles), 3, 3)), np.inf
    for t, triangle in enumerate(triangles):
        for k, vertex in enumerate(triangle):
            total = np.zeros(3)
            for u, other in enumerate(triangles):
                for m in range(3):
                    if not np.array_equal(p[other[m]], p[vertex]):
                        continue
                    away = np.arccos(np.clip(normals[t] @ normals[u], -1, 1))
                    closest = min(closest, abs(away - angle))
                    if away <= angle:
                        a, b = p[other[m - 2]] - p[other[m]], p[other[m - 1]] - p[other[m]]
                        total += normals[u] * np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)
            out[t, k] = total / np.linalg.norm(total)
    return out, closest


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.floats(0.05, 2.0))
def test_crease_normals_equal_their_definition(seed, angle):
    positions, triangles = soup(seed, 7, 12)
    expected, closest = crease_oracle(positions, triangles, angle)
    assume(closest > 1e-2)
    shaded = shade_by_crease(positions, triangles, angle)
    at_most(np.abs(shaded.normals[shaded.triangles] - expected).max(), 1e-4)
    assert np.array_equal(shaded.positions[shaded.triangles], positions[triangles])


@given(st.integers(0, 10**6))
def test_welding_is_equality_of_positions(seed):
    rng = np.random.default_rng(seed)
    positions = rng.integers(-2, 3, size=(60, 3)).astype(np.float32) * np.float32(0.1)
    positions[rng.random((60, 3)) < 0.1] = np.float32(-0.0)
    number, first = weld(positions)
    equal = (positions[:, None] == positions).all(axis=2)
    assert np.array_equal(number[:, None] == number, equal)
    assert np.array_equal(number[first], np.arange(len(first)))


def test_groups_are_not_welded_together():
    positions = np.zeros((4, 3), dtype=np.float32)
    assert weld(positions, np.array([0, 0, 1, 1], dtype=np.int32))[0].tolist() in ([0, 0, 1, 1], [1, 1, 0, 0])


def test_a_box_keeps_its_edges_at_30_degrees_and_loses_them_at_180():
    positions, triangles = box((0, 0, 0), (1, 2, 3))
    sharp, smooth = shade_by_crease(positions, triangles, pi / 6), shade_by_crease(positions, triangles, pi)
    assert np.allclose(sharp.normals[sharp.triangles], face_normals(positions, triangles)[:, None], atol=1e-6)
    assert len(sharp.positions) == 24 and len(smooth.positions) == 8
    corner = smooth.positions / np.array([1, 2, 3]) * 2 - 1
    assert np.allclose(smooth.normals, corner / np.sqrt(3), atol=1e-6), "angle weights: independent of the diagonals"


def test_a_fine_rod_is_round_and_a_coarse_one_is_not():
    for sides, is_round in ((24, True), (8, False)):
        positions, triangles = rod((0, 0, 0), (0, 0, 1), 0.5, sides)
        shaded = shade_by_crease(positions, triangles)
        radial = shaded.positions * [1, 1, 0] / 0.5
        assert np.allclose(shaded.normals, radial, atol=1e-5) == is_round


def test_doubled_faces_back_to_back_keep_their_own_sides():
    positions, triangles = ball((0, 0, 0), 1.0, 24, 12)
    shaded = shade_by_crease(positions, np.concatenate([triangles, triangles[:, ::-1]]))
    facing = np.einsum(
        "tci,ti->tc", shaded.normals[shaded.triangles], face_normals(positions, np.concatenate([triangles, triangles[:, ::-1]]))
    )
    assert facing.min() > cos(radians(30))


def test_the_tip_of_a_fine_cone_keeps_its_faces():
    angle = np.arange(1000) * 2 * np.pi / 1000
    positions = np.concatenate([[[0, 0, 1]], np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)]).astype(np.float32)
    ring = np.arange(1000)
    triangles = np.stack([0 * ring, 1 + ring, 1 + (ring + 1) % 1000], axis=1)
    shaded = shade_by_crease(positions, triangles)
    assert np.allclose(shaded.normals[shaded.triangles[:, 0]], face_normals(positions, triangles), atol=1e-5)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_bad_vertices_and_flat_faces_are_left_out_and_counted_at_every_scale(scale):
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [np.nan, 0, 0], [0, np.inf, 0], [1, 1e-3, 0]]) * scale
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4], [1, 2, 5], [0, 1, 1], [0, 3, 6], [0, 1, 99], [-1, 0, 1]])
    keep, defects = drawable(positions, triangles)
    assert keep.tolist() == [True, False, False, False, False, True, False, False]
    assert defects == Defects(bad_vertices=2, bad_faces=4, zero_area_faces=2)
    assert "2 vertices" in defects.sentence("x") and "'" not in defects.sentence()


def test_no_triangles_are_no_error():
    keep, defects = drawable(np.zeros((3, 3)), np.empty((0, 3), dtype=int))
    assert len(keep) == 0 and not defects


def test_given_corner_normals_are_kept_and_split_vertices_only_where_they_differ():
    positions, triangles = soup(3, 12, 30)
    normals = np.random.default_rng(1).integers(0, 3, len(triangles))[:, None, None]
    normals = np.eye(3, dtype=np.float32)[np.broadcast_to(normals[:, :, 0], (len(triangles), 3))]
    shaded = shade_by_corners(positions, triangles, normals)
    assert np.array_equal(shaded.normals[shaded.triangles], normals)
    assert np.array_equal(shaded.positions[shaded.triangles], positions[triangles])
    wanted = {(v, *n) for v, n in zip(triangles.ravel().tolist(), normals.reshape(-1, 3).tolist(), strict=True)}
    assert len(shaded.positions) == len(wanted)


def raws() -> list[RawMesh]:
    """Meshes of every sort: plain, slots, own normals, far away, defective, hopeless."""
    b, s = box((0, 0, 0), (1, 1, 1)), ball((5, 0, 0), 1.0, 12, 6)
    far = (b[0] + [3e5, -2e5, 10], b[1])
    broken = b[0].copy()
    broken[0] = np.nan
    flat = np.stack([face_normals(*b).astype(np.float32)] * 3, axis=1)
    made = [
        RawMesh(p.astype(np.float32), t.astype(np.int32)) for p, t in (b, s, far, (broken, b[1]), (np.zeros((3, 3)), np.array([[0, 1, 2]])))
    ]
    with_slots = RawMesh(s[0].astype(np.float32), s[1].astype(np.int32), (np.arange(len(s[1])) % 3 * 2).astype(np.int32))
    return [*made, with_slots, RawMesh(b[0].astype(np.float32), b[1].astype(np.int32), None, flat)]


def test_meshes_come_out_the_same_together_and_alone():
    meshes = raws()
    together = prepare_all(meshes, range(len(meshes)), pi / 6)
    for i, raw in enumerate(meshes):
        alone = prepare_all([raw], [i], pi / 6)[0]
        assert together[i].slots == alone.slots and together[i].defects == alone.defects
        assert np.array_equal(together[i].offset_os, alone.offset_os)
        for a, b in zip(together[i].meshes, alone.meshes, strict=True):
            assert a.key == b.key
            assert np.array_equal(a.positions[a.triangles], b.positions[b.triangles])
            assert np.allclose(a.normals[a.triangles], b.normals[b.triangles], atol=1e-6)


def test_slots_share_out_the_triangles_and_their_vertices():
    raw = raws()[5]
    prepared = prepare_all([raw], ["key"], pi)[0]
    assert prepared.slots == (0, 2, 4) and [m.key for m in prepared.meshes] == [("key", 0), ("key", 2), ("key", 4)]
    for mesh, slot in zip(prepared.meshes, prepared.slots, strict=True):
        assert np.array_equal(mesh.positions[mesh.triangles], raw.positions[raw.triangles[raw.slots == slot]])
        assert set(mesh.triangles.ravel().tolist()) == set(range(len(mesh.positions)))
    assert np.allclose(np.linalg.norm(np.concatenate([m.normals for m in prepared.meshes]), axis=1), 1.0, atol=1e-5)


def test_a_far_mesh_is_moved_to_its_own_origin_exactly():
    raw = raws()[2]
    prepared = prepare_all([raw], ["far"], pi / 6)[0]
    mesh = prepared.meshes[0]
    assert np.abs(mesh.bounds_os).max() < 1.0 and np.abs(prepared.offset_os).max() > 1e5
    assert np.array_equal(
        mesh.positions[mesh.triangles].astype(np.float64) + prepared.offset_os, raw.positions[raw.triangles].astype(np.float64)
    )


def test_a_mesh_without_a_good_face_gives_nothing_but_its_defects():
    prepared = prepare_all(raws(), range(7), pi / 6)
    assert prepared[4].meshes == () and prepared[4].defects.zero_area_faces == 1
    assert prepared[3].defects.bad_vertices == 1 and len(prepared[3].meshes[0].triangles) == 12 - prepared[3].defects.bad_faces
