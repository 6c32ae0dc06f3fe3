"""The table of what is honoured: complete for this Blender, and its warnings come where and only where something is set."""

import bpy
import pytest

from addon.blender.snapshot.complaints import QUESTIONS
from addon.blender.support import HONOURED, IDLE, SUPPORT, WARNED, row_of
from tests.blender import judge

TYPES = {
    "Object": ["Object"],
    "Light": ["Light", "SunLight", "PointLight", "SpotLight", "AreaLight"],
    "Camera": ["Camera"],
    "ViewLayer": ["ViewLayer"],
    "LayerCollection": ["LayerCollection"],
    "World": ["World"],
    "Material": ["Material"],
}


def properties(kind):
    common = {p.identifier for p in bpy.types.ID.bl_rna.properties} | {"rna_type", "name"}
    return {p.identifier for p in getattr(bpy.types, kind).bl_rna.properties} - common


@pytest.mark.usefixtures("extension")
@pytest.mark.parametrize("owner", TYPES)
def test_every_property_of_this_blender_is_in_the_table(owner):
    ours = {"cad_shadow", "cad_shadow_impostor"}
    missing = {name for kind in TYPES[owner] for name in properties(kind) if row_of(owner, name) is None and not name.startswith("cad_")}
    assert missing - ours == set()


def test_every_row_says_what_becomes_of_it():
    for row in SUPPORT:
        assert row.status in (HONOURED, WARNED, IDLE)
        assert row.text
        assert (row.status == WARNED) == bool(row.question)
    assert {row.question for row in SUPPORT if row.question} == set(QUESTIONS)


def test_no_property_stands_in_two_rows():
    seen = [(row.owner, name) for row in SUPPORT for name in row.names.split()]
    assert len(seen) == len(set(seen))


def depth_of_field(scene):
    scene.camera.data.dof.use_dof = True


def motion_blur(scene):
    scene.render.use_motion_blur = True


def freestyle(scene):
    scene.render.use_freestyle = bpy.context.view_layer.use_freestyle = True


def passes(scene):
    bpy.context.view_layer.use_pass_uv = bpy.context.view_layer.use_pass_diffuse_color = True


def geometry(scene):
    judge.placed(bpy.data.hair_curves.new("hair"))


WORDS = {
    depth_of_field: "Depth of field",
    motion_blur: "Motion blur",
    freestyle: "Freestyle",
    passes: "UV",
    geometry: "hair curves (hair)",
}


@pytest.mark.usefixtures("blend")
@pytest.mark.parametrize("change", WORDS, ids=[change.__name__ for change in WORDS])
def test_what_is_set_and_left_out_is_named_in_one_line(change):
    scene = judge.standard_scene(judge.diffuse)
    assert judge.ours(scene)[1] == [], "nothing is named that nobody set"
    change(scene)
    bpy.context.view_layer.update()
    named = [line for line in judge.ours(scene)[1] if WORDS[change] in line]
    assert len(named) == 1


@pytest.mark.usefixtures("blend")
def test_a_lights_nodes_are_followed(tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    data = scene.objects["Sun"].data
    if data.node_tree is None:
        data.use_nodes = True
    tree = data.node_tree
    tree.nodes.clear()
    glow, out = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputLight")
    glow.inputs["Color"].default_value, glow.inputs["Strength"].default_value = (1.0, 0.5, 0.25, 1.0), 0.7
    tree.links.new(glow.outputs[0], out.inputs["Surface"])
    assert judge.apart(scene, tmp_path)[0] < 0.02
