"""Places on surfaces: on them, evenly, for every object."""

from dataclasses import replace

import numpy as np

from addon.scene.looks import HIDDEN
from addon.studies.surface_samples import surface_samples
from tests import scenes
from tests.margins import agree, at_most


def test_places_lie_on_the_surface_of_their_object():
    found = surface_samples(scenes.closed_box(), total=4000)
    floor, box = (found.points_ws[found.object_id == i] for i in (0, 1))
    agree(floor[:, 2], 0.0, abs=1e-12)
    on = np.minimum(np.abs(np.abs(box[:, :2]) - 1.0).min(axis=1), np.minimum(np.abs(box[:, 2]), np.abs(box[:, 2] - 2.0)))
    at_most(on, 1e-9)
    agree(np.linalg.norm(found.normals_ws, axis=1), 1.0, abs=1e-12)


def test_areas_are_those_of_the_objects_and_places_stand_for_equal_ones():
    found = surface_samples(scenes.closed_box(), total=4000)
    agree(found.areas, [400.0, 24.0], rel=1e-9)
    box = found.points_ws[found.object_id == 1]
    agree((box[:, 2] > 1.999).mean(), 4.0 / 24.0, abs=0.01)
    floor = found.points_ws[found.object_id == 0]
    at_most(np.abs(floor[:, :2].mean(axis=0)), 0.1)
    agree(((floor[:, :2] > 0.0).all(axis=1)).mean(), 0.25, abs=0.02)


def test_the_smallest_object_has_its_least_number():
    found = surface_samples(scenes.closed_box(), least=50, total=100)
    assert (np.bincount(found.object_id) >= 50).all()


def test_what_is_hidden_has_no_places():
    scene = scenes.closed_box()
    hidden = replace(scene, instances=replace(scene.instances, flags=np.array([0, HIDDEN], np.uint8)))
    found = surface_samples(hidden, total=500)
    assert set(found.object_id) == {0} and found.areas[1] == 0.0
