"""Coarser casters are made in a process of their own, whose end costs them alone."""

import threading
import time

import numpy as np
import pytest

from addon.pipeline.detail import kept, making
from tests import scenes


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """Nothing is kept in the user's cache."""
    monkeypatch.setattr(kept, "folder", lambda: tmp_path)
    monkeypatch.setattr(making, "PAYS_FROM", 1000)


@pytest.fixture
def maker():
    maker = making.CoarseMaker()
    yield maker
    maker.release()
    assert maker._process is None


def scene():
    return scenes.scene_of(scenes.floor(8.0), scenes.ball((0.0, 0.0, 1.0), 1.0, 40, 24))


def nothing():
    """Nobody gives up."""


def test_a_process_makes_them_and_they_are_kept(maker, tmp_path):
    asked = scene()
    assert maker.levels(asked) is None
    levels = maker.wait(asked, nothing)
    (own,) = levels.values()
    assert len(own[-1].triangles) < len(asked.meshes[1].triangles)
    assert len(list(tmp_path.glob("*.npz"))) == 1
    again = making.CoarseMaker()
    again._made_apart = None  # must not be asked
    (same,) = again.wait(scene(), nothing).values()
    assert all(np.array_equal(a.positions, b.positions) and a.error == b.error for a, b in zip(own, same, strict=True))
    again.release()


def test_a_process_that_ends_leaves_the_meshes_as_they_are(maker, monkeypatch):
    monkeypatch.setattr(making, "started", lambda *_, **streams: real("pipeline.detail.no_such_child", (), (), **streams))
    assert maker.wait(scene(), nothing) == {}


real = making.started


def test_waiting_can_be_given_up(maker, monkeypatch):
    hold = threading.Event()
    monkeypatch.setattr(making.CoarseMaker, "_made_apart", lambda self, mesh: hold.wait(20.0) and ())

    def give_up():
        raise InterruptedError

    with pytest.raises(InterruptedError):
        maker.wait(scene(), give_up)
    hold.set()


def test_small_meshes_and_small_scenes_are_not_looked_at(monkeypatch):
    assert [len(mesh.triangles) > 256 for mesh in making.wanted(scene())] == [True]
    monkeypatch.setattr(making, "PAYS_FROM", 100_000)
    assert making.wanted(scene()) == ()


def test_what_left_the_scene_is_forgotten(maker):
    maker.wait(scene(), nothing)
    time.sleep(0.01)
    assert maker.wait(scenes.scene_of(scenes.floor(8.0)), nothing) == {}
    assert maker._made == {}
