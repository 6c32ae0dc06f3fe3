"""Colours that vary over a mesh, attributes and pictures, as the snapshot has them: each triangle close to its own, all in few pieces."""

import numpy as np
import pytest

from addon.blender.snapshot.reader import SceneReader
from addon.blender.snapshot.varied import BITS, MOST, SHIFT, slot_and_color, subdivision
from addon.images.srgb import linear_from_srgb


def grid(blend, n, link):
    """A unit square of n × n quads of a material whose base colour `link` feeds; gives mesh and material."""
    bpy = blend
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=n, y_subdivisions=n, size=1)
    mesh = bpy.context.object.data
    material = bpy.data.materials.new("varied")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    mesh.materials.append(material)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Metallic"].default_value = 0.0
    material.node_tree.links.new(link(bpy, material.node_tree, mesh), shader.inputs["Base Color"])
    return mesh, material


def color_attribute(color, domain="POINT"):
    def link(bpy, tree, mesh):
        attribute = mesh.color_attributes.new("tint", "FLOAT_COLOR", domain)
        places = [v.co for v in mesh.vertices] if domain == "POINT" else [mesh.vertices[loop.vertex_index].co for loop in mesh.loops]
        attribute.data.foreach_set("color", np.array([[*color(p.x + 0.5, p.y + 0.5), 1.0] for p in places], np.float32).ravel())
        node = tree.nodes.new("ShaderNodeVertexColor")
        node.layer_name = "tint"
        return node.outputs["Color"]

    return link


def picture(pixels):
    """A node of a picture, (h, w, 4) with row 0 below, through the active UV map."""

    def link(bpy, tree, _mesh):
        image = bpy.data.images.new("p", pixels.shape[1], pixels.shape[0])
        image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        return node.outputs["Color"]

    return link


def pieces(blend):
    """(middle, colour) of every triangle of the scene as the renderer is given it, and the number of pieces and slots."""
    scene = SceneReader().read(blend.context.evaluated_depsgraph_get())
    middles, colors = [], []
    for mesh, color in zip(scene.instances.mesh_index, scene.instances.base_color, strict=True):
        corners = scene.meshes[mesh].positions[scene.meshes[mesh].triangles]
        middles += corners.mean(axis=1)[:, :2].tolist()
        colors += [color[:3].tolist()] * len(corners)
    return np.array(middles) + 0.5, np.array(colors), len(scene.meshes), set(scene.instances.material_slot.tolist()), scene.warnings


@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_a_colour_attribute_is_seen_as_a_gradient(blend, domain):
    grid(blend, 20, color_attribute(lambda x, y: (x, 0.0, y), domain))
    middles, colors, count, slots, warnings = pieces(blend)
    wanted = np.stack([middles[:, 0], 0 * middles[:, 0], middles[:, 1]], axis=1)
    assert np.abs(np.sqrt(colors) - np.sqrt(wanted)).max() < 0.12
    assert 20 < count <= MOST
    assert slots == {0}
    assert not warnings


def test_a_picture_is_seen_where_it_lies(blend):
    pixels = np.zeros((2, 2, 4))
    pixels[..., 3] = 1.0
    pixels[0, 0, 0], pixels[0, 1, 1], pixels[1, 0, 2], pixels[1, 1, :3] = 1.0, 1.0, 1.0, 0.5
    grid(blend, 8, picture(pixels))
    middles, colors, count, _, _ = pieces(blend)
    own = pixels[(middles[:, 1] > 0.5).astype(int), (middles[:, 0] > 0.5).astype(int), :3]
    assert np.abs(np.sqrt(colors) - np.sqrt(linear_from_srgb(own))).max() < 0.03
    assert count == 4


