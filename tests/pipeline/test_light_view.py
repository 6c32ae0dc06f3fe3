"""The light's view frames the maps and paints every surface in the colour of the map that serves it."""

from dataclasses import replace

import numpy as np
import pytest

from addon.images.passes import id_colors
from addon.maths.shadow.lookup import partition_index
from addon.maths.spaces import divide, transform
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.light_view import light_camera, light_picture
from addon.studies.map_outlines import map_color, map_volumes
from addon.studies.run import run
from addon.studies.run import stop_worker as stop_shared_worker
from tests import scenes

SIZE = (480, 360)
CAMERA = scenes.look_at((0.0, -4.0, 3.0), (0.0, 60.0, 0.0), near=0.5, far=90.0)
LIGHTS = {
    "sun": scenes.sun(55.0),
    "spot": Light("spot", np.array([0.0, 0.0, 1.0]), np.array([1.0, 30.0, 40.0])),
    "point": Light("point", None, np.array([3.0, 20.0, 15.0])),
}


@pytest.fixture(scope="module", autouse=True)
def worker_closed():
    yield
    stop_shared_worker()


def job_and_plan(kind, **choices):
    job = Job(scenes.border_floor(80.0, 10), CAMERA, LIGHTS[kind], Settings().replaced(fit={"size": 128}, **choices), (160, 90))
    return job, run(replace(job, passes=("depth",), measure=False)).frame.plan


@pytest.mark.parametrize("warp", ["lispsm-general", "logpsm"])
def test_the_suns_view_looks_along_the_light_and_holds_all_maps(warp):
    job, plan = job_and_plan("sun", warp={"kind": warp})
    eye = light_camera(job, plan, SIZE[0] / SIZE[1])
    assert eye.is_orthographic
    assert np.allclose(eye.direction_ws, -job.light.direction_ws)
    corners = np.concatenate([segments.reshape(-1, 3) for _, segments in map_volumes(plan)])
    assert (np.abs(divide(transform(eye.clip_from_world, corners))) <= 1.0).all()


@pytest.mark.parametrize("kind", ["sun", "spot", "point"])
def test_surfaces_wear_the_colour_of_their_map(kind):
    """On the floor straight below the light the shade is one factor: the hue must be the map's own."""
    job, plan = job_and_plan(kind)
    image = light_picture(job, plan, SIZE).astype(float)
    eye = light_camera(job, plan, SIZE[0] / SIZE[1])
    floor = np.stack(np.meshgrid(np.linspace(-18.0, 18.0, 19), np.linspace(1.0, 78.0, 60), [0.0]), axis=-1).reshape(-1, 3)
    clip = transform(job.camera.clip_from_world, floor)
    floor = floor[(np.abs(clip[:, :3]) < 0.97 * clip[:, 3:]).all(axis=1)]
    index = partition_index(plan, job.camera, floor)
    seen = transform(eye.clip_from_world, floor)
    ndc = divide(seen)
    framed = (np.abs(ndc[:, :2]) < 0.99).all(axis=1) & (seen[:, 3] > 0.0) & (index >= 0)
    column, row = ((ndc[framed, 0] + 1) * SIZE[0] / 2).astype(int), ((1 - ndc[framed, 1]) * SIZE[1] / 2).astype(int)
    got, wanted = image[row, column], id_colors(index[framed]).astype(float)
    cosine = (got * wanted).sum(axis=1) / np.linalg.norm(got, axis=1) / np.linalg.norm(wanted, axis=1)
    assert framed.sum() > 20
    assert len(np.unique(index[framed])) > 1
    assert (cosine > 0.999).mean() > 0.75  # the rest lies under an outline, a post, or at a border


def test_every_used_map_is_outlined():
    job, plan = job_and_plan("sun")
    image = light_picture(job, plan, SIZE)
    for index, _ in map_volumes(plan):
        ink = np.rint(255 * np.array(map_color(index))).astype(np.uint8)
        assert (image == ink).all(axis=-1).sum() > 10
