"""Brightness, colour and visibility as Blender means them, with Cycles as the judge."""

import math

import numpy as np
import pytest

from tests.blender import judge

pytestmark = pytest.mark.usefixtures("blend")


def principled(**inputs):
    def made():
        paint = judge.material()
        node = judge.to_output(paint, paint.node_tree.nodes.new("ShaderNodeBsdfPrincipled"))
        node.inputs["Base Color"].default_value = (0.7, 0.4, 0.15, 1.0)
        for name, value in inputs.items():
            node.inputs[name].default_value = value
        return paint

    return made


@pytest.mark.parametrize("energy", [1.0, 3.0, 10.0])
def test_a_sun_shows_a_diffuse_surface_as_its_strength_times_albedo_over_pi(energy):
    scene = judge.empty_scene(8, 8)
    judge.plate(paint=judge.diffuse((0.5, 0.3, 0.1)))
    judge.sun((0.0, 0.6, 0.8), energy)
    judge.camera((0.0, 0.0, 9.0))
    picture, _ = judge.ours(scene)
    assert np.allclose(picture[4, 4, :3], np.array([0.5, 0.3, 0.1]) * energy * 0.8 / math.pi, rtol=1e-3)


@pytest.mark.parametrize(
    "paint",
    [
        judge.diffuse,
        lambda: None,
        principled(),
        principled(Roughness=0.2),
        principled(Metallic=1.0, Roughness=0.4),
        principled(**{"Specular IOR Level": 0.0}),
    ],
    ids=["diffuse", "none", "principled", "glossy", "metal", "matt"],
)
def test_a_box_under_a_sun_is_as_bright_as_in_cycles(paint, tmp_path):
    most, median = judge.apart(judge.standard_scene(paint), tmp_path)
    assert median < 0.01
    assert most < 0.03


def test_metal_shines_in_its_own_colour_and_is_dark_elsewhere():
    pictures = {}
    for metallic in (0.0, 1.0):
        scene = judge.empty_scene()
        judge.plate(paint=principled(Metallic=metallic, Roughness=0.2)())
        judge.sun((-7.0, 7.0, 5.0))
        judge.camera()
        pictures[metallic] = judge.ours(scene)[0][..., :3]
    metal, paint = pictures[1.0], pictures[0.0]
    shine, away = metal[20, 32], metal[38, 2]
    assert shine[0] / shine[2] > 3.0, "in the metal's colour, a little whiter at this angle"
    assert shine[0] > 20.0 * away[0]
    assert paint[38, 2, 0] > 4.0 * away[0], "paint is lit away from its highlight"
    gloss = paint[20, 32] - paint[38, 2]
    assert gloss[0] / gloss[2] == pytest.approx(1.0, rel=0.1), "a highlight of paint is white"


