"""What grows with the scene costs no more per part of a large scene than of a small one: operations are counted, not seconds."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from addon.pipeline.geometry.clusters import runs
from addon.pipeline.geometry.packing import packed
from addon.pipeline.geometry.ranges import Ranges
from addon.pipeline.geometry.store import GeometryStore
from addon.scene.records import Instances, Mesh, Scene
from tests import scenes

SLOPE = 1.1  # operations of n over those of n / 4, above 4


def operations(function) -> int:
    """Lines of Python run and functions called by it, also of C."""
    count = 0

    def trace(frame, event, _):
        nonlocal count
        count += 1
        return trace

    def profile(frame, event, _):
        nonlocal count
        count += event == "c_call"

    before = sys.gettrace(), sys.getprofile()
    sys.settrace(trace)
    sys.setprofile(profile)
    try:
        function()
    finally:
        sys.settrace(before[0])
        sys.setprofile(before[1])
    return count


def every_other_given_back(count):
    pool = Ranges(1)
    pool.grow(7 * count)
    starts = [pool.allocate(7) for _ in range(count)]
    for start in starts[::2]:
        pool.free(start, 7)
    again = [pool.allocate(6) for _ in range(count // 2)]
    assert len(set(again)) == len(again) and None not in again


def given_back_at_random(count):
    pool, rng = Ranges(1), np.random.default_rng(1)
    pool.grow(64 * count)
    held = [(pool.allocate(n), n) for n in rng.integers(1, 60, count).tolist()]
    for i in rng.permutation(count).tolist():
        pool.free(*held[i])
    assert pool.allocate(pool.capacity) == 0


@pytest.mark.parametrize("work", [every_other_given_back, given_back_at_random])
def test_pools_cost_a_search_a_range(work):
    small, large = (operations(lambda n=n: work(n)) for n in (500, 2000))
    assert large < 4 * SLOPE * small


def test_ranges_never_overlap_and_join_again(rng):
    pool, held = Ranges(64), []
    for _ in range(3000):
        if held and rng.random() < 0.5:
            pool.free(*held.pop(rng.integers(len(held))))
        else:
            count = int(rng.integers(1, 30))
            start = pool.allocate(count)
            if start is None:
                pool.grow(count)
                start = pool.allocate(count)
            held.append((start, count))
        ends = np.sort(np.array([(s, s + c) for s, c in held]).reshape(-1, 2), axis=0)
        assert (ends[1:, 0] >= ends[:-1, 1]).all() and ends.max(initial=0) <= pool.capacity
    for one in held:
        pool.free(*one)
    assert pool.allocate(pool.capacity) == 0


def boxes(count, moved=(), hidden=()):
    """So many boxes, each a mesh of its own, in a row."""
    meshes, kept = [], [i for i in range(count) if i not in set(hidden)]
    positions, triangles = scenes.box((0.0, 0.0, 0.0), (0.4, 0.4, 0.4))
    for i in range(count):
        meshes.append(Mesh(("box", i), positions * (1.0 + 1e-3 * i), np.tile([0.0, 0.0, 1.0], (len(positions), 1)), triangles))
    placed = np.tile(np.eye(4), (count, 1, 1))
    placed[:, 0, 3] = np.arange(count)
    placed[list(moved), 2, 3] = 1.0
    rows = Instances(np.arange(len(kept)), placed[kept], kept, np.zeros(len(kept)), np.ones((len(kept), 4)))
    return Scene(tuple(meshes[i] for i in kept), rows, tuple(map(str, range(count))), np.zeros(3))


STEPS = {
    "read first": lambda n: (None, boxes(n)),
    "every other hidden": lambda n: (boxes(n), boxes(n, hidden=range(0, n, 2))),
    "every other moved": lambda n: (boxes(n), boxes(n, moved=range(0, n, 2))),
    "every other shown again": lambda n: (boxes(n, hidden=range(0, n, 2)), boxes(n)),
}


@pytest.mark.parametrize("step", STEPS)
def test_a_scene_of_many_parts_costs_no_more_a_part(worker, step):
    def measured(context, count):
        store = GeometryStore(context)
        before, after = STEPS[step](count)
        if before is not None:
            store.sync(before)
        cost = operations(lambda: store.sync(after))
        store.release()
        return cost

    small, large = (worker.call(lambda context, n=n: measured(context, n)) for n in (150, 600))
    assert large < 4 * SLOPE * small


def test_what_was_hidden_is_drawn_along_as_nothing(worker):
    """Parts given back leave no triangles in the pool: what is left is drawn by as few calls as before."""

    def measured(context):
        store = GeometryStore(context)
        store.sync(boxes(200))
        ranges = store.sync(boxes(200, hidden=range(0, 200, 2))).ranges
        calls = runs(np.ones(len(ranges.first), bool), ranges.first, ranges.count, None, 3072)
        pool = np.frombuffer(store.indices.read(), np.uint32)
        used = np.zeros(len(pool), bool)
        for first, count in zip(ranges.first, ranges.count, strict=True):
            used[first : first + count] = True
        ((first, count),) = calls
        between = pool[first : first + count][~used[first : first + count]]
        store.release()
        return len(ranges.first), between

    parts, between = worker.call(measured)
    assert parts == 100 and len(between) >= 99 * 36 and not between.any()


def test_meshes_made_ready_together_are_what_they_are_alone(rng):
    parts = [scenes.box((0.0, 0.0, 0.0), (1.0, 2.0, 3.0)), scenes.ball((1.0, 2.0, 3.0), 0.5), scenes.floor()]
    meshes = [Mesh(i, p, np.tile([0.6, 0.0, 0.8], (len(p), 1)), t) for i, (p, t) in enumerate(parts)]
    matrices = np.tile(np.eye(4), (3, 1, 1))
    matrices[:, :3] += rng.normal(size=(3, 3, 4))
    matrices[2, 0, :3] *= -np.sign(np.linalg.det(matrices[2, :3, :3]))
    together = packed(meshes, matrices)
    for k, mesh in enumerate(meshes):
        alone = packed([mesh], matrices[k : k + 1])
        v, i, c = (slice(ends[k - 1] if k else 0, ends[k]) for ends in (together.vertex_ends, together.index_ends, together.cluster_ends))
        assert np.array_equal(together.positions[v], alone.positions) and np.array_equal(together.normals[v], alone.normals)
        assert np.array_equal(together.triangles[i.start // 3 : i.stop // 3] - v.start, alone.triangles)
        assert np.array_equal(together.bounds[c], alone.bounds) and np.array_equal(together.longest_edges[c], alone.longest_edges)
        world = mesh.positions.astype(float) @ matrices[k, :3, :3].T + matrices[k, :3, 3]
        assert np.allclose(alone.positions, world, rtol=1e-6, atol=1e-6)
        corners = alone.positions[mesh.triangles].astype(float)
        assert np.allclose(alone.bounds[0], [alone.positions.min(axis=0), alone.positions.max(axis=0)])
        assert np.isclose(alone.longest_edges.max(), np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(), rtol=1e-5)
        flipped = np.linalg.det(matrices[k, :3, :3]) < 0.0
        assert np.array_equal(alone.triangles, mesh.triangles[:, [0, 2, 1]] if flipped else mesh.triangles)


def test_a_part_that_is_mirrored_where_it_stands_shows_its_outside(worker):
    one, other = boxes(3), boxes(3)
    matrices = np.array(other.instances.world_from_object)
    matrices[1, 0, 0] = -1.0
    other = replace(other, instances=replace(other.instances, world_from_object=matrices))

    def measured(context):
        store, volumes = GeometryStore(context), []
        for scene in (one, other, one):
            ranges = store.sync(scene).ranges
            pool, points = np.frombuffer(store.indices.read(), np.uint32), np.frombuffer(store.positions.read(), np.float32).reshape(-1, 3)
            corners = [points[pool[f : f + c]].reshape(-1, 3, 3).astype(float) for f, c in zip(ranges.first, ranges.count, strict=True)]
            volumes.append([float(np.linalg.det(c - c[0, 0]).sum()) for c in corners])
        store.release()
        return volumes

    assert np.array(worker.call(measured)).min() > 0.0


def test_what_is_noted_of_moved_parts_is_what_a_new_upload_notes(worker):
    """Also of meshes of several clusters, and of those placed often."""
    parts = (
        scenes.ball((0.0, 0.0, 0.0), 0.4, 120, 60),
        scenes.box((0.0, 0.0, 0.0), (0.4, 0.4, 0.4)),
        scenes.ball((0.0, 0.0, 0.0), 0.3, 120, 60),
    )
    meshes = [Mesh(("part", i), p, np.tile([0.0, 0.0, 1.0], (len(p), 1)), t) for i, (p, t) in enumerate(parts)]
    index = np.array([0, 1, 2, 0, 1])
    placed = np.tile(np.eye(4), (5, 1, 1))
    placed[:, 0, 3] = np.arange(5)
    moved = placed.copy()
    moved[[0, 3], 1, 3] = 2.0
    moved[2, 0, 0] = -1.0
    rows = [Instances(index, m, np.arange(5), np.zeros(5), np.ones((5, 4))) for m in (placed, moved)]
    before, after = (Scene(tuple(meshes), r, tuple("abcde"), np.zeros(3)) for r in rows)

    def noted(context):
        kept, fresh = GeometryStore(context), GeometryStore(context)
        kept.sync(before)
        lists = kept.sync(after), fresh.sync(after)
        out = [(by_row(drawn.ranges), drawn.longest_edge_m, [g.front for g in drawn.groups]) for drawn in lists]
        kept.release()
        fresh.release()
        return out

    def by_row(ranges):
        order = np.lexsort((ranges.start, ranges.rows))
        return [getattr(ranges, name)[order].tolist() for name in ("rows", "start", "bounds_ws", "wholes_ws", "longest_edge_m")]

    kept, new = worker.call(noted)
    assert kept == new and len(kept[0][0]) == 4 and len(kept[2]) == 1


def test_what_is_placed_often_is_not_drawn_along_where_it_lies_in_the_pool(worker, monkeypatch):
    """Meshes of either kind that come later lie between those of before."""
    monkeypatch.setattr("addon.pipeline.geometry.parts.BAKE_TRIANGLES", 20)
    base = boxes(12)

    def scene(index):
        placed = np.tile(np.eye(4), (len(index), 1, 1))
        placed[:, 0, 3] = np.arange(len(index))
        rows = Instances(np.array(index), placed, np.arange(len(index)), np.zeros(len(index)), np.ones((len(index), 4)))
        return Scene(base.meshes, rows, tuple(map(str, range(len(index)))), np.zeros(3))

    steps = [[0, 1], [0, 1, 2, 2, 2], [0, 1, 2, 2, 2, 3], [0, 1, 2, 2, 2, 3, 4, 4, 4, 5]]

    def covered(context):
        store = GeometryStore(context)
        drawn = [store.sync(scene(index)) for index in steps][-1]
        calls = runs(np.ones(len(drawn.ranges.first), bool), drawn.ranges.first, drawn.ranges.count, drawn.barriers, 3072)
        groups = [(group.first_index, group.first_index + group.index_count) for group in drawn.groups]
        store.release()
        return calls, groups, int(drawn.ranges.first.max())

    calls, groups, last = worker.call(covered)
    assert len(groups) == 2 and min(groups)[0] < last, "an instanced mesh lies before a baked one"
    assert all(stop <= first or first + count <= start for first, count in calls for start, stop in groups)
