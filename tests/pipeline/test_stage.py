"""The ground catches shadows and nothing else; sections show their caps in every pixel they cover."""

import numpy as np
import pytest

from addon.errors import SceneError
from addon.maths.view import Camera
from addon.pipeline.job import Job
from addon.pipeline.passes.shade import radiance_per_color
from addon.settings.groups import Settings, ShadingWorld
from addon.studies.run import run
from addon.studies.staged import staged
from tests import bodies, scenes

SIZE = (200, 150)
SUN = scenes.sun(45.0, 150.0)
FROM_ABOVE = scenes.look_at((4.0, -6.0, 5.0), (0.0, 0.0, 0.5), fov_y_deg=30.0, near=1.0, far=60.0)
FROM_BELOW = scenes.look_at((4.0, -6.0, -3.0), (0.0, 0.0, 0.5), fov_y_deg=30.0, near=1.0, far=60.0)
TRANSPARENT = {"samples": 1, "background": (0.0, 0.0, 0.0, 0.0)}
BOX = scenes.box((-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))


def settings(**groups):
    return Settings().replaced(**({"shading": {"samples": 1}, "fit": {"size": 512}, "test": {"kind": "triangle"}} | groups))


def job(scene, chosen, passes=("combined",), camera=FROM_ABOVE, **more):
    return staged(Job(scene, camera, SUN, chosen, SIZE, passes, **more))


def drawn(renderer, scene, chosen, passes=("combined", "shadow", "depth", "object"), camera=FROM_ABOVE):
    return run(job(scene, chosen, passes, camera), on=renderer).frame.passes


def places_on(z, camera=FROM_ABOVE):
    """(h, w, 3) where the rays through the pixels meet the height z."""
    width, height = SIZE
    x, y = np.meshgrid(2.0 * (np.arange(width) + 0.5) / width - 1.0, 1.0 - 2.0 * (np.arange(height) + 0.5) / height)
    clip = np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1) @ np.linalg.inv(camera.clip_from_world).T
    along = clip[..., :3] / clip[..., 3:] - camera.eye_ws
    return camera.eye_ws + along * ((z - camera.eye_ws[2]) / along[..., 2])[..., None]


def shaded_by_box(place):
    """Whether the ray from a place on z = 0 towards the sun meets `BOX`: it does where its shadow, the box swept along the light, lies."""
    slope = SUN.direction_ws[:2] / SUN.direction_ws[2]
    step = np.linspace(0.0, 1.0, 201)[:, None, None, None]
    swept = place[..., :2] + step * slope
    return (np.abs(swept) <= 0.5).all(axis=-1).any(axis=0)


def test_the_ground_is_dark_just_where_the_shadow_of_the_model_falls(renderer):
    passes = drawn(renderer, scenes.scene_of(BOX), settings(ground={"kind": "auto"}, shading=TRANSPARENT))
    free, dark = passes["object"] < 0, shaded_by_box(places_on(0.0))
    got = passes["combined"][..., 3] > 0.05
    assert (free & dark).sum() > 300
    assert (got != dark)[free].mean() < 0.01


def test_over_nothing_the_shadow_is_black_with_its_opacity_and_over_a_color_it_is_laid(renderer):
    scene, color = scenes.scene_of(BOX), (0.8, 0.6, 0.4, 1.0)
    over_nothing = drawn(renderer, scene, settings(ground={"kind": "auto"}, shading=TRANSPARENT))["combined"]
    over_color = drawn(renderer, scene, settings(ground={"kind": "auto"}, shading={"samples": 1, "background": color}))["combined"]
    free = over_nothing[..., 3] < 1.0
    assert (over_nothing[free][:, :3] == 0.0).all()
    assert np.allclose(over_color, over_nothing + (1.0 - over_nothing[..., 3:]) * np.array(color), atol=1e-5)


