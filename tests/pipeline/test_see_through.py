"""Panes in pictures and in shadows: what lies behind times their tints, in any order, with every shadow test. Held against numpy."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.pipeline.passes.peeling import MOST_LAYERS
from addon.scene.looks import CATCHER, COATED, HIDDEN, HOLDOUT, NO_SHADOW, PLAIN, Look
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes

SIZE = (80, 60)
CAMERA = scenes.look_at((2.0, -6.0, 12.0), (0.0, 0.0, 0.0), fov_y_deg=35.0, near=1.0, far=40.0)
SUN = scenes.sun(60.0)
DARK = {"ambient_sky": (0.0, 0.0, 0.0), "ambient_ground": (0.0, 0.0, 0.0), "background": (0.0, 0.0, 0.0, 0.0)}
RED, BLUE, GREY = (0.9, 0.2, 0.1), (0.2, 0.4, 0.8), (0.5, 0.5, 0.5)


def glass(through, weight=0.0, emission=(0.0, 0.0, 0.0)):
    return Look(emission, weight, through=through, light_through=through)


def panes(*placed, floor=PLAIN):
    """A floor and sheets over it: (look, height, half its side, flags) each; the sheets' middles lie over the floor's."""
    parts = [scenes.floor(10.0), *(scenes.floor(half, z) for _, z, half, *_ in placed)]
    scene, looks = scenes.scene_of(*parts), [floor, *(one[0] for one in placed)]
    flags = np.array([0, *(one[3] if len(one) > 3 else 0 for one in placed)], np.uint8)
    instances = replace(scene.instances, look=np.arange(len(looks)), flags=flags)
    return replace(scene, instances=instances, looks=np.array([look.numbers() for look in looks]))


def picture(renderer, scene, lights=(SUN,), passes=("combined",), **chosen):
    settings = Settings().replaced(**{"fit": {"size": 512}, "shading": {"samples": 1, **DARK}} | chosen)
    job = Job(scene, CAMERA, lights[0], settings, SIZE, passes, others=tuple(lights[1:]))
    return run(job, on=renderer).frame.passes


def shares(image, bare):
    """(h, w, 3) what is left of the light of the picture without panes; NaN where that is dark."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(bare[..., :3] > 1e-4, image[..., :3] / bare[..., :3], np.nan)


def found(share, *wanted):
    """The part of the picture that has each of the shares (3,)."""
    return [float(np.isclose(share, one, atol=4e-3).all(axis=-1).mean()) for one in wanted]


def test_a_pane_tints_what_lies_behind_it_and_what_its_shadow_falls_on(renderer):
    bare = picture(renderer, panes())["combined"]
    share = shares(picture(renderer, panes((glass(RED), 2.0, 1.0)))["combined"], bare)
    red = np.array(RED)
    seen, both, none = found(share, red, red * red, (1.0, 1.0, 1.0))
    assert seen > 0.03 and both > 0.001
    assert seen + both + none > 0.97, "and nothing else but edges"


def test_panes_multiply_in_whatever_order_they_are_given(renderer):
    two = [(glass(RED, 0.1), 2.0, 1.0), (glass(BLUE), 1.0, 1.2), (glass(GREY, 0.4), 3.0, 0.8)]
    one, *others = (picture(renderer, panes(*(two[i] for i in order)))["combined"] for order in ((0, 1, 2), (2, 0, 1), (1, 2, 0)))
    assert all(np.abs(one - other).max() < 1e-6 for other in others)
    share = shares(one, picture(renderer, panes())["combined"])
    assert found(share, np.array(BLUE) ** 2)[0] > 0.001


@pytest.mark.parametrize(
    "chosen",
    [
        {"test": {"kind": "depth"}},
        {"test": {"kind": "id-depth"}},
        {"test": {"kind": "triangle"}},
        {"test": {"kind": "depth", "depths": 4}},
        {"test": {"kind": "depth", "pcf": 9}},
        {"warp": {"kind": "logpsm"}},
        {"warp": {"kind": "uniform"}, "partition": {"kind": "none"}},
        {"partition": {"kind": "faces"}},
    ],
    ids=str,
)
def test_shadows_are_tinted_whatever_the_test_and_the_maps(renderer, chosen):
    bare = picture(renderer, panes(), **chosen)["combined"]
    share = shares(picture(renderer, panes((glass(RED), 2.0, 1.0, HIDDEN), (glass(BLUE), 1.0, 1.0, HIDDEN)), **chosen)["combined"], bare)
    red, blue = np.array(RED), np.array(BLUE)
    parts = found(share, red, blue, red * blue, (1.0, 1.0, 1.0))
    assert min(parts) > 0.005
    assert sum(parts) > 0.94


