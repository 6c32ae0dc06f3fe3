"""Lights as Blender means them: which one is chosen, how strong it is and what it lights, with Cycles as the judge."""

import math

import numpy as np
import pytest

from tests.blender import judge

pytestmark = pytest.mark.usefixtures("blend")


def lit_floor(**camera):
    """A white floor seen straight from above, 12 m wide."""
    scene = judge.empty_scene(60, 60)
    judge.plate(60.0, paint=judge.diffuse((0.8, 0.8, 0.8)))
    judge.camera((0.0, 0.0, 30.0), type="ORTHO", ortho_scale=12.0, **camera)
    return scene


def assert_like_cycles(scene, path, within=0.02):
    mine, theirs = judge.ours(scene)[0][..., :3], judge.cycles(scene, path)[..., :3]
    off = np.abs(mine - theirs).max(axis=-1) / theirs.max()
    assert np.percentile(off, 98) < within, f"{mine[30, 30]} against {theirs[30, 30]}, {mine[30, 10]} against {theirs[30, 10]}"


@pytest.mark.parametrize("spread", [180.0, 120.0, 60.0, 20.0])
def test_a_small_panel_is_as_strong_as_in_cycles_at_every_spread(tmp_path, spread):
    scene = lit_floor()
    judge.lamp("AREA", (1.0, 0.5, 4.0), 500.0, (0.0, 1.0, 0.0), size=0.02, spread=math.radians(spread))
    assert_like_cycles(scene, tmp_path)


def test_a_panel_turned_away_lights_nothing(tmp_path):
    scene = lit_floor()
    judge.lamp("AREA", (0.0, 0.0, 4.0), 500.0, (0.0, 0.1, 9.0), size=0.02)
    scene.cad_shadow.light_source, scene.cad_shadow["light"] = "AUTOMATIC", None
    assert judge.ours(scene, light="AREA")[0][..., 0].max() == 0.0


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 1.0, 1.0), (0.5, 1.5, 1.0), (1.0, 1.0, 2.0)])
@pytest.mark.parametrize("blend", [0.0, 0.5])
def test_a_scaled_spot_has_the_ellipse_of_cycles(tmp_path, scale, blend):
    scene = lit_floor()
    lamp = judge.lamp("SPOT", (0.5, 0.0, 5.0), 800.0, (0.0, 0.3, 0.0), spot_size=math.radians(50.0), spot_blend=blend)
    lamp.scale = scale
    mine, theirs = judge.ours(scene)[0][..., 0], judge.cycles(scene, tmp_path)[..., 0]
    assert (np.abs(mine - theirs) > 0.03 * theirs.max()).mean() < 0.01


def test_the_shadow_pass_is_dark_outside_a_cone_and_one_within_however_far_the_lamp():
    scene = lit_floor()
    judge.lamp("SPOT", (0.0, 0.0, 20.0), 800.0, (0.0, 0.001, 0.0), spot_size=math.radians(20.0))
    import importlib

    api = importlib.import_module("bl_ext.user_default.cad_shadow_preview.addon.api")
    result = api.preview(scene, samples=1, display="shadow", light="SPOT")
    shadow = result.passes["shadow"]
    assert shadow[30, 30] == 1.0
    assert shadow[2, 2] == 0.0
    assert np.allclose(result.combined[..., 0], shadow), "Show: Shadow is the pass"


def test_a_light_without_shadow_shines_through_everything(tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    scene.objects["Sun"].data.use_shadow = False
    assert judge.apart(scene, tmp_path)[0] < 0.01


def linked(bpy, scene, kind, names, state="INCLUDE"):
    inside = bpy.data.collections.new(kind)
    for name in names:
        inside.objects.link(scene.objects[name])
    setattr(scene.objects["Sun"].light_linking, f"{kind}_collection", inside)
    for one in inside.collection_objects:
        one.light_linking.link_state = state


@pytest.mark.parametrize("state", ["INCLUDE", "EXCLUDE"])
@pytest.mark.parametrize("kind", ["receiver", "blocker"])
def test_linked_lights_light_and_are_blocked_by_whom_they_should(blend, tmp_path, kind, state):
    scene = judge.standard_scene(judge.diffuse)
    linked(blend, scene, kind, ["box"], state)
    mine, theirs = judge.ours(scene)[0], judge.cycles(scene, tmp_path)
    assert theirs[..., 0].max() > 0.1
    assert (np.abs(mine - theirs).max(axis=-1) > 0.02).mean() < 0.012


def chosen(scene):
    import importlib

    api = importlib.import_module("bl_ext.user_default.cad_shadow_preview.addon.api")
    return api.preview(scene, samples=1, size=(16, 16)).light.name


def test_a_dead_sun_does_not_win():
    scene = lit_floor()
    judge.sun(energy=0.0)
    judge.lamp("POINT", (0.0, 0.0, 3.0), 3000.0)
    assert chosen(scene) == "POINT"


@pytest.mark.parametrize("site", [100.0, 400.0, 10000.0])
def test_a_lamp_lights_its_room_however_large_the_site_is(site):
    scene = judge.empty_scene()
    judge.plate(site, paint=judge.diffuse())
    for x in (-2.5, 2.5):
        wall = judge.plate(5.0, 0.0, judge.diffuse(), "wall")
        wall.rotation_euler, wall.location = (0.0, math.pi / 2, 0.0), (x, 0.0, 1.5)
    judge.lamp("POINT", (0.0, 0.0, 2.5), 150.0)
    judge.camera((0.0, -2.4, 1.6), (0.0, 2.0, 1.0), lens=20.0)
    assert chosen(scene) == "POINT"


def test_the_lamp_that_lights_what_is_seen_is_chosen():
    scene = lit_floor()
    judge.lamp("POINT", (200.0, 0.0, 3.0), 90000.0).name = "elsewhere"
    judge.lamp("POINT", (0.0, 0.0, 3.0), 300.0).name = "here"
    assert chosen(scene) == "here"


def test_blenders_light_panels_know_the_engine(room):
    names = {cls.__name__ for cls in room("blender.panels.compatible").fitting_panels()}
    assert {"DATA_PT_EEVEE_light", "EEVEE_WORLD_PT_surface", "WORLD_PT_context_world"} <= names
