"""A coarser caster is near its mesh by the distance it states, of as many bodies, and names a triangle at each of its own."""

import numpy as np
import pytest

from addon.pipeline.detail import kept
from addon.pipeline.detail.bodies import Bodies, connected, is_closed
from addon.pipeline.detail.collapse import Coarse, coarser
from tests import scenes


def tube(count, radius, length, rings=60, closed=True):
    """A cylinder of `count` sides and many rings; open at both ends or with caps."""
    angle = 2.0 * np.pi * np.arange(count) / count
    ring = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    points = np.concatenate([ring + (0.0, 0.0, z) for z in np.linspace(0.0, length, rings)])
    quads = [(r * count + i, r * count + (i + 1) % count, (r + 1) * count + (i + 1) % count, (r + 1) * count + i)
             for r in range(rings - 1) for i in range(count)]  # fmt: skip
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    if closed:
        last = (rings - 1) * count
        points = np.concatenate([points, [(0.0, 0.0, 0.0), (0.0, 0.0, length)]])
        triangles += [(len(points) - 2, (i + 1) % count, i) for i in range(count)]
        triangles += [(len(points) - 1, last + i, last + (i + 1) % count) for i in range(count)]
    return points.astype(np.float32), np.array(triangles, np.int32)


def joined(*parts):
    firsts = np.cumsum([0, *(len(points) for points, _ in parts)])
    return np.concatenate([p for p, _ in parts]), np.concatenate([t + f for (_, t), f in zip(parts, firsts, strict=False)])


def ball():
    """Its poles are one point each."""
    positions, triangles = scenes.ball((5.0, 0.0, 0.0), 1.0)
    return np.round(positions, 6).astype(np.float32), triangles.astype(np.int32)


BALL = ball()
MESHES = {"ball": BALL, "tube": tube(48, 0.5, 4.0), "open tube": tube(48, 0.5, 4.0, closed=False), "two": joined(BALL, tube(32, 0.2, 3.0))}


@pytest.mark.parametrize("name", MESHES)
def test_levels_have_fewer_and_fewer_triangles_and_state_their_error(name):
    positions, triangles = MESHES[name]
    levels = coarser(positions, triangles)
    assert levels
    counts = [len(triangles), *(len(level.triangles) for level in levels)]
    assert all(after <= 0.85 * before for before, after in zip(counts, counts[1:], strict=False))
    size = np.linalg.norm(np.ptp(positions, axis=0))
    assert all(0.0 < level.error < 0.03 * size for level in levels)


def test_a_balls_corners_lie_within_the_error_of_its_surface():
    levels = coarser(*BALL)
    sagitta = 1.0 - np.linalg.norm(BALL[0][BALL[1]].mean(axis=1) - (5.0, 0.0, 0.0), axis=1).min()
    for level in levels:
        radii = np.linalg.norm(level.positions - (5.0, 0.0, 0.0), axis=1)
        assert radii.max() <= 1.0 + level.error + 1e-5
        assert radii.min() >= 1.0 - sagitta - level.error - 1e-5


@pytest.mark.parametrize("name", MESHES)
def test_the_triangle_named_lies_at_the_coarse_one(name):
    positions, triangles = MESHES[name]
    level = coarser(positions, triangles)[-1]
    middles = level.positions[level.triangles].mean(axis=1)
    named = positions[triangles[level.source]]
    reach = np.linalg.norm(named - named.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    near = np.linalg.norm(middles - named.mean(axis=1), axis=1)
    longest = np.linalg.norm(level.positions[level.triangles[:, 0]] - level.positions[level.triangles[:, 1]], axis=1).max()
    assert (near <= reach + level.error + longest).all()


def test_what_is_closed_stays_closed_and_borders_stay():
    for name in ("ball", "tube", "two"):
        assert all(is_closed(level.triangles) for level in coarser(*MESHES[name]))
    positions, _ = MESHES["open tube"]
    ends = positions[np.isin(positions[:, 2], (0.0, 4.0))]
    for level in coarser(*MESHES["open tube"]):
        away = np.linalg.norm(ends[:, None] - level.positions, axis=2).min(axis=1)
        assert away.max() < 1e-6


def test_a_thin_wire_does_not_lose_its_thickness_beside_a_large_body():
    big, wire = tube(96, 5.0, 20.0), tube(12, 0.004, 20.0)
    levels = coarser(*joined(big, (wire[0] + np.float32([20.0, 0.0, 0.0]), wire[1])))
    for level in levels:
        own = level.positions[:, 0] > 15.0
        spread = np.ptp(level.positions[own][:, :2], axis=0)
        assert (spread > 0.006).all()


def test_bodies_are_what_triangles_join():
    positions, triangles = MESHES["two"]
    number = connected(len(positions), triangles)
    assert len(np.unique(number)) == 2
    assert (number[: len(BALL[0])] == number[0]).all()


def test_a_body_that_is_gone_is_noticed():
    positions, triangles = MESHES["two"]
    bodies = Bodies(positions.astype(np.float64), triangles)
    assert bodies.are_kept(positions.astype(np.float64), triangles, np.arange(len(positions)))
    assert not bodies.are_kept(positions.astype(np.float64), triangles[: len(BALL[1])], np.arange(len(positions)))


def level(**changed):
    arrays = {"positions": np.zeros((3, 3), np.float32), "triangles": np.array([[0, 1, 2]], np.int32), "source": np.zeros(1, np.int32)}
    return Coarse(**(arrays | {"error": 0.1} | changed))


def test_what_is_kept_on_disk_comes_back(tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "folder", lambda: tmp_path)
    kept.write("a.npz", (level(), level(error=0.5)))
    back = kept.read("a.npz", 1)
    assert [one.error for one in back] == [0.1, 0.5]
    assert np.array_equal(back[0].triangles, [[0, 1, 2]])
    assert kept.read("b.npz", 1) is None


@pytest.mark.parametrize(
    "changed",
    [
        {"triangles": np.array([[0, 1, 3]], np.int32)},
        {"source": np.ones(1, np.int32)},
        {"source": np.zeros(2, np.int32)},
        {"positions": np.zeros((3, 2), np.float32)},
        {"triangles": np.array([[0, 1, 2]], np.int64)},
    ],
)
def test_what_does_not_fit_the_mesh_is_not_taken_from_disk(tmp_path, monkeypatch, changed):
    monkeypatch.setattr(kept, "folder", lambda: tmp_path)
    kept.write("a.npz", (level(**changed),))
    assert kept.read("a.npz", 1) is None
    (tmp_path / "a.npz").write_bytes(b"PK no archive")
    assert kept.read("a.npz", 1) is None


def test_disk_space_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "folder", lambda: tmp_path)
    monkeypatch.setattr(kept, "MOST_BYTES", 4000)
    for k in range(9):
        kept.write(f"{k}.npz", (level(),))
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 4000
    assert (tmp_path / "8.npz").is_file()