def test_a_picture_on_two_triangles_is_seen_pixel_by_pixel(blend):
    pixels = np.zeros((8, 8, 4))
    pixels[..., 3] = 1.0
    pixels[::2, ::2, 0] = pixels[1::2, 1::2, 0] = 1.0
    grid(blend, 1, picture(pixels))
    middles, colors, count, _, _ = pieces(blend)
    own = pixels[(middles[:, 1] * 8).astype(int), (middles[:, 0] * 8).astype(int), :3]
    assert len(middles) == 2 * 4**3
    assert count == 2
    assert (np.abs(colors - own).max(axis=1) < 0.01).mean() > 0.8


def test_nodes_between_change_each_colour_as_they_change_the_mean(blend):
    def tinted(bpy, tree, mesh):
        source = color_attribute(lambda x, _: (x, x, x))(bpy, tree, mesh)
        mix = tree.nodes.new("ShaderNodeMix")
        mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
        mix.inputs["Factor"].default_value = 1.0
        first, second = [socket for socket in mix.inputs if socket.type == "RGBA"][:2]
        tree.links.new(source, first)
        second.default_value = (1.0, 0.5, 0.0, 1.0)
        return next(socket for socket in mix.outputs if socket.type == "RGBA")

    grid(blend, 10, tinted)
    middles, colors, *_ = pieces(blend)
    assert np.abs(colors - middles[:, :1] * [1.0, 0.5, 0.0]).max() < 0.04


def test_one_colour_all_over_stays_one_piece(blend):
    grid(blend, 4, color_attribute(lambda *_: (0.25, 0.5, 1.0)))
    _, colors, count, _, _ = pieces(blend)
    assert count == 1
    assert np.allclose(colors, [0.25, 0.5, 1.0], atol=1e-6)


def test_a_material_that_begins_to_vary_is_read_anew(blend):
    mesh, material = grid(blend, 4, color_attribute(lambda x, y: (x, y, 0.0)))
    reader = SceneReader()
    tree = material.node_tree
    (link,) = [link for link in tree.links if link.to_socket.name == "Base Color"]
    source, target = link.from_socket, link.to_socket
    tree.links.remove(link)
    assert len(reader.read(blend.context.evaluated_depsgraph_get()).meshes) == 1
    tree.links.new(source, target)
    assert len(reader.read(blend.context.evaluated_depsgraph_get()).meshes) > 4


def test_a_slot_with_a_colour_says_both():
    rng = np.random.default_rng(5)
    for slot, code in zip(rng.integers(0, SHIFT, 50).tolist(), rng.integers(0, 1 << 3 * BITS, 50).tolist(), strict=True):
        number, color = slot_and_color(slot + SHIFT * (1 + code))
        assert number == slot
        assert np.allclose(np.sqrt(color) * 31, [code >> 10, code >> 5 & 31, code & 31])
    assert slot_and_color(7) == (7, None)


def test_a_colour_that_varies_within_one_triangle_is_seen_to(blend):
    bpy = blend
    mesh = bpy.data.meshes.new("triangle")
    mesh.from_pydata([(-0.5, -0.5, 0), (0.5, -0.5, 0), (-0.5, 0.5, 0)], [], [(0, 1, 2)])
    bpy.context.collection.objects.link(bpy.data.objects.new("triangle", mesh))
    material = bpy.data.materials.new("varied")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    mesh.materials.append(material)
    source = color_attribute(lambda x, y: (x, y, 0.0), "CORNER")(bpy, material.node_tree, mesh)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(source, shader.inputs["Base Color"])
    middles, colors, count, slots, _ = pieces(blend)
    wanted = np.stack([middles[:, 0], middles[:, 1], 0 * middles[:, 0]], axis=1)
    assert len(middles) == 4**4
    assert np.abs(np.sqrt(colors) - np.sqrt(wanted)).max() < 0.12
    assert slots == {0}


@pytest.mark.parametrize("level", range(4))
def test_parts_of_a_triangle_cover_it_once(level):
    parts = subdivision(level) @ np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    a, b, c = parts[:, 0], parts[:, 1], parts[:, 2]
    areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert np.allclose(areas, 0.5 / 4**level)
