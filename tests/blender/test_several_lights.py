"""Several lights of a Blender scene, and lights with a size, with Cycles as the judge."""

import importlib
import math

import bpy
import numpy as np
import pytest

from tests.blender import judge

pytestmark = pytest.mark.usefixtures("blend")


def soft_cycles(scene, path, samples=512):
    """Cycles with that many samples a pixel, all at its centre; (h, w, 3)."""
    return judge.cycles(scene, path, samples)[..., :3]


def stage():
    scene = judge.empty_scene(96, 72)
    paint = judge.diffuse((0.7, 0.7, 0.7))
    judge.plate(paint=paint)
    judge.box(paint=paint)
    judge.camera((7.0, -7.0, 6.0))
    return scene


LAMPS = {
    "sun": lambda: setattr(judge.sun((2.0, 1.5, 2.0), 3.0).data, "angle", math.radians(12.0)),
    "point": lambda: judge.lamp("POINT", (2.5, 3.0, 4.0), 1500.0, shadow_soft_size=0.5),
    "spot": lambda: judge.lamp("SPOT", (3.0, -2.0, 5.0), 2500.0, shadow_soft_size=0.4, spot_size=1.2, spot_blend=0.3),
    "square": lambda: judge.lamp("AREA", (3.0, -2.0, 4.0), 900.0, shape="SQUARE", size=1.2),
    "rectangle": lambda: judge.lamp("AREA", (3.0, -2.0, 4.0), 900.0, shape="RECTANGLE", size=2.0, size_y=0.4),
    "disk": lambda: judge.lamp("AREA", (3.0, -2.0, 4.0), 900.0, shape="DISK", size=1.5),
    "ellipse": lambda: judge.lamp("AREA", (3.0, -2.0, 4.0), 900.0, shape="ELLIPSE", size=0.5, size_y=2.0),
    "narrowed": lambda: judge.lamp("AREA", (3.0, -2.0, 4.0), 900.0, shape="SQUARE", size=1.2, spread=math.radians(90.0)),
}


@pytest.mark.parametrize("kind", LAMPS)
def test_a_light_with_a_size_is_like_cycles(tmp_path, kind):
    scene = stage()
    LAMPS[kind]()
    mine, theirs = judge.ours(scene, light_samples=96, map_size=512)[0][..., :3], soft_cycles(scene, tmp_path)
    hard = judge.ours(scene, map_size=512)[0][..., :3]
    assert rms_inside(mine, theirs) < 0.012
    assert rms_inside(hard, theirs) > 1.1 * rms_inside(mine, theirs)


def rms_inside(mine, theirs):
    """Without the 2 % of the pixels that differ most, where an object's outline passes through the centre."""
    off = np.sort(np.abs(mine - theirs).max(axis=-1).ravel()) / theirs.max()
    return np.sqrt((off[: int(0.98 * len(off))] ** 2).mean())


def test_all_lights_of_a_scene_are_like_cycles(tmp_path):
    scene = stage()
    judge.sun((1.0, -1.0, 2.0), 1.0)
    judge.lamp("POINT", (-2.0, -3.0, 4.0), 800.0)
    judge.lamp("SPOT", (3.0, 2.0, 5.0), 900.0, spot_size=0.8, spot_blend=0.2)
    mine, theirs = judge.ours(scene)[0][..., :3], soft_cycles(scene, tmp_path, 1024)  # a sample of Cycles asks one light
    assert rms_inside(mine, theirs) < 0.02
    one, warnings = judge.ours(scene, lights="one")
    assert any("2 other lights left out" in line for line in warnings)
    assert (one[..., :3] <= mine + 1e-4).all() and (one[..., :3] < mine - 0.02).any()


def test_lights_named_are_the_only_ones():
    scene = stage()
    sun = judge.sun((1.0, -1.0, 2.0), 1.0)
    judge.lamp("POINT", (-2.0, -3.0, 4.0), 800.0)
    judge.lamp("SPOT", (3.0, 2.0, 5.0), 900.0)
    both = judge.ours(scene, light=["POINT", sun.name])[0]
    each = [judge.ours(scene, light=name)[0] for name in ("POINT", sun.name)]
    black = judge.ours(scene, light="POINT", light_strength=0.0)[0]
    assert np.abs(both - (each[0] + each[1] - black))[..., :3].max() < 1e-4


def test_a_light_that_reaches_nothing_costs_nothing_and_changes_nothing():
    scene = stage()
    judge.sun((1.0, -1.0, 2.0), 1.0)
    alone = judge.ours(scene)[0]
    judge.lamp("POINT", (500.0, 0.0, 4.0), 10.0)
    api = importlib.import_module("bl_ext.user_default.cad_shadow_preview.addon.api")
    result = api.preview(scene, samples=1)
    assert np.array_equal(result.combined, alone)
    assert result.outcome.job.others == ()


@pytest.mark.parametrize("kind", ["sun", "point", "square"])
def test_hard_shadows_of_a_soft_light_are_said_and_soft_ones_are_not(kind):
    scene = stage()
    LAMPS[kind]()
    assert any("Light Samples" in line for line in judge.ours(scene)[1])
    assert not any("Light Samples" in line for line in judge.ours(scene, light_samples=2)[1])


def test_a_light_linked_to_others_lights_those_alone_among_several(tmp_path):
    scene = stage()
    judge.sun((1.0, -1.0, 2.0), 1.0)
    lamp = judge.lamp("POINT", (-3.0, -3.0, 4.0), 900.0)
    inside = bpy.data.collections.new("receivers")
    inside.objects.link(scene.objects["box"])
    lamp.light_linking.receiver_collection = inside
    mine, theirs = judge.ours(scene)[0][..., :3], judge.cycles(scene, tmp_path)[..., :3]
    assert np.percentile(np.abs(mine - theirs).max(axis=-1) / theirs.max(), 98) < 0.02


def test_scenes_of_older_versions_keep_their_one_light(room):
    properties = room("blender.properties")
    scene = bpy.context.scene
    properties.migrate()
    assert scene.cad_shadow.lights == "all", "a new scene"
    scene.cad_shadow.settings_version = 2
    properties.migrate()
    assert (scene.cad_shadow.lights, scene.cad_shadow.settings_version) == ("one", properties.SETTINGS_VERSION)
