"""What CAD files say of looks, as Blender has it: pictures, vertex colours, lamps, cameras, hidden parts."""

import struct
import zlib

import numpy as np
import pytest

from addon.blender.cad_import import to_blender
from addon.scene import cad
from tests.cad.gltf_writer import Gltf, box


def png(pixels):
    """(h, w, 4) bytes as a PNG."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in np.ascontiguousarray(pixels, np.uint8))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def imported(blend, folder, gltf):
    (folder / "a.glb").write_bytes(gltf.glb())
    collection = to_blender(cad.read(folder / "a.glb"), blend.context.scene.collection)
    blend.context.view_layer.update()
    return collection


def links(material):
    return {(link.from_node.type, link.from_socket.name, link.to_node.type, link.to_socket.name) for link in material.node_tree.links}


def plate(picture, folder, place, factor=(1.0, 1.0, 1.0, 1.0), **material):
    """A unit square with a picture on it, within the file, in a URI or beside it."""
    gltf = Gltf()
    entry = {
        "within": lambda: {"bufferView": gltf.view(picture), "mimeType": "image/png", "name": "rust"},
        "beside": lambda: {"uri": "my%20rust.png"},
    }[place]()
    if place == "beside":
        (folder / "my rust.png").write_bytes(picture)
    gltf.add("images", **entry)
    gltf.add("textures", source=0)
    gltf.add("materials", name="Rust", pbrMetallicRoughness={"baseColorTexture": {"index": 0}, "baseColorFactor": factor}, **material)
    uvs = gltf.accessor(np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32))
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    gltf.node(mesh=gltf.mesh(square, [[0, 1, 2], [0, 2, 3]], material=0, attributes={"TEXCOORD_0": uvs}), name="plate")
    return gltf


@pytest.mark.parametrize("place", ["within", "beside"])
def test_a_base_colour_texture_is_a_picture_on_the_mesh(blend, tmp_path, place):
    pixels = np.zeros((2, 4, 4), np.uint8)
    pixels[..., 3] = 255
    pixels[0, :, 0], pixels[1, :, 2] = 255, 255  # the upper row red, the lower blue
    collection = imported(blend, tmp_path, plate(png(pixels), tmp_path, place))
    mesh = collection.all_objects["plate"].data
    (material,) = mesh.materials
    assert ("TEX_IMAGE", "Color", "BSDF_PRINCIPLED", "Base Color") in links(material)
    image = next(node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE")
    assert tuple(image.size) == (4, 2)
    assert (image.packed_file is not None) == (place == "within")
    assert np.allclose(material.diffuse_color, [0.5, 0, 0.5, 1], atol=0.02)
    uv = np.array([loop.uv for loop in mesh.uv_layers.active.data])
    corner = np.array([mesh.vertices[i].co for i in (loop.vertex_index for loop in mesh.loops)])
    assert np.allclose(uv, np.stack([corner[:, 0], 1 - corner[:, 2]], axis=1)), "v = 0 of glTF is the picture's upper edge"


def test_a_factor_and_vertex_colours_multiply_the_picture(blend, tmp_path):
    gltf = plate(png(np.full((1, 1, 4), 255, np.uint8)), tmp_path, "within", (1.0, 0.5, 1.0, 0.5), alphaMode="BLEND")
    tint = gltf.accessor(np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], np.float32))
    gltf.document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = tint
    collection = imported(blend, tmp_path, gltf)
    mesh = collection.all_objects["plate"].data
    kinds = {node.type for node in mesh.materials[0].node_tree.nodes}
    assert {"TEX_IMAGE", "VERTEX_COLOR", "MIX", "MATH"} <= kinds
    colors = np.array([d.color for d in mesh.attributes["Color"].data])
    assert np.allclose(colors[:3], [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]])
    assert mesh.materials[0].diffuse_color[3] == pytest.approx(0.5)
    assert mesh.materials[0].diffuse_color[1] < mesh.materials[0].diffuse_color[0]


def test_a_picture_that_blender_cannot_read_leaves_the_colour(blend, tmp_path):
    collection = imported(blend, tmp_path, plate(b"no picture at all", tmp_path, "within", (0.25, 0.5, 1.0, 1.0)))
    (material,) = collection.all_objects["plate"].data.materials
    assert np.allclose(material.diffuse_color, [0.25, 0.5, 1, 1])
    assert not any(node.type == "TEX_IMAGE" for node in material.node_tree.nodes)
    assert any("1 picture of a kind that is not read was left out (rust)" in line for line in cad.read(tmp_path / "a.glb").warnings)


def test_many_vertex_colours_are_an_attribute_that_the_material_looks_up(blend, tmp_path):
    gltf = Gltf()
    points, triangles = box()
    tint = np.concatenate([points, np.ones((8, 1))], axis=1).astype(np.float32)
    gltf.node(mesh=gltf.mesh(points, triangles, attributes={"COLOR_0": gltf.accessor(tint)}), name="analysis")
    mesh = imported(blend, tmp_path, gltf).all_objects["analysis"].data
    assert ("VERTEX_COLOR", "Color", "BSDF_PRINCIPLED", "Base Color") in links(mesh.materials[0])
    node = next(node for node in mesh.materials[0].node_tree.nodes if node.type == "VERTEX_COLOR")
    attribute = mesh.color_attributes[node.layer_name]
    corners = np.array([mesh.vertices[loop.vertex_index].co for loop in mesh.loops])
    assert np.allclose([d.color[:3] for d in attribute.data], np.stack([corners[:, 0], corners[:, 2], -corners[:, 1]], axis=1), atol=1e-6)
    assert np.allclose(mesh.materials[0].diffuse_color, [0.5, 0.5, 0.5, 1], atol=0.05)


def test_lamps_cameras_and_hidden_parts_are_blenders(blend, tmp_path):
    lights = [{"type": "directional", "intensity": 3}, {"type": "spot", "intensity": 1, "spot": {"outerConeAngle": 0.5}}]
    gltf = Gltf(extensions={"KHR_lights_punctual": {"lights": lights}})
    gltf.node(mesh=gltf.mesh(*box()), name="Box")
    gltf.node(mesh=0, name="space", extensions={"KHR_node_visibility": {"visible": False}})
    gltf.node(name="Sun", extensions={"KHR_lights_punctual": {"light": 0}})
    gltf.node(name="Spot", extensions={"KHR_lights_punctual": {"light": 1}}, translation=[0, 3, 0])
    gltf.add("cameras", type="perspective", perspective={"yfov": 0.7, "znear": 0.25, "zfar": 80})
    gltf.node(name="Cam", camera=0, translation=[0, 0, 4])
    objects = imported(blend, tmp_path, gltf).all_objects
    assert (objects["Sun"].data.type, objects["Sun"].data.energy) == ("SUN", 3.0)
    assert (objects["Spot"].data.type, objects["Spot"].data.spot_size) == ("SPOT", 1.0)
    assert np.allclose(objects["Spot"].matrix_world.translation, [0, 0, 3])
    camera = objects["Cam"].data
    assert (camera.clip_start, camera.clip_end, camera.sensor_fit) == (0.25, 80.0, "VERTICAL")
    assert camera.angle_y == pytest.approx(0.7)
    assert np.allclose(-np.array(objects["Cam"].matrix_world)[:3, 2], [0, 1, 0], atol=1e-6)
    assert objects["space"].hide_render
    assert objects["space"].hide_viewport
    assert not objects["Box"].hide_render