@pytest.mark.parametrize("lamp", ["point", "spot"])
def test_lamps_shine_through_panes(renderer, lamp):
    light = Light(lamp, np.array([0.0, 0.0, 1.0]), np.array([0.3, -0.4, 5.0]), 0.9, 0.2, color=(40.0, 40.0, 40.0))
    bare = picture(renderer, panes(), [light])["combined"]
    share = shares(picture(renderer, panes((glass(RED), 2.0, 0.6, HIDDEN)), [light])["combined"], bare)
    assert found(share, RED)[0] > 0.01


def test_what_stands_before_a_pane_is_not_tinted_by_it(renderer):
    under = (glass(RED), -0.01, 8.0)
    assert np.allclose(picture(renderer, panes(under))["combined"], picture(renderer, panes())["combined"], atol=1e-5)


def test_many_lights_and_camera_samples_give_the_same_panes(renderer):
    scene, lamp = (
        panes((glass(RED, 0.3), 2.0, 1.0), (glass(BLUE), 1.0, 1.2)),
        Light("point", None, np.array([2.0, -2.5, 4.0]), color=(9.0, 8.0, 6.0), name="lamp"),
    )
    together = picture(renderer, scene, [SUN, lamp])["combined"]
    apart = sum(picture(renderer, scene, [one])["combined"][..., :3] for one in (SUN, lamp))
    assert np.abs(together[..., :3] - apart).max() < 1e-4
    many = picture(renderer, scene, shading={"samples": 4, **DARK})["combined"]
    once = picture(renderer, scene)["combined"]
    assert np.median(np.abs(many - once)) < 1e-4
    assert np.abs(many - once).mean() < 0.02


def test_alpha_is_what_panes_leave_of_nothing(renderer):
    scene = panes((glass(GREY), 1.0, 1.0), (glass((0.2, 0.4, 0.6)), 2.0, 1.0))
    floor = replace(scene.instances, flags=np.where(np.arange(3) == 0, HIDDEN, 0).astype(np.uint8))
    alpha = picture(renderer, replace(scene, instances=floor))["combined"][..., 3]
    for wanted in (0.0, 0.5, 0.6, 0.8):
        assert np.isclose(alpha, wanted, atol=1e-5).mean() > 0.002, wanted


def test_data_are_of_what_is_at_least_half_there(renderer):
    for through, is_there in ((0.4, True), (0.6, False)):
        image = picture(renderer, panes((glass((through,) * 3, 0.3), 2.0, 1.0)), passes=("combined", "object", "depth"))
        assert (1 in np.unique(image["object"])) == is_there


def test_opaque_casters_keep_their_shadow_beside_panes(renderer):
    whole = (PLAIN, 1.5, 0.5)
    bare, with_pane = panes(whole), panes(whole, (glass((0.999,) * 3), 3.0, 5.0))
    one, other = (picture(renderer, scene, test={"kind": "triangle"})["combined"] for scene in (bare, with_pane))
    assert np.abs(one - other).max() < 0.01


def test_holdouts_and_catchers_are_whole_whatever_their_material(renderer):
    for flag in (HOLDOUT, CATCHER):
        assert panes((glass(RED), 2.0, 1.0, flag)).see_through is None


def test_more_layers_than_are_told_apart_are_said(renderer):
    scene = panes(*((glass((0.9,) * 3), 0.2 + 0.1 * i, 1.0, NO_SHADOW) for i in range(MOST_LAYERS + 2)))
    settings = Settings().replaced(fit={"size": 256}, shading={"samples": 1})
    frame = run(Job(scene, CAMERA, SUN, settings, SIZE), on=renderer).frame
    assert any("see-through surfaces" in line for line in frame.warnings)


def test_a_look_fades_to_what_lies_behind():
    half = COATED.faded(0.25)
    assert half.through == half.light_through == (0.75,) * 3
    assert half.weight == 0.25
