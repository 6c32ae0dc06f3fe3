"""The bounds of a model are those of every vertex of every part shown, worked out once."""

import numpy as np
import pytest

from addon.scene import cad_model
from addon.scene.cad_model import CadMesh, CadModel, CadPart
from tests import scenes


def placed(turn, offset):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, offset
    return matrix


def a_turn(rng):
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return turn * rng.uniform(0.2, 3.0)


def model(rng, hidden=False):
    """Two meshes, one of them turned in two ways at three places each, a child among them."""
    ball, box = scenes.ball((1.0, 2.0, 0.0), 0.5), scenes.box((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    meshes = tuple(CadMesh(name, part[0].astype(np.float32), part[1].astype(np.int32)) for name, part in (("ball", ball), ("box", box)))
    turns = [a_turn(rng), a_turn(rng)]
    parts = [CadPart(f"ball {k}", -1, 0, placed(turns[k % 2], rng.normal(size=3) * 5.0)) for k in range(6)]
    parts += [CadPart("group", -1, -1, placed(a_turn(rng), rng.normal(size=3)))]
    parts += [CadPart("box", 6, 1, placed(a_turn(rng), rng.normal(size=3) * 9.0), is_hidden=hidden)]
    return CadModel("model", meshes, tuple(parts))


def corner_by_corner(made):
    points = [
        made.meshes[part.mesh].positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        for part, matrix in zip(made.parts, made.world_from_part(), strict=True)
        if part.mesh >= 0 and not part.is_hidden
    ]
    return np.stack([np.concatenate(points).min(axis=0), np.concatenate(points).max(axis=0)])


@pytest.mark.parametrize("hidden", [False, True])
def test_bounds_are_those_of_every_vertex(rng, hidden):
    for _ in range(10):
        made = model(rng, hidden)
        assert np.allclose(made.bounds(), corner_by_corner(made), rtol=1e-12, atol=1e-12)


def test_each_mesh_is_looked_at_once_for_every_way_it_is_turned(rng, monkeypatch):
    looked_at, linear = [], cad_model.linear

    def counted(matrix, columns):
        looked_at.append(columns.shape[1])
        return linear(matrix, columns)

    monkeypatch.setattr(cad_model, "linear", counted)
    made = model(rng)
    assert np.array_equal(made.bounds(), made.bounds())
    assert len(looked_at) == 3