def test_a_shadow_on_the_ground_takes_the_share_of_the_sun(renderer):
    chosen = settings(ground={"kind": "auto"}, shading=TRANSPARENT)
    combined = drawn(renderer, scenes.scene_of(BOX), chosen)["combined"]
    brightness, shading = np.array([0.2126, 0.7152, 0.0722]), chosen.shading.under(ShadingWorld())
    direct, sky = SUN.direction_ws[2] * radiance_per_color(SUN, shading), brightness @ shading.ambient_sky
    darkest = combined[combined[..., 3] < 1.0][:, 3].max()
    assert darkest == pytest.approx(direct / (direct + sky), rel=1e-3)


def test_nothing_else_is_seen_of_the_ground(renderer):
    scene = scenes.scene_of(BOX)
    hard = {"smoothing": 1}  # a picture as hard as the data are
    with_it, without = (drawn(renderer, scene, settings(ground={"kind": kind}, test=hard)) for kind in ("auto", "off"))
    assert np.array_equal(with_it["object"], without["object"])
    assert np.allclose(with_it["depth"], without["depth"], rtol=1e-5)
    lit = with_it["shadow"] == 1.0
    assert np.allclose(with_it["combined"][lit & (with_it["object"] < 0)], without["combined"][lit & (with_it["object"] < 0)])


def test_the_ground_fades_out_and_has_no_edge(renderer):
    low_sun = scenes.sun(6.0, 150.0)
    far = scenes.look_at((10.0, -14.0, 14.0), (3.0, -2.0, 0.0), fov_y_deg=50.0, near=1.0, far=100.0)
    made = staged(Job(scenes.scene_of(BOX), far, low_sun, settings(ground={"kind": "auto"}, shading=TRANSPARENT), SIZE, ("combined",)))
    alpha = run(made, on=renderer).frame.passes["combined"][..., 3]
    place = places_on(0.0, far)
    beside = np.linalg.norm(np.maximum(np.abs(place[..., :2]) - 0.5, 0.0), axis=-1)
    assert alpha[(beside > 3.4) & (alpha < 1.0)].max() < 0.02
    assert alpha[(beside > 0.2) & (beside < 1.0)].max() > 0.2


def test_from_below_and_with_the_ground_off_there_is_none(renderer):
    scene = scenes.scene_of(BOX)
    assert job(scene, settings(ground={"kind": "auto"}), camera=FROM_BELOW).scene is scene
    assert job(scene, settings()).scene is scene


def test_a_height_by_hand_is_in_the_world_and_hides_nothing(renderer):
    scene = scenes.scene_of(BOX)
    low, at_zero = (drawn(renderer, scene, settings(ground={"kind": "height", "height": z}, shading=TRANSPARENT)) for z in (-1.0, 0.0))
    assert np.array_equal(low["object"], at_zero["object"])
    dark = [passes["combined"][..., 3] > 0.05 for passes in (low, at_zero)]
    assert (dark[0] != dark[1]).mean() > 0.01
    moved = type(scene)(scene.meshes, scene.instances, scene.object_names, np.array([0.0, 0.0, 50.0]))
    again = drawn(renderer, moved, settings(ground={"kind": "height", "height": 50.0}, shading=TRANSPARENT))
    assert np.array_equal(again["combined"], at_zero["combined"])


def test_one_view_after_another_gets_the_same_scene():
    scene, chosen = scenes.scene_of(BOX), settings(ground={"kind": "auto"}, section={"planes": (0, 0, 0.5, 0, 0, 1.0)})
    assert job(scene, chosen).scene is job(scene, chosen).scene


