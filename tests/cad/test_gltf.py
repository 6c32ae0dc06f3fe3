"""glTF as its document says: names, materials by index, every accessor, modes, instances, lights, cameras; what is lost is said."""

import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import CadFileError
from addon.scene import cad
from addon.scene.cad_model import CadCamera, CadLight
from addon.scene.reading import wire
from tests.cad.gltf_writer import Gltf, box
from tests.cad.measured import area, color_of, colors, names, world_triangles


def read(folder, gltf, name="a.glb"):
    path = folder / name
    path.write_bytes(gltf.glb() if name.endswith("glb") else gltf.gltf())
    return cad.read(path)


def one_box(**header):
    gltf = Gltf(**header)
    gltf.node(mesh=gltf.mesh(*box(), name="Box"), name="Box")
    return gltf


def test_names_are_those_of_the_nodes_else_of_their_meshes(tmp_path):
    gltf = Gltf()
    mesh = gltf.mesh(*box(), name="Box")
    given_names = ["Bolt", "Bolt", "Bolt_1", "Wall {A1}", "Wall {A1}", "Ventil/Öl №5 泵", "a_b_c", "{}", "%s", "0"]
    for name in given_names:
        gltf.node(mesh=mesh, name=name)
    gltf.node(mesh=mesh)
    gltf.node(mesh=mesh, name="")
    gltf.node(mesh=gltf.mesh(*box()))
    model = read(tmp_path, gltf)
    assert names(model) == [*given_names, "Box", "Box", "Node 12"]
    assert len(model.meshes) == 2


def test_materials_are_taken_by_their_place_not_by_their_name(tmp_path):
    gltf = Gltf()
    for i, (name, color) in enumerate([("Paint", [1, 0, 0, 1]), ("Paint", [0, 0, 1, 1]), (None, [0, 1, 0, 1]), (None, [1, 1, 0, 1])]):
        material = gltf.add("materials", pbrMetallicRoughness={"baseColorFactor": color}, **({"name": name} if name else {}))
        gltf.node(mesh=gltf.mesh(*box(), material=material), name=f"B{i}")
    model = read(tmp_path, gltf)
    wanted = [[1, 0, 0, 1], [0, 0, 1, 1], [0, 1, 0, 1], [1, 1, 0, 1]]
    assert [color_of(model, f"B{i}").tolist() for i in range(4)] == wanted


def test_specular_glossiness_gives_its_diffuse_colour(tmp_path):
    gltf = Gltf()
    gloss = {"diffuseFactor": [0, 0.5, 0, 1], "glossinessFactor": 0.75}
    gltf.add("materials", name="SG", extensions={"KHR_materials_pbrSpecularGlossiness": gloss})
    gltf.node(mesh=gltf.mesh(*box(), material=0), name="SG")
    (material,) = read(tmp_path, gltf).materials
    assert material.base_color == (0.0, 0.5, 0.0, 1.0)
    assert (material.metallic, material.roughness) == (0.0, 0.25)


@pytest.mark.parametrize(("mode", "alpha"), [(None, 1.0), ("OPAQUE", 1.0), ("BLEND", 0.25), ("MASK", 0.25)])
def test_opacity_counts_only_where_the_material_says_so(tmp_path, mode, alpha):
    gltf = Gltf()
    gltf.add("materials", pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.25]}, **({"alphaMode": mode} if mode else {}))
    gltf.node(mesh=gltf.mesh(*box(), material=0))
    assert read(tmp_path, gltf).materials[0].base_color[3] == alpha


