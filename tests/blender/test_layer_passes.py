"""The passes that a view layer asks for, as Cycles makes them; those it does not ask for do not come."""

import json

import numpy as np
import pytest

from addon.images.cryptomatte import manifest, murmur3, number_bits
from tests.blender import judge

FLAGS = (
    "use_pass_z",
    "use_pass_normal",
    "use_pass_object_index",
    "use_pass_material_index",
    "use_pass_cryptomatte_object",
    "use_pass_cryptomatte_material",
    "use_pass_position",
    "use_pass_mist",
    "use_pass_emit",
)
NAMES = {
    "use_pass_object_index": ("Object Index", "IndexOB"),
    "use_pass_material_index": ("Material Index", "IndexMA"),
    "use_pass_cryptomatte_object": ("CryptoObject00",),
    "use_pass_cryptomatte_material": ("CryptoMaterial00",),
    "use_pass_position": ("Position",),
    "use_pass_mist": ("Mist",),
    "use_pass_emit": ("Emission", "Emit"),
    "use_pass_z": ("Depth",),
    "use_pass_normal": ("Normal",),
}


def of(passes, flag):
    return next((passes[name] for name in NAMES[flag] if name in passes), None)


@pytest.fixture
def scene(blend):
    """A glowing box far from the origin on a plate, both with indices; every pass is on."""
    scene = judge.empty_scene()
    glow = judge.diffuse((0.3, 0.2, 0.1), "glow")
    tree = glow.node_tree
    added, light = tree.nodes.new("ShaderNodeAddShader"), tree.nodes.new("ShaderNodeEmission")
    light.inputs["Color"].default_value, light.inputs["Strength"].default_value = (0.2, 0.5, 1.0, 1.0), 2.0
    tree.links.new(next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").outputs[0], added.inputs[0])
    tree.links.new(light.outputs[0], added.inputs[1])
    judge.to_output(glow, added)
    floor = judge.diffuse((0.5, 0.5, 0.5), "floor")
    glow.pass_index, floor.pass_index = 7, 3
    judge.plate(12.0, paint=floor).pass_index = 2
    judge.box(paint=glow).pass_index = 5
    judge.sun()
    judge.camera()
    scene.world.mist_settings.start, scene.world.mist_settings.depth = 6.0, 9.0
    for flag in FLAGS:
        setattr(blend.context.view_layer, flag, True)
    return scene


def test_passes_that_are_on_are_those_of_cycles(scene, tmp_path):
    mine, _ = judge.layer_passes(scene, "CAD_SHADOW_PREVIEW", tmp_path)
    judge.as_judge(scene)
    theirs, _ = judge.layer_passes(scene, "CYCLES", tmp_path)
    sky = of(theirs, "use_pass_z")[..., 0] > 1e9
    assert 0.1 < sky.mean() < 0.9
    for flag in FLAGS:
        ours, judged = of(mine, flag), of(theirs, flag)
        assert ours is not None, flag
        channels = 2 if "cryptomatte" in flag else ours.shape[-1]
        off = np.abs(ours - judged)[..., :channels].max(axis=-1)
        if flag == "use_pass_z":
            off = np.where(sky, 0.0, off)
        assert (off > 2e-3).mean() < 0.01, f"{flag}: {ours[20, 32]} against {judged[20, 32]}, {ours[0, 0]} against {judged[0, 0]}"


def test_passes_that_are_off_do_not_come(scene, blend, tmp_path):
    for flag in FLAGS:
        setattr(blend.context.view_layer, flag, flag == "use_pass_mist")
    mine, _ = judge.layer_passes(scene, "CAD_SHADOW_PREVIEW", tmp_path)
    assert of(mine, "use_pass_mist") is not None
    assert all(of(mine, flag) is None for flag in FLAGS if flag != "use_pass_mist")
    assert "Shadow" not in mine
    blend.context.view_layer.use_pass_shadow = True
    mine, _ = judge.layer_passes(scene, "CAD_SHADOW_PREVIEW", tmp_path)
    assert "Shadow" in mine


def test_names_of_mattes_are_in_the_file(scene, tmp_path):
    _, data = judge.layer_passes(scene, "CAD_SHADOW_PREVIEW", tmp_path)
    assert b'"box":' in data
    assert b'"glow":' in data
    assert b"ViewLayer.CryptoObject" in data


def test_hashes_are_those_of_the_specification():
    assert murmur3(b"") == 0
    assert murmur3(b"hello") == 0x248BFA47
    assert murmur3(b"hello, world") == 0x149BBB7F
    assert murmur3(b"The quick brown fox jumps over the lazy dog") == 0x2E4FF723
    assert json.loads(manifest(["Größe"])) == {"Größe": f"{number_bits('Größe'):08x}"}
    exponents = {(number_bits(f"name {i}") >> 23) & 255 for i in range(4000)}
    assert exponents.isdisjoint({0, 255}), "no infinity, no NaN, no denormal"


def test_the_command_line_writes_them_too(scene, main, blend, tmp_path):
    path = tmp_path / "scene.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    names = "object-index,material-index,cryptomatte-object,cryptomatte-material,position,mist,emission"
    common = ["preview", str(path), "--size", "48x32", "--samples", "1", "--passes", names, "-o", str(tmp_path), "--quiet"]
    assert main([*common, "--format", "npz"]) == 0
    arrays = np.load(tmp_path / "scene.npz")
    assert set(np.unique(arrays["object_index"])) == {0.0, 2.0, 5.0}
    assert set(np.unique(arrays["material_index"])) == {0.0, 3.0, 7.0}
    assert arrays["position"].shape == (32, 48, 3)
    assert main([*common, "--format", "png"]) == 0
    assert main([*common, "--format", "exr"]) == 0
    assert len(list(tmp_path.glob("*.png"))) == 7
    assert len(list(tmp_path.glob("*.exr"))) == 7
