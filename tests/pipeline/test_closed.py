"""Back faces are left out of closed meshes only, and nobody sees the difference."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.spaces import orthographic
from addon.pipeline.geometry import parts, store
from addon.pipeline.geometry.closed import closed_meshes
from addon.pipeline.geometry.culling import Culling
from addon.pipeline.gl.context import GpuWorker
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.scene.records import Instances, Mesh
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes

BOX = scenes.box((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
PASSES = ("object", "depth", "shadow", "texel")


def mesh(part, key="mesh"):
    positions, triangles = part
    return Mesh(key, positions, np.zeros_like(positions), triangles)


def ball(centre, radius):
    """A sphere whose poles are one point each."""
    positions, triangles = scenes.ball(centre, radius)
    return np.round(positions, 6), triangles


def turned_over(part):
    return part[0], part[1][:, ::-1]


def two_sided(part):
    """Every triangle followed by itself wound the other way."""
    return part[0], np.stack([part[1], part[1][:, ::-1]], axis=1).reshape(-1, 3)


def hourglass():
    """A closed prism whose outline crosses itself: one half is wound inwards, and together they enclose nothing."""
    outline = np.array([(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)])
    middle = np.array([[1.0, 1.0]])
    points = np.concatenate([np.column_stack([np.concatenate([outline, middle]), np.full(5, z)]) for z in (0.0, 1.0)])
    sides = [(i, (i + 1) % 4, 5 + (i + 1) % 4, 5 + i) for i in range(4)]
    walls = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    caps = [t for i in range(4) for t in (((i + 1) % 4, i, 4), (5 + i, 5 + (i + 1) % 4, 9))]
    return points, np.array(walls + caps)


HOURGLASS = hourglass()


def without(part, *faces):
    return part[0], np.delete(part[1], faces, axis=0)


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        (BOX, True),
        (ball((0.0, 0.0, 0.0), 1.0), True),
        (scenes.joined(BOX, ball((0.5, 1.0, 1.5), 9.0), scenes.box((5.0, 5.0, 5.0), (6.0, 6.0, 6.0))), True),
        (scenes.floor(), False),
        (scenes.rod((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), 0.1), False),
        (without(BOX, 3), False),
        (turned_over(BOX), False),
        (scenes.joined(BOX, turned_over(scenes.box((5.0, 5.0, 5.0), (6.0, 6.0, 6.0)))), False),
        (scenes.joined(ball((0.0, 0.0, 0.0), 9.0), turned_over(BOX)), False),
        ((BOX[0], np.concatenate([BOX[1][:1, ::-1], BOX[1][1:]])), False),  # one face wound the other way
        (scenes.joined(scenes.floor(), turned_over(scenes.floor())), True),  # a sheet's two sides
        (two_sided(scenes.rod((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), 0.1)), True),
        (scenes.joined(BOX, two_sided(scenes.rod((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), 0.1))), True),
        (joined_flat := scenes.joined(scenes.floor(), (scenes.floor()[0], np.array([[0, 3, 1], [1, 3, 2]]))), True),  # cut the other way
        (scenes.joined(BOX, joined_flat), True),
        (HOURGLASS, False),
        (scenes.joined(without(BOX, 0), without(turned_over(BOX), 1)), False),
    ],
)
def test_a_mesh_is_closed_when_every_shell_of_it_is_wound_outwards(part, expected):
    assert closed_meshes([mesh(part)]).tolist() == [expected]


def test_meshes_looked_at_together_are_what_they_are_alone(rng):
    parts = [BOX, scenes.floor(), turned_over(BOX), ball((1.0, 0.0, 0.0), 0.3), without(BOX, 2), BOX]
    chosen = [mesh(parts[i], i) for i in rng.integers(0, len(parts), 40)]
    assert closed_meshes(chosen).tolist() == [bool(closed_meshes([one])[0]) for one in chosen]
    assert closed_meshes([]).tolist() == []


def test_the_order_of_triangles_and_where_zero_has_a_sign_do_not_matter(rng):
    positions, triangles = BOX
    positions = np.where((positions == 0.0) & (rng.random(positions.shape) < 0.5), -0.0, positions)
    assert closed_meshes([mesh((positions, rng.permutation(triangles)))]).tolist() == [True]


def mirrored(x=0.0):
    matrix = np.diag([-1.0, 1.0, 1.0, 1.0])
    matrix[0, 3] = x
    return matrix


def many(part, matrices):
    """One mesh, placed often, on a floor."""
    base = scenes.scene_of(part, scenes.floor())
    placed = np.concatenate([matrices, np.eye(4)[None]])
    ids = np.arange(len(placed))
    index = np.append(np.zeros(len(matrices), np.int32), 1)
    rows = Instances(index, placed, ids, np.zeros(len(ids)), np.tile([0.5, 0.4, 0.3, 1.0], (len(ids), 1)))
    return replace(base, instances=rows, object_names=tuple(map(str, ids)))


def shifts(*places):
    out = np.tile(np.eye(4), (len(places), 1, 1))
    out[:, :3, 3] = places
    return out


SCENES = {
    "solids and sheets": scenes.staircase(),
    "mirrored": many(
        scenes.joined(BOX, scenes.box((1.0, 0.5, 1.0), (1.6, 0.7, 1.2))), np.stack([np.eye(4), mirrored(-1.0), mirrored(-4.0)])
    ),
    "a shell inside out": scenes.scene_of(scenes.joined(BOX, turned_over(scenes.box((2.0, 0.0, 0.0), (3.0, 1.0, 1.0)))), scenes.floor()),
    "a ball": scenes.scene_of(ball((0.0, 0.0, 1.5), 1.5), scenes.floor()),
}
EYES = {
    "outside": scenes.look_at((9.0, -11.0, 6.0), (0.0, 0.0, 1.0), fov_y_deg=40.0, near=0.5, far=80.0),
    "cut open": scenes.look_at((6.0, -8.0, 5.0), (0.0, 0.0, 1.0), fov_y_deg=40.0, near=10.0, far=80.0),
    "inside": scenes.look_at((0.5, 0.8, 0.7), (-4.0, 3.0, 0.2), fov_y_deg=70.0, near=0.01, far=80.0),
}
EYES["parallel"] = replace(EYES["outside"], clip_from_view=orthographic(4.0, 3.0, 0.5, 80.0))


def drawn(scene, camera, chosen):
    renderer = Renderer(GpuWorker())
    try:
        return run(Job(scene, camera, scenes.sun(40.0), chosen, (160, 120), PASSES), on=renderer).frame
    finally:
        renderer.worker.close()


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("kind", SCENES)
def test_pictures_and_maps_are_those_with_all_faces_drawn(monkeypatch, kind, eye):
    """But where a silhouette passes exactly through a pixel's centre and front and back meet there."""
    counted = []
    allows = Culling.allows
    monkeypatch.setattr(Culling, "allows", lambda *a: (lambda out: (counted.append(out.sum()), out)[1])(allows(*a)))
    chosen = Settings().replaced(
        partition={"kind": "none"}, fit={"size": 128}, warp={"kind": "uniform" if eye == "parallel" else "lispsm-general"}
    )
    for bake in (0, 10**9):
        monkeypatch.setattr(parts, "BAKE_TRIANGLES", bake)
        culled = drawn(SCENES[kind], EYES[eye], chosen)
        with monkeypatch.context() as whole:
            whole.setattr(store, "closed_meshes", lambda meshes: np.zeros(len(meshes), bool))
            plain = drawn(SCENES[kind], EYES[eye], chosen)
        for name in (*PASSES[:-1], "shadow_depth"):
            a, b = (np.nan_to_num(frame.passes[name].astype(float), posinf=0.0) for frame in (culled, plain))
            assert np.mean(np.abs(a - b) > 1e-4 * np.abs(b)) < 1e-3, (name, bake)
    assert eye != "outside" or kind == "a shell inside out" or sum(counted) > 0


def test_winding_follows_the_projection():
    camera = EYES["outside"].clip_from_world
    assert Culling.by(camera, near=True).front == "ccw"
    assert Culling.by(np.diag([-1.0, 1.0, 1.0, 1.0]) @ camera, near=True).front == "cw"
    assert Culling.by(camera, near=True).allows(np.array([[[-1.0, -1, 0], [1, 1, 2]], [[5, -20, 0], [30, 30, 9]]])).tolist() == [
        True,
        False,
    ]
