"""What impostors show is what the view ray really meets near what a texel names: its place, normal, shadows and outline."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.relief.life import LifeModel
from addon.maths.relief.settings import ImpostorSettings
from addon.maths.view import Light
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.job import Job
from addon.scene.records import Instances, Mesh, Scene
from addon.settings.groups import TESTS, Settings
from addon.studies.run import run
from tests import scenes
from tests.pipeline.test_impostor_draw import orbit

SIZE = (112, 63)
PASSES = ("combined", "shadow", "normal", "object", "depth")
SUN = scenes.sun(50.0)
FOREVER = ImpostorSettings(limit=1e9, ahead=0.0, break_even=False), LifeModel(finest=np.inf)
PLAIN = Settings().replaced(fit={"kind": "scene", "size": 1024}, partition={"kind": "none"}, shading={"samples": 1})
KNOBBLY = (
    scenes.ball((0.3, -0.3, 0.6), 0.4, 160, 80),
    scenes.ball((-0.4, 0.1, 0.3), 0.3, 40, 20),
    scenes.rod((-0.5, 0.6, 0.0), (-0.5, 0.6, 1.1), 0.2, 64),
    scenes.box((-0.9, -0.8, -0.1), (0.9, 0.9, 0.0)),
)


def whole(scene: Scene, without: int = 0) -> ImpostorChoice:
    """All objects but the last `without` as one impostor."""
    objects = tuple(range(len(scene.object_names) - without))
    return ImpostorChoice((ImpostorGroup("all", objects),), *FOREVER)


@pytest.fixture
def pictures(renderer):
    """Passes of a scene as geometry and as one impostor captured from the first of the cameras, seen from the last."""

    def drawn(scene, *cameras, test="triangle", light=SUN, without=0):
        settings = PLAIN.replaced(test={"kind": test})
        out = []
        for choice in (None, whole(scene, without)):
            for camera in cameras:
                frame = run(Job(scene, camera, light, settings, SIZE, PASSES, measure=False, impostors=choice), on=renderer).frame
            assert choice is None or frame.impostors[0].stage in ("regenerated", "sprite", "warp")
            out.append(frame.passes)
        return out

    return drawn


def seen_in_both(*passes):
    return np.logical_and(*(p["object"] >= 0 for p in passes))


@pytest.mark.parametrize("test", TESTS)
def test_at_the_captures_eye_an_impostor_has_the_shadows_of_the_geometry(pictures, test):
    true, shown = pictures(scenes.scene_of(*KNOBBLY), orbit(0.3), test=test)
    both = seen_in_both(true, shown)
    assert both.sum() > 1000
    assert np.mean(np.abs(true["shadow"] - shown["shadow"])[both] > 0.5) <= 1e-3


@pytest.mark.parametrize("camera", [orbit(0.36), orbit(0.3, distance=4.0), orbit(0.3, distance=8.0)])
def test_a_ball_alone_casts_no_shadow_on_its_lit_side_from_other_eyes(pictures, camera):
    """It is convex: what faces the light is lit."""
    scene = scenes.scene_of(scenes.ball((0.0, 0.0, 0.5), 0.8, 160, 80))
    true, shown = pictures(scene, orbit(0.3), camera)
    faces = (shown["normal"] @ np.asarray(SUN.direction_ws) > 0.05) & seen_in_both(true, shown)
    assert faces.sum() > 400
    assert np.mean(shown["shadow"][faces] < 0.5) <= 1e-3


def test_a_lamp_lights_an_impostor_as_it_lights_the_geometry(pictures):
    lamp = Light("point", position_ws=np.array([-1.5, -3.0, 2.5]), color=(30.0, 30.0, 30.0))
    true, shown = pictures(scenes.scene_of(*KNOBBLY), orbit(0.3), light=lamp)
    both = seen_in_both(true, shown)
    assert np.mean(np.abs(true["shadow"] - shown["shadow"])[both] > 0.5) <= 1e-3


@pytest.mark.parametrize("camera", [orbit(0.32), orbit(0.3, distance=4.0), orbit(0.3, distance=7.0), orbit(0.3, height=0.43)])
def test_outlines_and_depths_are_the_geometrys_after_the_eye_has_moved_a_little(pictures, camera):
    true, shown = pictures(scenes.scene_of(*KNOBBLY), orbit(0.3), camera)
    both = seen_in_both(true, shown)
    assert ((true["object"] >= 0) != (shown["object"] >= 0)).sum() <= 0.004 * both.sum()
    assert (true["object"] != shown["object"])[both].sum() <= 0.01 * both.sum()
    apart = np.abs(true["depth"][both] - shown["depth"][both])
    assert np.quantile(apart, 0.97) < 1e-4
    assert -10.0 * np.log10(np.mean((true["combined"] - shown["combined"])[..., :3] ** 2)) > 35.0


@pytest.mark.parametrize("light", [SUN, None])
def test_geometry_beside_an_impostor_is_drawn_as_without_it(pictures, light):
    """A ground of 20 km, whose triangles float32 does not hold."""
    scene = scenes.scene_of(*KNOBBLY[:3], scenes.floor(2e4))
    true, shown = pictures(scene, orbit(0.3), orbit(0.33), light=light, without=1)
    ground = (true["object"] == 3) & (shown["object"] == 3)
    assert ground.sum() > 1000
    for name in ("normal", "depth"):
        np.testing.assert_array_equal(true[name][ground], shown[name][ground])
    assert np.mean(np.abs(true["combined"] - shown["combined"])[ground] > 1e-6) < 2e-3
    other = true["object"] < 0
    np.testing.assert_array_equal(true["combined"][other & (shown["object"] < 0)], shown["combined"][other & (shown["object"] < 0)])


def smooth_ball() -> Mesh:
    """Welded, with normals of its own at the vertices."""
    positions, triangles = scenes.ball((0.0, 0.0, 0.0), 1.0, 24, 12)
    return Mesh(("smooth ball",), positions, positions, triangles)


def test_a_mirrored_unevenly_scaled_impostor_is_shaded_with_the_normals_of_its_triangles(pictures):
    mesh = smooth_ball()
    placed = np.stack([np.diag([-0.6, 0.4, 0.5, 1.0]), np.diag([0.3, 0.3, 0.3, 1.0])])
    placed[0, :3, 3], placed[1, :3, 3] = (0.1, 0.0, 0.6), (-0.5, -0.5, 0.2)
    instances = Instances(np.zeros(2, int), placed, np.arange(2), np.zeros(2, int), np.tile([0.6, 0.6, 0.6, 1.0], (2, 1)))
    scene = Scene((mesh,), instances, ("a", "b"), np.zeros(3))
    true, shown = pictures(scene, orbit(0.3))
    both = seen_in_both(true, shown)
    turned = np.degrees(np.arccos(np.clip((true["normal"] * shown["normal"]).sum(axis=-1)[both], -1.0, 1.0)))
    assert np.quantile(turned, 0.98) < 0.5


def test_a_surface_of_unlinked_triangles_still_receives_its_shadows_near_where_it_is_seen(pictures):
    """Every third triangle has a fin on one of its edges: there the triangle across is not to be told."""
    positions, triangles = scenes.ball((0.0, 0.0, 0.5), 0.8, 64, 32)
    fins = np.stack([triangles[::3, 0], triangles[::3, 1], len(positions) + np.arange(len(triangles[::3]))], axis=1)
    outwards = 1.0005 * (positions[triangles[::3, 0]] - [0.0, 0.0, 0.5]) + [0.0, 0.0, 0.5]
    scene = scenes.scene_of((np.concatenate([positions, outwards]), np.concatenate([triangles, fins])))
    true, shown = pictures(scene, orbit(0.3))
    both = seen_in_both(true, shown)
    assert np.mean(np.abs(true["shadow"] - shown["shadow"])[both] > 0.5) <= 0.02


def test_frames_whose_impostors_are_all_geometry_are_shaded_as_without(renderer):
    scene = scenes.scene_of(*KNOBBLY)
    dear = replace(whole(scene), settings=replace(FOREVER[0], break_even=True), triangle_ns=1e-6, pixel_ns=1e6)
    passes = [
        run(Job(scene, orbit(0.3), SUN, PLAIN, SIZE, ("combined",), measure=False, impostors=choice), on=renderer).frame.passes
        for choice in (None, dear)
    ]
    np.testing.assert_array_equal(passes[0]["combined"], passes[1]["combined"])


def test_edge_lines_of_an_impostor_lie_where_the_meshs_do(renderer):
    scene, shown = scenes.scene_of(scenes.box((-0.6, -0.5, 0.0), (0.5, 0.4, 0.8))), []
    for choice in (None, whole(scene)):
        asked = Job(scene, orbit(0.3), SUN, PLAIN.replaced(edges={"width": 1.5}), SIZE, ("combined",), measure=False, impostors=choice)
        shown.append(run(asked, on=renderer).frame.passes["combined"][..., :3])
    assert np.mean(np.abs(shown[0] - shown[1]).max(axis=-1) > 0.1) < 0.01