@pytest.mark.parametrize(("dtype", "signed"), [("int8", True), ("uint8", False), ("int16", True), ("uint16", False)])
def test_normalized_integers_are_parts_of_their_largest(tmp_path, dtype, signed):
    most = np.iinfo(dtype).max
    points, triangles = box((most, most, most), (0, 0, 0))
    gltf = Gltf(extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"])
    size = np.dtype(dtype).itemsize
    position = gltf.accessor(points.astype(dtype), stride=4 * size, normalized=True)
    index = gltf.accessor(triangles.astype(np.uint16).ravel())
    gltf.add("meshes", primitives=[{"attributes": {"POSITION": position}, "indices": index}])
    gltf.node(mesh=0, scale=[2, 2, 2])
    model = read(tmp_path, gltf)
    assert np.allclose(model.bounds(), [[0, -2, 0], [2, 0, 2]])
    assert math.isclose(area(model), 24.0, rel_tol=1e-6)
    assert signed == np.issubdtype(np.dtype(dtype), np.signedinteger)


def test_integers_that_are_not_normalized_count_units(tmp_path):
    points, triangles = box((100, 100, 100))
    gltf = Gltf(extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"])
    position = gltf.accessor(points.astype(np.uint16), stride=8)
    gltf.add("meshes", primitives=[{"attributes": {"POSITION": position}, "indices": gltf.accessor(triangles.astype(np.uint16).ravel())}])
    gltf.node(mesh=0, scale=[0.01, 0.01, 0.01])
    assert math.isclose(area(read(tmp_path, gltf)), 6.0, rel_tol=1e-5)


@pytest.mark.parametrize("has_base", [True, False])
def test_sparse_accessors_replace_rows(tmp_path, has_base):
    gltf = Gltf()
    points, triangles = box()
    points = points.astype(np.float32)
    moved = np.flatnonzero(points[:, 1] == 1) if has_base else np.arange(8)
    rows = points[moved] * [1, 3, 1]
    position = gltf.accessor(points) if has_base else gltf.add("accessors", componentType=5126, count=8, type="VEC3")
    gltf.document["accessors"][position]["sparse"] = {
        "count": len(moved),
        "indices": {"bufferView": gltf.view(moved.astype("<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": gltf.view(rows.astype("<f4").tobytes())},
    }
    index = gltf.accessor(triangles.astype(np.uint8).ravel())
    gltf.add("meshes", primitives=[{"attributes": {"POSITION": position}, "indices": index}])
    gltf.node(mesh=0)
    assert math.isclose(area(read(tmp_path, gltf)), 14.0)


@pytest.mark.parametrize(("mode", "order"), [(4, [0, 1, 2, 0, 2, 3, 0, 3, 4]), (5, [1, 2, 0, 3, 4]), (6, [0, 1, 2, 3, 4])])
@pytest.mark.parametrize("has_indices", [True, False])
def test_lists_strips_and_fans_cover_the_pentagon_once_and_face_one_way(tmp_path, mode, order, has_indices):
    turn = np.arange(5) * 2 * np.pi / 5
    points = np.stack([np.cos(turn), np.sin(turn), np.zeros(5)], axis=1)
    gltf = Gltf()
    gltf.node(mesh=gltf.mesh(points, order, mode=mode) if has_indices else gltf.mesh(points[order], None, mode=mode))
    model = read(tmp_path, gltf)
    assert model.triangle_count == 3
    p = world_triangles(model, 0)
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert math.isclose(np.linalg.norm(normal, axis=1).sum() / 2, 2.5 * math.sin(2 * math.pi / 5), rel_tol=1e-6)
    assert (normal[:, 1] < 0).all(), "the file's +Z is the world's −Y"


def test_instances_are_parts_of_one_mesh(tmp_path):
    gltf = Gltf(extensionsUsed=["EXT_mesh_gpu_instancing"], extensionsRequired=["EXT_mesh_gpu_instancing"])
    mesh = gltf.mesh(*box(), name="Box")
    moves = np.stack([2.0 * np.arange(10), np.zeros(10), np.zeros(10)], axis=1).astype(np.float32)
    turns = np.tile(np.array([0, 0, 0, 127], np.int8), (10, 1))
    scales = np.full((10, 3), 0.5, np.float32)
    attributes = {"TRANSLATION": gltf.accessor(moves), "ROTATION": gltf.accessor(turns, normalized=True), "SCALE": gltf.accessor(scales)}
    gltf.node(mesh=mesh, name="Bolts", translation=[0, 0, 5], extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    model = read(tmp_path, gltf)
    assert (model.part_count, model.triangle_count, len(model.meshes)) == (10, 120, 1)
    assert names(model) == ["Bolts"] * 10
    assert np.allclose(model.bounds(), [[0, -5.5, 0], [18.5, -5, 0.5]])


def test_vertex_colours_keep_their_gradient_and_multiply_the_material(tmp_path):
    gltf = Gltf()
    x, z = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)))
    points = np.stack([x, np.zeros(81), z], axis=1)
    cell = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    triangles = np.concatenate([np.stack([cell, cell + 9, cell + 10], 1), np.stack([cell, cell + 10, cell + 1], 1)])
    tint = np.stack([x, np.zeros(81), z, np.ones(81)], axis=1).astype(np.float32)
    gltf.add("materials", name="m", pbrMetallicRoughness={"baseColorFactor": [0.5, 1, 1, 1]})
    gltf.node(mesh=gltf.mesh(points, triangles, material=0, attributes={"COLOR_0": gltf.accessor(tint)}))
    model = read(tmp_path, gltf)
    assert np.allclose(colors(model, 0), tint[triangles] * [0.5, 1, 1, 1], atol=1e-6)
    assert len(model.materials) == 1


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
def test_vertex_colours_of_few_values_become_materials(tmp_path, dtype):
    gltf = Gltf()
    points, triangles = box()
    most = 1 if dtype == "float32" else np.iinfo(dtype).max
    tint = (np.tile([[1, 0, 0]], (8, 1)) * most).astype(dtype)
    extra = {} if dtype == "float32" else {"normalized": True}
    color = gltf.accessor(tint, stride={"uint8": 4, "uint16": 8, "float32": None}[dtype], **extra)
    gltf.node(mesh=gltf.mesh(points, triangles, attributes={"COLOR_0": color}), name="red")
    model = read(tmp_path, gltf)
    assert color_of(model, "red").tolist() == [1, 0, 0, 1]
    assert model.meshes[0].corner_colors is None
    gltf.add("materials", name="Paint", pbrMetallicRoughness={"baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0.25})
    gltf.document["meshes"][0]["primitives"][0]["material"] = 0
    (material,) = read(tmp_path, gltf).materials
    assert (material.name, material.base_color, material.metallic) == ("Paint", (0.5, 0.0, 0.0, 1.0), 0.25)


def test_lights_and_cameras_stand_where_they_stood_and_look_along_their_minus_z(tmp_path):
    lights = [
        {"type": "directional", "intensity": 3, "name": "Sun"},
        {"type": "spot", "intensity": 2, "color": [1, 0.5, 0], "spot": {"outerConeAngle": 0.5, "innerConeAngle": 0.5}},
    ]
    gltf = one_box(extensionsUsed=["KHR_lights_punctual"], extensions={"KHR_lights_punctual": {"lights": lights}})
    half = math.sqrt(0.5)
    down = gltf.node(name="Mast", translation=[0, 7, 0], rotation=[-half, 0, 0, half], extensions={"KHR_lights_punctual": {"light": 0}})
    gltf.node(down, name="Lamp", translation=[0, 0, -2], extensions={"KHR_lights_punctual": {"light": 1}})
    gltf.add("cameras", type="perspective", perspective={"yfov": 0.7, "znear": 0.1})
    gltf.add("cameras", type="orthographic", orthographic={"xmag": 3, "ymag": 2, "znear": 0.1, "zfar": 50})
    gltf.node(name="Cam", camera=0, translation=[0.5, 0.5, 4])
    gltf.node(name="Plan", camera=1)
    model = read(tmp_path, gltf)
    world = dict(zip([p.name for p in model.parts], model.world_from_part(), strict=True))
    item = {part.name: part.item for part in model.parts}
    assert item["Mast"] == CadLight("Sun", "sun", (1.0, 1.0, 1.0), 3.0)
    assert item["Lamp"] == CadLight("Light 1", "spot", (1.0, 0.5, 0.0), 8.0 * math.pi, 1.0, 0.0)
    assert item["Cam"] == CadCamera("Camera 0", 0.7, 0.0, 0.1, None)
    assert item["Plan"] == CadCamera("Camera 1", None, 4.0, 0.1, 50.0)
    assert np.allclose(-world["Mast"][:3, 2], [0, 0, -1])
    assert np.allclose(world["Mast"][:3, 3], [0, 0, 7])
    assert np.allclose(world["Lamp"][:3, 3], [0, 0, 5])
    assert np.allclose(-world["Cam"][:3, 2], [0, 1, 0])
    assert np.allclose(world["Cam"][:3, 1], [0, 0, 1])


def test_photometric_lights_become_watts(tmp_path):
    lights = [{"type": "directional", "intensity": 683.0}, {"type": "point", "intensity": 683.0}]
    gltf = one_box(extensions={"KHR_lights_punctual": {"lights": lights}})
    for i in range(2):
        gltf.node(extensions={"KHR_lights_punctual": {"light": i}})
    items = [part.item for part in read(tmp_path, gltf).parts if part.item]
    assert [light.energy for light in items] == [1.0, pytest.approx(4 * math.pi)]


def test_hidden_nodes_hide_what_is_below_them(tmp_path):
    gltf = one_box()
    group = gltf.node(name="space", extensions={"KHR_node_visibility": {"visible": False}})
    gltf.node(group, name="inner", mesh=0, scale=[9, 9, 9])
    model = read(tmp_path, gltf)
    assert [(p.name, p.is_hidden) for p in model.parts] == [("Box", False), ("space", True), ("inner", True)]
    assert np.allclose(np.ptp(model.bounds(), axis=0), 1.0), "what is hidden does not count"


def test_what_is_left_out_is_counted_and_named(tmp_path):
    gltf = one_box(animations=[{"channels": [], "samplers": []}], skins=[{"joints": [0]}])
    for name, mode in (("Axis", 1), ("Survey", 0), ("Loop", 2)):
        gltf.node(mesh=gltf.mesh(np.eye(3), None, mode=mode, name=name))
    gltf.add("scenes", nodes=[0])
    gltf.add("materials", name="Steel", normalTexture={"index": 0}, occlusionTexture={"index": 0})
    text = "\n".join(read(tmp_path, gltf).warnings)
    for words in (
        "2 sets of lines",
        "Axis, Loop",
        "1 cloud of points was left out (Survey)",
        "1 animation ",
        "1 skeleton",
        "1 further scene",
    ):
        assert words in text
    assert "2 textures other than base colours" in text
    assert "(Steel)" in text


@pytest.mark.parametrize("extension", ["KHR_gaussian_splatting", "VENDOR_unheard_of"])
@pytest.mark.parametrize("is_required", [True, False])
def test_what_is_not_known_is_refused_by_name_unless_it_can_be_done_without(tmp_path, extension, is_required):
    gltf = one_box(extensionsUsed=[extension], **({"extensionsRequired": [extension]} if is_required else {}))
    if is_required:
        with pytest.raises(CadFileError, match=f"requires the glTF extension {extension}.* without"):
            read(tmp_path, gltf)
    else:
        assert read(tmp_path, gltf).triangle_count == 12


@pytest.mark.parametrize("extension", ["KHR_materials_clearcoat", "KHR_texture_transform", "KHR_mesh_quantization"])
def test_extensions_that_change_looks_only_do_not_stop_a_file(tmp_path, extension):
    assert read(tmp_path, one_box(extensionsRequired=[extension])).triangle_count == 12


def test_a_byte_order_mark_is_said_and_read_over(tmp_path):
    path = tmp_path / "bom.gltf"
    path.write_bytes(b"\xef\xbb\xbf" + one_box().gltf())
    model = cad.read(path)
    assert model.triangle_count == 12
    assert any("starts with a byte order mark" in line for line in model.warnings)


@pytest.mark.parametrize(("uri", "file"), [("my%20box.bin", "my box.bin"), ("%C3%9Cber%23.bin", "Über#.bin"), ("plain.bin", "plain.bin")])
def test_uris_may_be_percent_encoded(tmp_path, uri, file):
    gltf = one_box()
    (tmp_path / "a b.gltf").write_bytes(gltf.gltf(uri))
    with pytest.raises(CadFileError, match="is missing: put it beside a b.gltf"):
        cad.read(tmp_path / "a b.gltf")
    (tmp_path / file).write_bytes(gltf.blob)
    assert cad.read(tmp_path / "a b.gltf").triangle_count == 12


BROKEN = {
    "a view beyond its buffer": lambda d: d["bufferViews"][0].update(byteLength=10**9),
    "an accessor beyond its view": lambda d: d["accessors"][0].update(count=10**6),
    "a count without data": lambda d: (
        d["accessors"].append({"componentType": 5126, "count": 10**9, "type": "VEC3"})
        or d["meshes"][0]["primitives"][0]["attributes"].update(POSITION=len(d["accessors"]) - 1)
    ),
    "a negative offset": lambda d: d["bufferViews"][0].update(byteOffset=-4),
    "a mesh that is not there": lambda d: d["nodes"][0].update(mesh=7),
    "nodes that are no objects": lambda d: d.update(nodes=[3]),
    "glTF 1.0": lambda d: d["asset"].update(version="1.0"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_document_that_is_not_whole_is_one_line(tmp_path, name):
    gltf = one_box()
    BROKEN[name](gltf.document)
    with pytest.raises(CadFileError) as caught:
        read(tmp_path, gltf)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


def test_nodes_in_a_circle_or_twice_are_placed_once_with_a_line(tmp_path):
    gltf = one_box()
    gltf.document["nodes"][0]["children"] = [0]
    model = read(tmp_path, gltf)
    assert model.part_count == 1
    assert any("placed twice or within themselves" in line for line in model.warnings)


def test_a_chain_of_ten_thousand_nodes_is_read(tmp_path):
    gltf = one_box()
    above = None
    for i in range(10_000):
        above = gltf.node(above, name=str(i), translation=[0, 0, 0.001])
    gltf.node(above, mesh=0, name="end")
    model = read(tmp_path, gltf)
    assert np.allclose(model.world_from_part()[-1][:3, 3], [0, -10, 0])


WORDS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=12)
UNIT = st.floats(-1, 1, width=32).map(lambda v: 0.0 if abs(v) < 1e-6 else v)


@st.composite
def trees(draw):
    """Nodes (name, parent, translation, rotation, scale, mesh or None) of random shape: mirrored, far away, names of any letters."""
    count = draw(st.integers(1, 8))
    far = draw(st.sampled_from([0.0, 1e3, 5e6]))
    nodes = []
    for i in range(count):
        turn = np.array(draw(st.tuples(UNIT, UNIT, UNIT, UNIT))) + [0, 0, 0, 1.5]
        scale = draw(st.tuples(*[st.sampled_from([-2.0, -1.0, 0.5, 1.0, 3.0])] * 3))
        move = np.array(draw(st.tuples(UNIT, UNIT, UNIT))) * 10.0 + (far if i == 0 else 0.0)
        parent = draw(st.integers(-1, i - 1))
        mesh = draw(st.integers(0, 2)) if i == count - 1 else draw(st.sampled_from([None, 0, 1, 2]))
        nodes.append((draw(WORDS), parent, move, turn / np.linalg.norm(turn), scale, mesh))
    return nodes


@given(trees(), st.booleans())
def test_a_tree_of_any_names_and_places_is_read_back_equal(tmp_path_factory, nodes, as_text):
    gltf = Gltf()
    palette = [(1.0, 0.0, 0.0, 1.0), (0.0, 0.25, 0.0, 1.0), (0.0, 0.0, 0.5, 1.0)]
    for color in palette:
        gltf.add("materials", name="paint", pbrMetallicRoughness={"baseColorFactor": color})
    shapes = [box((1, 2, 3)), box((0.5, 0.5, 0.5), (1, 1, 1)), box((4, 1, 1))]
    for i, shape in enumerate(shapes):
        gltf.mesh(*shape, material=i, name=f"shape {i}")
    for name, parent, move, turn, scale, mesh in nodes:
        place = {"translation": move.tolist(), "rotation": turn.tolist(), "scale": scale}
        gltf.node(None if parent < 0 else parent, name=name, **place, **({} if mesh is None else {"mesh": mesh}))
    model = read(tmp_path_factory.mktemp("tree"), gltf, "a.gltf" if as_text else "a.glb")
    found = {}
    for i, part in enumerate(model.parts):
        if part.mesh >= 0:
            found.setdefault(part.name, []).append((world_triangles(model, i), colors(model, i)[0, 0]))
    for i, (name, *_, mesh) in enumerate(nodes):
        if mesh is None:
            continue
        wanted = placed(nodes, i, *shapes[mesh])
        title = name or f"shape {mesh}"
        close = [c for p, c in found[title] if np.allclose(p, wanted, atol=1e-6 * max(np.abs(wanted).max(), 1.0))]
        assert any(np.allclose(c, palette[mesh]) for c in close), title
    assert model.part_count == sum(node[-1] is not None for node in nodes)


def placed(nodes, i, points, triangles):
    """The triangles' corners in the world, Z up, by quaternions applied one node after the other."""
    while i >= 0:
        _, parent, move, (x, y, z, w), scale, _ = nodes[i]
        v = points * scale
        axis = np.array([x, y, z])
        points = v + 2 * np.cross(axis, np.cross(axis, v) + w * v) + move
        i = parent
    return (points @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]))[triangles]


def test_pictures_of_a_model_named_from_the_current_folder_are_found_from_any(tmp_path, monkeypatch):
    (tmp_path / "rust.png").write_bytes(b"\x89PNG")
    gltf = one_box(images=[{"uri": "rust.png"}], textures=[{"source": 0}])
    gltf.add("materials", pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    gltf.document["meshes"][0]["primitives"][0]["material"] = 0
    (tmp_path / "a.glb").write_bytes(gltf.glb())
    monkeypatch.chdir(tmp_path)
    model = cad.read("a.glb")
    assert model.materials[0].image.path == str(tmp_path / "rust.png")
    assert any("1 set of texture coordinates" in line for line in model.warnings)


def test_pictures_lights_and_colours_come_through_the_reading_process(tmp_path):
    (tmp_path / "rust.png").write_bytes(b"\x89PNG")
    lights = [{"type": "spot", "intensity": 2}]
    gltf = Gltf(extensions={"KHR_lights_punctual": {"lights": lights}}, images=[{"uri": "rust.png"}], textures=[{"source": 0}])
    gltf.add("images", bufferView=gltf.view(b"\x89PNG within"), mimeType="image/png", name="within")
    gltf.add("textures", source=1)
    uvs, tint = gltf.accessor(np.eye(3, 2, dtype=np.float32)), gltf.accessor(np.eye(3, dtype=np.float32))
    for i in range(2):
        material = gltf.add("materials", pbrMetallicRoughness={"baseColorTexture": {"index": i}})
        attributes = {"TEXCOORD_0": uvs, "COLOR_0": tint}
        gltf.node(mesh=gltf.mesh(np.eye(3), [[0, 1, 2]], material=material, attributes=attributes), name=f"plate {i}")
    gltf.node(name="lamp", extensions={"KHR_lights_punctual": {"light": 0}})
    here, stream = read(tmp_path, gltf), io.BytesIO()
    wire.send(stream, here)
    stream.seek(0)
    there = wire.receive(stream)
    assert there.materials == here.materials
    assert [m.image.path or m.image.data for m in there.materials] == [str(tmp_path / "rust.png"), b"\x89PNG within"]
    assert [part.item for part in there.parts] == [part.item for part in here.parts]
    for name in ("corner_colors", "corner_uvs"):
        assert all(np.array_equal(getattr(a, name), getattr(b, name)) for a, b in zip(there.meshes, here.meshes, strict=True))