@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
def test_lamps_are_as_bright_as_in_cycles(kind, tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    scene.collection.objects.unlink(scene.objects["Sun"])
    judge.lamp(kind, (2.0, -3.0, 5.0), 800.0)
    most, median = judge.apart(scene, tmp_path)
    assert median < 0.01
    assert most < 0.03


def test_a_lamp_with_exposure_and_temperature_is_as_in_cycles(tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    lamp = scene.objects["Sun"].data
    if not hasattr(lamp, "temperature"):
        pytest.skip("this Blender's lights have neither")
    lamp.use_temperature, lamp.temperature, lamp.exposure, lamp.color = True, 3000.0, 0.5, (1.0, 0.9, 0.8)
    assert judge.apart(scene, tmp_path)[0] < 0.01


def test_a_world_lights_and_stands_behind_everything_in_its_colour(tmp_path):
    scene = judge.empty_scene()
    judge.background(scene, (0.2, 0.3, 0.4), 1.5)
    judge.box(paint=judge.diffuse())
    judge.camera()
    picture, warnings = judge.ours(scene, light_strength=0.0)
    assert np.allclose(picture[0, 0], [0.3, 0.45, 0.6, 1.0], atol=1e-5)
    assert np.allclose(picture[20, 32, :3], np.array([0.5, 0.3, 0.1]) * [0.3, 0.45, 0.6], atol=1e-3)
    judge.sun()
    lit, _ = judge.ours(scene)
    assert np.allclose(lit[0, 0], judge.cycles(scene, tmp_path)[0, 0], atol=1e-5)


def test_the_sky_of_the_scene_has_the_worlds_colours_whatever_was_chosen_by_hand():
    scene = judge.empty_scene()
    judge.background(scene, (0.2, 0.3, 0.4), 1.5)
    judge.box(paint=judge.diffuse())
    judge.camera()
    by_hand = {"ambient_sky": (0.9, 0.1, 0.1), "ambient_ground": (0.1, 0.9, 0.1)}
    worlds, even = judge.ours(scene, sky="scene", **by_hand)[0], judge.ours(scene, sky="uniform")[0]
    assert np.array_equal(worlds, even)
    assert np.abs(judge.ours(scene, sky="uniform", **by_hand)[0] - worlds).max() > 0.1


def test_a_world_behind_mixed_nodes_in_groups_is_followed(blend):
    scene = judge.empty_scene()
    tree = judge.emptied(scene.world)
    group = blend.data.node_groups.new("inside", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inner = group.nodes.new("ShaderNodeBackground")
    inner.inputs["Color"].default_value, inner.inputs["Strength"].default_value = (1.0, 0.5, 0.0, 1.0), 2.0
    group.links.new(inner.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    node, mix = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeMixShader")
    node.node_tree, mix.inputs[0].default_value = group, 0.75
    tree.links.new(tree.nodes.new("ShaderNodeBackground").outputs[0], mix.inputs[1])
    tree.nodes["Background"].inputs["Color"].default_value = (0.0, 0.0, 0.4, 1.0)
    tree.links.new(node.outputs[0], mix.inputs[2])
    judge.to_output(scene.world, mix)
    judge.box()
    judge.camera()
    judge.sun()
    picture, warnings = judge.ours(scene)
    assert np.allclose(picture[0, 0, :3], [1.5, 0.75, 0.1], atol=1e-5)
    assert warnings == []


def test_a_picture_round_a_world_counts_by_its_upper_and_lower_mean(blend):
    scene = judge.empty_scene()
    image = blend.data.images.new("sky", 8, 4, float_buffer=True)
    rows = np.repeat(np.array([0.25, 0.25, 2.0, 2.0], np.float32)[:, None], 8, axis=1)
    image.pixels.foreach_set(np.stack([rows, rows, rows, np.ones_like(rows)], axis=-1).ravel())
    node = judge.background(scene, (1.0, 1.0, 1.0), 0.5)
    texture = scene.world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    scene.world.node_tree.links.new(texture.outputs[0], node.inputs["Color"])
    judge.plate(paint=judge.diffuse((0.5, 0.5, 0.5)))
    judge.camera((0.0, 0.0, 9.0))
    picture, warnings = judge.ours(scene, light_strength=0.0)
    assert picture[20, 32, 0] == pytest.approx(0.5 * 2.0 * 0.5, rel=1e-3), "a floor is lit by the upper half"
    assert not [line for line in warnings if "World" in line]


def test_a_world_that_cannot_be_followed_is_named(blend):
    scene = judge.standard_scene()
    node = judge.background(scene, (1.0, 1.0, 1.0))
    noise = scene.world.node_tree.nodes.new("ShaderNodeTexNoise")
    scene.world.node_tree.links.new(noise.outputs["Color"], node.inputs["Color"])
    assert any("World 'World'" in line for line in judge.ours(scene)[1])


def test_colours_set_by_hand_go_before_the_world():
    scene = judge.standard_scene()
    judge.background(scene, (1.0, 0.0, 0.0))
    props = scene.cad_shadow
    props.use_background, props.background = True, (0.0, 1.0, 0.0, 1.0)
    scene.camera.rotation_euler = (math.pi, 0.0, 0.0)  # up, where nothing is
    assert np.allclose(judge.ours(scene)[0][0, 0], [0.0, 1.0, 0.0, 1.0])
    props.use_background = False
    assert np.allclose(judge.ours(scene)[0][0, 0], [1.0, 0.0, 0.0, 1.0])


def test_the_old_look_is_one_factor_away():
    scene = judge.standard_scene(judge.diffuse)
    now, old = (judge.ours(scene, light_strength=strength)[0] for strength in (1.0, 0.85 * math.pi))
    assert np.allclose(old[..., :3], now[..., :3] * 0.85 * math.pi, rtol=1e-4)
    assert old[..., 0].max() == pytest.approx(0.5 * 0.85 * 3.0 * 2.0 / math.sqrt(6.0), rel=0.02)


def saved_and_opened(bpy, path, version, change):
    """The scene after `change`, saved as a file of that settings version and opened again."""
    import bl_ext.user_default.cad_shadow_preview.addon.blender.properties as properties

    scene = judge.standard_scene(judge.diffuse)
    judge.background(scene, (1.0, 0.0, 0.0))
    change(scene.cad_shadow)
    properties.SETTINGS_VERSION, kept = version, properties.SETTINGS_VERSION
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
    finally:
        properties.SETTINGS_VERSION = kept
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return bpy.context.scene


@pytest.mark.parametrize("strength", [None, 0.4])
def test_a_file_of_the_first_version_keeps_its_look(blend, tmp_path, strength):
    def change(props):
        if strength is not None:
            props.light_strength = strength
        props.background = (0.0, 0.0, 1.0, 1.0)

    scene = saved_and_opened(blend, tmp_path / "old.blend", 1, change)
    picture, _ = judge.ours(scene)
    lit = 0.5 * ((strength or 0.85) * 3.0 * 2.0 / math.sqrt(6.0) + 0.32)
    assert picture[..., 0].max() == pytest.approx(lit, rel=1e-3)
    settings = scene.cad_shadow
    assert settings.test == "depth", "the shadow test that was the default"
    assert (settings.use_background, tuple(settings.background)) == (True, (0.0, 0.0, 1.0, 1.0))
    own, _ = judge.ours(scene, light_direction=(0.0, 0.0, 1.0))
    assert own[..., 0].max() == pytest.approx(0.5 * ((strength or 0.85) + 0.32), rel=1e-3), "a sun by direction too"


def test_a_file_of_this_version_is_taken_as_it_is(blend, tmp_path):
    scene = saved_and_opened(blend, tmp_path / "new.blend", 2, lambda props: setattr(props, "light_strength", 0.5))
    assert scene.cad_shadow.light_strength == 0.5
    assert not scene.cad_shadow.use_ambient_sky


def test_a_sky_dome_without_shadow_leaves_the_picture_light(tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    import bpy

    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=60.0)
    dome = bpy.context.object
    dome.visible_shadow = False
    most, median = judge.apart(scene, tmp_path)
    assert median < 0.01
    dome.visible_shadow = True
    assert judge.ours(scene)[0][..., 0].max() < 0.01, "with it everything is in its shadow"


def test_what_the_camera_may_not_see_casts_and_what_may_cast_none_is_seen(tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    scene.objects["box"].visible_camera = False
    assert judge.apart(scene, tmp_path)[0] < 0.05
    scene.objects["box"].visible_camera, scene.objects["box"].visible_shadow = True, False
    assert judge.apart(scene, tmp_path)[0] < 0.05


@pytest.mark.parametrize("by", ["object", "collection"])
def test_a_holdout_is_a_hole_in_the_picture(blend, tmp_path, by):
    scene = judge.standard_scene(judge.diffuse)
    if by == "object":
        scene.objects["box"].is_holdout = True
    else:
        inside = blend.data.collections.new("holes")
        scene.collection.children.link(inside)
        inside.objects.link(scene.objects["box"])
        scene.collection.objects.unlink(scene.objects["box"])
        blend.context.view_layer.layer_collection.children["holes"].holdout = True
    mine, theirs = judge.ours(scene)[0], judge.cycles(scene, tmp_path)
    assert 0.05 < (theirs[..., 3] == 0.0).mean() < 0.9
    assert np.abs(mine - theirs).mean() < 2.0 / 255.0


def test_a_collection_of_indirect_light_only_is_unseen_and_casts(blend, tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    inside = blend.data.collections.new("indirect")
    scene.collection.children.link(inside)
    inside.objects.link(scene.objects["box"])
    scene.collection.objects.unlink(scene.objects["box"])
    blend.context.view_layer.layer_collection.children["indirect"].indirect_only = True
    assert judge.apart(scene, tmp_path)[0] < 0.05


@pytest.mark.parametrize("transparent", [True, False])
def test_a_shadow_catcher_shows_only_the_shadow(tmp_path, transparent):
    scene = judge.standard_scene(judge.diffuse)
    judge.background(scene, (0.3, 0.3, 0.3))
    scene.objects["plate"].is_shadow_catcher, scene.render.film_transparent = True, transparent
    mine, theirs = judge.ours(scene)[0], judge.cycles(scene, tmp_path)
    away = np.abs(mine - theirs)[theirs[..., 3] < 0.99] if transparent else np.abs(mine - theirs).reshape(-1, 4)
    assert away.mean() < 0.02


def test_a_material_override_paints_everything(blend, tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    blend.context.view_layer.material_override = judge.diffuse((0.8, 0.1, 0.1), "clay")
    assert judge.apart(scene, tmp_path)[0] < 0.01


def test_instances_are_as_invisible_as_what_makes_them_and_as_they_are(blend, tmp_path):
    scene = judge.standard_scene(judge.diffuse)
    inside = blend.data.collections.new("parts")
    for ob in (judge.box(1.0, (0, 0, 0), name="a"), judge.box(1.0, (0, 0, 2), name="b")):
        scene.collection.objects.unlink(ob)
        inside.objects.link(ob)
    inside.objects["a"].visible_camera = False
    empty = blend.data.objects.new("empty", None)
    empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", inside, (3.0, 1.0, 0.5)
    scene.collection.objects.link(empty)
    assert judge.apart(scene, tmp_path)[0] < 0.05
    empty.visible_shadow = False
    assert judge.apart(scene, tmp_path)[0] < 0.05


@pytest.mark.parametrize("shade", ["shade_flat", "shade_smooth"])
def test_a_cylinder_is_flat_or_smooth_as_in_cycles(blend, tmp_path, shade):
    scene = judge.empty_scene()
    blend.ops.mesh.primitive_cylinder_add(vertices=16, radius=2.0, depth=4.0)
    getattr(blend.ops.object, shade)()
    blend.context.object.data.materials.append(judge.diffuse())
    judge.sun((1.0, -1.0, 1.0))
    judge.camera()
    mine, theirs = judge.ours(scene)[0][..., 0], judge.cycles(scene, tmp_path)[..., 0]
    lit = (mine > 0.0) & (theirs > 0.0)  # Cycles moves the terminator of smooth surfaces
    assert lit.mean() > 0.1
    assert np.percentile(np.abs(mine - theirs)[lit], 95) < 0.03 * theirs.max()