def parallel(width=4.0):
    """Looks down along −y at a plate of world width `width`."""
    view = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]])
    half = width / 2.0, width / 2.0 * SIZE[1] / SIZE[0]
    clip = np.diag([1.0 / half[0], 1.0 / half[1], -2.0 / 40.0, 1.0])
    return Camera(view, clip, -20.0, 20.0)


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        (scenes.box((-1.0, -1.0, -0.7), (0.8, 1.0, 0.6)), 1.8 * 1.3),
        (bodies.torus(1.0, 0.4, 256, 128), 2.0 * np.pi * 0.16),
        (scenes.ball((0.0, 0.3, 0.0), 1.2, 256, 128), np.pi * (1.44 - 0.09)),
    ],
)
def test_the_pixels_of_a_cap_are_its_area(renderer, part, expected):
    chosen = settings(section={"planes": (0, 0, 0, 0, -1.0, 0), "cap_color": (1.0, 0.0, 1.0)}, shading={"samples": 16})
    combined = drawn(renderer, scenes.scene_of(part), chosen, ("combined",), parallel())["combined"]
    cover = np.clip((combined[..., 0] - combined[..., 1]) / 1.0, 0.0, 1.0)
    got = cover[cover > 0.02].sum() * (4.0 / SIZE[0]) ** 2
    assert got == pytest.approx(expected, rel=5e-3)


def test_caps_are_of_one_color_or_hatched_and_have_no_holes(renderer):
    scene, color = scenes.scene_of(bodies.torus(1.0, 0.4, 96, 48)), np.array([0.2, 0.7, 0.3], np.float32)
    section = {"planes": (0, 0, 0, 0, -1.0, 0), "cap_color": tuple(map(float, color))}
    solid, hatched = (drawn(renderer, scene, settings(section=section | {"caps": kind}), camera=parallel()) for kind in ("solid", "hatch"))
    x, z = np.meshgrid((np.arange(SIZE[0]) + 0.5) * 0.02 - 2.0, 1.5 - (np.arange(SIZE[1]) + 0.5) * 0.02)
    inside = np.hypot(np.abs(x) - 1.0, z) < 0.38
    assert (np.abs(solid["combined"][inside][:, :3] - color) < 1e-6).all()
    share = (hatched["combined"][inside][:, 1] < 0.6).mean()
    assert 0.05 < share < 0.4


def test_cut_and_uncut_shadows(renderer):
    scene = scenes.scene_of(scenes.floor(4.0), scenes.box((-0.5, -0.5, 0.5), (0.5, 0.5, 1.5)))
    planes = {"planes": (0, 0, 1.0, 0, 0, 1.0)}
    whole, cut, uncut = (
        drawn(renderer, scene, settings(section=section))["shadow"] for section in ({}, planes, planes | {"casts_whole": True})
    )
    floor = drawn(renderer, scene, settings(section=planes))["object"] == 0
    assert (cut[floor] == 0.0).sum() < 0.9 * (uncut[floor] == 0.0).sum()
    same = floor & (drawn(renderer, scene, settings())["object"] == 0)
    assert np.mean(uncut[same] != whole[same]) < 0.005


def test_a_section_that_takes_everything_says_so():
    with pytest.raises(SceneError, match="cut everything away: move a section plane"):
        job(scenes.scene_of(BOX), settings(section={"planes": (0, 0, -5.0, 0, 0, 1.0)}))


def test_an_open_body_is_named_in_the_warnings(renderer):
    made = job(scenes.scene_of(scenes.rod((0, 0, 0), (0, 0, 1), 0.5)), settings(section={"planes": (0, 0, 0.5, 0, 0, 1.0)}))
    assert any("'part 0': not closed" in warning for warning in made.warnings)


def test_caps_and_edges_in_the_first_picture_of_a_size(renderer):
    """The targets of edges are made while the caps' framebuffer has just gone."""
    chosen = settings(section={"planes": (0, 0, 0.5, 0, 0, 1.0)}, edges={"width": 2.0})
    made = staged(Job(scenes.scene_of(BOX), FROM_ABOVE, SUN, chosen, (67, 43), ("combined", "edges")))
    passes = run(made, on=renderer).frame.passes
    assert passes["edges"].max() > 0.9
