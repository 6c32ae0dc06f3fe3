"""What one can see through: as good as not there, letting light through, or named."""

import numpy as np
import pytest

from tests.blender import judge
from tests.blender.snapshot_rigs import read

pytestmark = pytest.mark.usefixtures("blend")


def pane(kind, **inputs):
    """A material of one shader."""
    made = judge.material("pane")
    node = judge.to_output(made, made.node_tree.nodes.new(kind))
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    return made


def mixed(factor):
    """Diffuse mixed with Transparent, which has so much of it."""
    made = judge.diffuse(name="pane")
    tree = made.node_tree
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    mix.inputs[0].default_value = factor
    tree.links.new(next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").outputs[0], mix.inputs[1])
    tree.links.new(clear.outputs[0], mix.inputs[2])
    judge.to_output(made, mix)
    return made


def over_a_floor(paint):
    """A pane high above a floor that is seen from straight above, the sun to the side; the shadow falls beside the pane."""
    scene = judge.standard_scene(judge.diffuse)
    scene.collection.objects.unlink(scene.objects["box"])
    judge.plate(3.0, 3.0, paint(), "pane")
    return scene


LIGHT = {
    "tinted": lambda: pane("ShaderNodeBsdfGlass", Color=(0.2, 0.8, 0.4, 1.0)),
    "principled glass": lambda: pane("ShaderNodeBsdfPrincipled", **{"Transmission Weight": 1.0}),
    "alpha": lambda: pane("ShaderNodeBsdfPrincipled", Alpha=0.2),
    "mixed": lambda: mixed(0.8),
}


@pytest.mark.parametrize("paint", LIGHT)
def test_what_lets_most_light_through_casts_no_shadow_and_is_named(paint):
    scene = over_a_floor(LIGHT[paint])
    picture, warnings = judge.ours(scene)
    assert any("'pane'" in line and "see through" in line for line in warnings)
    scene.objects["pane"].visible_camera = False
    without = judge.ours(scene)[0]
    scene.collection.objects.unlink(scene.objects["pane"])
    assert np.allclose(without, judge.ours(scene)[0]), "no shadow of it"


@pytest.mark.parametrize("paint", [lambda: pane("ShaderNodeBsdfPrincipled", Alpha=0.8), lambda: mixed(0.2)], ids=["alpha", "mixed"])
def test_what_lets_little_through_casts_its_shadow(paint):
    scene = over_a_floor(paint)
    scene.objects["pane"].visible_camera = False
    dark = judge.ours(scene)[0][..., 0]
    scene.collection.objects.unlink(scene.objects["pane"])
    assert (judge.ours(scene)[0][..., 0] - dark > 0.1).mean() > 0.01


@pytest.mark.parametrize(
    "paint", [lambda: pane("ShaderNodeBsdfPrincipled", Alpha=0.0), lambda: mixed(1.0), lambda: pane("ShaderNodeBsdfGlass")]
)
def test_what_is_fully_transparent_is_not_there_and_not_named(paint):
    scene = over_a_floor(paint)
    with_it, warnings = judge.ours(scene)
    assert warnings == []
    scene.collection.objects.unlink(scene.objects["pane"])
    assert np.allclose(with_it, judge.ours(scene)[0])


def test_opaque_materials_are_not_named():
    over_a_floor(judge.diffuse)
    assert not any("see through" in line for line in read().warnings)
