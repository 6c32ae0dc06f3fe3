"""What one can see through, and what lets light through: in the picture, in its alpha, in its shadows. Cycles is the judge."""

import numpy as np
import pytest

from tests.blender import judge

pytestmark = pytest.mark.usefixtures("blend")
STEP = 1.0 / 255.0


def pane(kind, **inputs):
    """A material of one shader."""
    made = judge.material("pane")
    node = judge.to_output(made, made.node_tree.nodes.new(kind))
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    return made


def mixed(factor, color=(1.0, 1.0, 1.0, 1.0)):
    """Diffuse mixed with Transparent, which has so much of it."""
    made = judge.diffuse(name="pane")
    tree = made.node_tree
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    mix.inputs[0].default_value, clear.inputs[0].default_value = factor, color
    tree.links.new(next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").outputs[0], mix.inputs[1])
    tree.links.new(clear.outputs[0], mix.inputs[2])
    judge.to_output(made, mix)
    return made


def matt(alpha):
    """Principled without a coat, so much of it there."""
    return pane("ShaderNodeBsdfPrincipled", **{"Base Color": (0.1, 0.3, 0.6, 1.0), "Alpha": alpha, "Specular IOR Level": 0.0})


PAINTS = {
    "red glass": lambda: pane("ShaderNodeBsdfTransparent", Color=(0.9, 0.2, 0.1, 1.0)),
    "half there": lambda: matt(0.5),
    "hardly there": lambda: matt(0.1),
    "nearly whole": lambda: matt(0.9),
    "mixed": lambda: mixed(0.7, (0.3, 0.8, 1.0, 1.0)),
}


def over_a_floor(paint, size=(96, 60)):
    """A leaning pane over a floor with a box behind it; its shadow falls beside it."""
    scene = judge.empty_scene(*size)
    judge.plate(paint=judge.diffuse((0.7, 0.7, 0.7)))
    judge.box(1.5, (0.0, 0.0, 0.75), judge.diffuse())
    judge.sun()
    judge.camera()
    leaning = judge.plate(3.0, 2.5, paint(), "pane")
    leaning.rotation_euler = (0.5, 0.2, 0.0)
    return scene


def off(scene, path, **options):
    """The mean distance of our picture from Cycles', colours and alpha, over one step of an 8-bit picture."""
    mine, theirs = judge.ours(scene, **options)[0], judge.cycles(scene, path, samples=64)
    return np.abs(np.clip(mine, 0.0, 1.0) - np.clip(theirs, 0.0, 1.0)).mean(axis=(0, 1)) / STEP


@pytest.mark.parametrize("paint", PAINTS)
def test_a_pane_is_seen_through_and_tints_its_shadow_as_in_cycles(paint, tmp_path):
    assert (off(over_a_floor(PAINTS[paint]), tmp_path) < 2.0).all()


def stacked(order, size=(96, 60)):
    """Panes over one another, made in that order, with a box between them and their shadows on it and beside it."""
    scene = judge.empty_scene(*size)
    judge.plate(paint=judge.diffuse((0.7, 0.7, 0.7)))
    judge.box(0.8, (0.3, 0.0, 1.2), judge.diffuse((0.6, 0.6, 0.6)))
    judge.sun((0.4, -0.3, 2.0))
    judge.camera()
    paints = ("red glass", "mixed", "half there", "hardly there")
    for i in order:
        judge.plate(2.5, (0.4, 2.0, 2.3, 2.31)[i], PAINTS[paints[i]](), f"pane {i}")
    return scene


def test_panes_over_one_another_are_as_in_cycles_in_whatever_order_they_come(tmp_path):
    scene = stacked((0, 1, 2, 3))
    assert (off(scene, tmp_path) < 2.0).all()
    assert np.allclose(judge.ours(scene)[0], judge.ours(stacked((3, 1, 0, 2)))[0], atol=1e-4)


def test_a_lamp_shines_through_panes_as_in_cycles(tmp_path):
    scene = stacked((0, 1, 2, 3))
    scene.collection.objects.unlink(scene.objects["Sun"])
    judge.lamp("SPOT", (0.5, -0.5, 5.0), 900.0)
    assert (off(scene, tmp_path) < 2.5).all()


def test_a_pane_before_nothing_leaves_so_much_of_a_transparent_film(tmp_path):
    scene = over_a_floor(PAINTS["mixed"])
    scene.render.film_transparent = True
    scene.collection.objects.unlink(scene.objects["plate"])
    judge.background(scene, (0.3, 0.3, 0.3))
    scene.world.cycles_visibility.diffuse = False
    assert off(scene, tmp_path, light_strength=0.0)[3] < 2.0


def test_what_stands_before_a_pane_is_not_tinted():
    scene = judge.empty_scene(32, 20)
    judge.plate(paint=judge.diffuse((0.7, 0.7, 0.7)), height=1.0)
    judge.plate(4.0, 0.999, PAINTS["red glass"](), "pane")
    judge.sun((0.0, 0.1, 1.0))
    judge.camera((0.0, 0.0, 9.0))
    picture = judge.ours(scene)[0]
    scene.collection.objects.unlink(scene.objects["pane"])
    assert np.allclose(picture, judge.ours(scene)[0])


@pytest.mark.parametrize(
    "paint",
    [lambda: matt(0.0), lambda: mixed(1.0), lambda: pane("ShaderNodeBsdfGlass")],
    ids=["alpha 0", "all transparent", "clear glass"],
)
def test_what_is_fully_transparent_is_not_there(paint):
    scene = over_a_floor(paint)
    with_it, warnings = judge.ours(scene)
    assert warnings == []
    scene.collection.objects.unlink(scene.objects["pane"])
    assert np.allclose(with_it, judge.ours(scene)[0])


def test_coloured_glass_tints_what_lies_behind_it_and_its_shadow():
    scene = over_a_floor(lambda: pane("ShaderNodeBsdfGlass", Color=(0.2, 0.8, 0.4, 1.0)))
    picture = judge.ours(scene)[0]
    scene.collection.objects.unlink(scene.objects["pane"])
    share = picture[..., :3] / np.maximum(judge.ours(scene)[0][..., :3], 1e-6)
    for times in (1, 2):
        assert np.isclose(share, np.array([0.2, 0.8, 0.4]) ** times, rtol=0.02).all(axis=-1).mean() > 0.01, "seen, and on its own shadow"


def solid_to_light():
    """Red glass whose transparent shadows are switched off."""
    paint = PAINTS["red glass"]()
    paint.use_transparent_shadow = False
    return paint


def clear_to_light():
    """A diffuse surface that is transparent to shadow rays alone."""
    paint = mixed(0.0)
    tree = paint.node_tree
    path, mix = tree.nodes.new("ShaderNodeLightPath"), next(n for n in tree.nodes if n.type == "MIX_SHADER")
    tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs[0])
    return paint


@pytest.mark.parametrize("paint", [solid_to_light, clear_to_light])
def test_what_the_eye_sees_through_and_what_light_passes_are_told_apart_as_in_cycles(paint, tmp_path):
    assert (off(over_a_floor(paint), tmp_path) < 2.0).all()
