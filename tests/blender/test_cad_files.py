"""CAD files in, models and Blender objects out: the real models against their manifest, every format round, every kind of bad file."""

import json
import struct
import zipfile

import numpy as np
import pytest

from addon.blender.cad_import import to_blender
from addon.errors import CadFileError
from addon.scene import cad
from addon.scene.cad_model import CadMesh, CadModel, CadPart

CUBE_OBJ = "".join(f"v {x} {y} {z}\n" for x in (0, 2) for y in (0, 4) for z in (0, 6))
FACES = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\n{}f 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
MODELS = [
    "featuretype.step",
    "tray_bottom_mm.stl",
    "cycloidal_drive_mm.glb",
    "amazing_hand.glb",
    "tower_crane.glb",
    "industrial_ladder.obj",
    "duplex_house.obj",
    "huldra_utilities.glb",
    "hand_wheel_valve.ply",
    "iea15_floating_turbine.stl",
    "robile_housing.obj",
]


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def triangle_stl(vertices):
    return b" " * 80 + struct.pack("<I", len(vertices)) + b"".join(struct.pack("<12fH", 0, 0, 1, *np.ravel(t), 0) for t in vertices)


def glb(document, data=b""):
    data += b"\0" * (-len(data) % 4)
    if data:
        document["buffers"] = [{"byteLength": len(data)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + (struct.pack("<I4s", len(data), b"BIN\0") + data if data else b"")
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def two_materials_glb():
    """A mesh of two primitives, placed twice below a group that is turned, moved and scaled."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()
    primitives = [{"attributes": {"POSITION": 0}, "material": m} for m in (0, 1)]
    return glb(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [
                {"name": "group", "children": [1, 2], "translation": [0, 5, 0], "scale": [2, 2, 2]},
                {"name": "left", "mesh": 0},
                {"name": "right", "mesh": 0, "translation": [0, 0, 3]},
            ],
            "meshes": [{"name": "plate", "primitives": primitives}],
            "materials": [
                {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [0.5123, 0.01, 0.02, 1]}},
                {"name": "blue", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 0.5], "metallicFactor": 0.25}},
            ],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
        },
        positions,
    )


@pytest.mark.parametrize("name", MODELS)
def test_real_models_are_what_their_manifest_says(cad_dev, name):
    truth = next(m for m in json.loads((cad_dev / "manifest.json").read_text())["models"] if m["file"] == name)
    up = "Z" if truth["up_axis"].startswith("z") else "Y"
    measured = truth["measured"]
    model = cad.read(cad_dev / name, "mm" if truth["metres_per_unit"] == 0.001 else None, up)
    assert model.part_count == measured["parts"] and len(model.meshes) == measured["unique_meshes"]
    assert 0 <= measured["triangles"] - model.triangle_count <= measured["degenerate_triangles"]
    low, high = np.array(measured["bounds"]) * truth["metres_per_unit"]
    if up == "Y":
        low, high = np.array([low[0], -high[2], low[1]]), np.array([high[0], -low[2], high[1]])
    assert np.allclose(model.bounds(), [low, high], atol=1e-5 * truth["metres_per_unit"] + 1e-6 * np.abs([low, high]).max())
    is_guessed = name.endswith((".stl", ".ply", ".obj")) and truth["metres_per_unit"] == 1.0
    assert bool(model.warnings) == (is_guessed or name == "tower_crane.glb")
    assert all(part.name.strip() for part in model.parts)


def test_real_models_become_blender_objects(cad_dev, blend):
    for name, truth in (("amazing_hand.glb", (146, 21)), ("duplex_house.obj", (215, 215))):
        model = cad.read(cad_dev / name)
        collection = to_blender(model, blend.context.scene.collection)
        blend.context.view_layer.update()
        objects = list(collection.all_objects)
        assert len(objects) == truth[0] and len({ob.data for ob in objects}) == truth[1]
        longest = 63 if blend.app.version < (5, 0, 0) else 255
        assert {ob.name for ob in objects} >= {part.name for part in model.parts if len(part.name) <= longest}
        corners = np.array([ob.matrix_world @ v.co for ob in objects for v in ob.data.vertices[:50]])
        assert (corners >= model.bounds()[0] - 1e-4).all() and (corners <= model.bounds()[1] + 1e-4).all()
        assert not any(ob.data.validate() for ob in objects)


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply", "off", "glb", "3mf"])
def test_a_box_comes_through_every_format(tmp_path, suffix):
    path = tmp_path / f"box.{suffix}"
    if suffix == "3mf":
        path.write_bytes(threemf(tmp_path, '<item objectid="1"/>'))
    else:
        import trimesh

        mesh = trimesh.Trimesh(*box_arrays(), process=False)
        mesh.export(path)
    model = cad.read(path, units="m", up="Z")
    assert model.triangle_count == 12 and model.part_count == 1
    assert np.allclose(model.bounds(), [[0, 0, 0], [2, 4, 6]])


def box_arrays():
    points = np.array([[x, y, z] for x in (0, 2) for y in (0, 4) for z in (0, 6)], dtype=float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def threemf(folder, build, extra="", unit="millimeter", triangle_attributes=""):
    points, triangles = box_arrays()
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in points)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}" {triangle_attributes if i else ""}/>' for i, (a, b, c) in enumerate(triangles))
    text = (
        f'<model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>'
        '<basematerials id="9"><base name="paint" displaycolor="#FF0000"/><base name="bare" displaycolor="#00FF0080"/></basematerials>'
        f'<object id="1" name="box" pid="9" pindex="0"><mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh></object>'
        f"{extra}</resources><build>{build}</build></model>"
    )
    with zipfile.ZipFile(folder / "x.zip", "w") as archive:
        archive.writestr("3D/3dmodel.model", text)
    return (folder / "x.zip").read_bytes()


def test_3mf_keeps_its_tree_its_unit_and_its_colours(tmp_path):
    extra = (
        '<object id="2" name="pair"><components><component objectid="1"/><component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>'
        "</components></object>"
    )
    content = threemf(tmp_path, '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 100"/>', extra, "inch", 'pid="9" p1="1"')
    model = cad.read(write(tmp_path / "a.3mf", content))
    assert [p.name for p in model.parts] == ["pair", "box", "box"] and len(model.meshes) == 1 and model.units == "in"
    assert np.allclose(model.bounds(), np.array([[-4, 0, 100], [0, 12, 106]]) * 0.0254)
    colors = np.array([model.materials[i].base_color for i in model.meshes[0].materials])[model.meshes[0].triangle_slots]
    assert np.allclose(colors, [[1, 0, 0, 1]] + [[0, 1, 0, 128 / 255]] * 11)


def test_an_object_that_contains_itself_is_left_out_with_a_warning(tmp_path):
    extra = '<object id="2"><components><component objectid="2"/><component objectid="1"/></components></object>'
    model = cad.read(write(tmp_path / "a.3mf", threemf(tmp_path, '<item objectid="1"/><item objectid="7"/>', extra)))
    assert model.part_count == 1 and "7" in model.warnings[0]


def test_gltf_primitives_are_slots_of_one_mesh_and_nodes_a_tree(tmp_path, blend):
    model = cad.read(write(tmp_path / "a.glb", two_materials_glb()))
    assert [(p.name, p.parent, p.mesh) for p in model.parts] in (
        [("group", -1, -1), ("right", 0, 0), ("left", 0, 0)],
        [("group", -1, -1), ("left", 0, 0), ("right", 0, 0)],
    )
    mesh = model.meshes[0]
    assert mesh.triangle_slots.tolist() == [0, 1] and [model.materials[i].name for i in mesh.materials] == ["red", "blue"]
    assert model.materials[0].base_color == (0.5123, 0.01, 0.02, 1.0), "not rounded to bytes"
    assert np.allclose(model.bounds(), [[0, -6, 5], [2, 0, 7]])
    collection = to_blender(model, blend.context.scene.collection)
    blend.context.view_layer.update()
    right = collection.all_objects["right"]
    assert right.parent.name == "group" and right.data is collection.all_objects["left"].data
    assert np.allclose(right.matrix_world.translation, (0, -6, 5)) and [m.name for m in right.data.materials] == ["red", "blue"]
    assert [p.material_index for p in right.data.polygons] == [0, 1]


def test_units_and_up_can_be_set_and_are_told(tmp_path):
    path = write(tmp_path / "a.stl", triangle_stl([[[0, 0, 0], [1000, 0, 0], [0, 500, 0]]]))
    guessed, told = cad.read(path), cad.read(path, "millimetre", "y")
    assert "metres" in guessed.warnings[0] and np.allclose(guessed.bounds()[1], [1000, 500, 0])
    assert told.warnings == () and np.allclose(told.bounds(), [[0, 0, 0], [1, 0, 0.5]]) and (told.units, told.up) == ("mm", "Y")
    for wrong in ({"units": "furlong"}, {"up": "W"}):
        with pytest.raises(CadFileError, match="choose one of"):
            cad.read(path, **wrong)


@pytest.mark.parametrize("up", cad.UPS)
def test_turning_up_is_a_rotation_that_sends_the_axis_up(up):
    from addon.scene.cad.units import z_up_from

    turn = z_up_from(up)
    axis = np.eye(3)["XYZ".index(up[-1])] * (-1 if up[0] == "-" else 1)
    assert np.allclose(turn @ axis, [0, 0, 1]) and np.isclose(np.linalg.det(turn), 1) and np.allclose(turn @ turn.T, np.eye(3))


@pytest.mark.parametrize(
    ("lines", "names"),
    [
        ("o Pipe_Steel\n" + FACES.format("o Flange\n"), ["Pipe_Steel", "Flange"]),
        ("g left\n" + FACES.format("g right\n"), ["left", "right"]),
        (FACES.format(""), ["a"]),
    ],
)
def test_obj_parts_are_its_objects_else_its_groups(tmp_path, lines, names):
    model = cad.read(write(tmp_path / "a.obj", CUBE_OBJ + lines))
    assert sorted(p.name for p in model.parts) == sorted(names) and model.triangle_count == 12


def test_obj_materials_are_slots_of_their_part(tmp_path):
    write(tmp_path / "a.mtl", "newmtl Steel\nKd 0.5 0.25 0.1\nd 0.5\nnewmtl unread\nKd x y z\n")
    text = "mtllib a.mtl\n" + CUBE_OBJ + "o Pipe_Steel\nusemtl Steel\n" + FACES.format("usemtl unknown\n")
    model = cad.read(write(tmp_path / "a.obj", text))
    assert [p.name for p in model.parts] == ["Pipe_Steel"] and model.triangle_count == 12
    colors = np.array([model.materials[i].base_color for i in model.meshes[0].materials])[model.meshes[0].triangle_slots]
    assert np.allclose(colors, [[0.5, 0.25, 0.1, 0.5]] * 6 + [[0.8, 0.8, 0.8, 1]] * 6)


def test_obj_indices_may_count_backwards_from_where_they_stand(tmp_path):
    triangle = "v {0} 0 0\nv {1} 0 0\nv {0} 1 0\nvn 0 0 1\nf -3//-1 -2//-1 -1//-1\n"
    text = "o one\n" + triangle.format(0, 1) + "o two\n" + triangle.format(5, 7)
    model = cad.read(write(tmp_path / "a.obj", text), up="Z")
    assert [m.positions[:, 0].max() for m in model.meshes] == [1, 7] and all(np.allclose(m.normals, [0, 0, 1]) for m in model.meshes)


def area(model):
    p = model.meshes[0].positions[model.meshes[0].triangles].astype(float)
    return np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3)],
        [(0, 0), (2, 1), (4, 0), (2, 4)],
        [(0, 0), (5, 0), (5, 5), (4, 5), (4, 1), (3, 1), (3, 5), (2, 5), (2, 1), (1, 1), (1, 5), (0, 5)],
    ],
)
@pytest.mark.parametrize("is_reversed", [False, True])
def test_polygons_that_are_not_convex_are_covered_once(tmp_path, corners, is_reversed):
    corners = corners[::-1] if is_reversed else corners
    x, y = np.array(corners, dtype=float).T
    wanted = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2 * np.sqrt(2)
    text = "".join(f"v {a} {b} {b}\n" for a, b in corners) + "f " + " ".join(str(i + 1) for i in range(len(corners))) + "\n"
    for shift in range(len(corners)):
        face = " ".join(str((i + shift) % len(corners) + 1) for i in range(len(corners)))
        model = cad.read(write(tmp_path / "a.obj", text.split("f ")[0] + f"f {face} # a comment\n"), up="Z")
        assert model.triangle_count == len(corners) - 2 and np.isclose(area(model), wanted)


def test_obj_lines_of_any_make_are_read(tmp_path):
    text = "# made by hand\r\nv 0 0 0 1.0\r\nv 1 0 0\r\nv\t0  1 0\r\nvt 0 0\r\nf 1/1 2/1 \\\r\n 3\r\nf 1 2 9\r\nf 1 2\r\nl 1 2\r\n"
    model = cad.read(write(tmp_path / "a.obj", text), up="Z")
    assert model.triangle_count == 1 and any("1 faces" in w for w in model.warnings)


def test_a_missing_material_file_is_a_warning(tmp_path):
    model = cad.read(write(tmp_path / "a.obj", "mtllib gone.mtl\n" + CUBE_OBJ + "usemtl x\n" + FACES.format("")))
    assert any("gone.mtl" in w for w in model.warnings)


def test_vertex_colours_become_materials(tmp_path):
    import trimesh

    points, triangles = box_arrays()
    colors = np.tile([[255, 0, 0, 255]], (len(points), 1)).astype(np.uint8)
    trimesh.Trimesh(points, triangles, vertex_colors=colors, process=False).export(tmp_path / "a.ply")
    model = cad.read(tmp_path / "a.ply")
    assert np.allclose([m.base_color for m in model.materials], [[1, 0, 0, 1]])


def test_own_normals_survive_into_blender(tmp_path, blend):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\nf 1//1 2//1 3//1\n"
    model = cad.read(write(tmp_path / "a.obj", text), up="Z")
    collection = to_blender(model, blend.context.scene.collection)
    mesh = collection.all_objects[0].data
    assert mesh.has_custom_normals and np.allclose([n.vector for n in mesh.corner_normals], [[0.6, 0, 0.8]] * 3, atol=1e-4)


def test_bad_vertices_and_flat_faces_are_left_out_with_a_count(tmp_path):
    bad = [
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [[0, 0, 0], [1, 0, 0], [np.nan, 1, 0]],
        [[0, 0, 0], [np.inf, 0, 0], [0, 1, 0]],
        [[0, 0, 0], [1, 1, 1], [2, 2, 2]],
    ]
    model = cad.read(write(tmp_path / "a.stl", triangle_stl(bad)))
    assert model.triangle_count == 1 and np.isfinite(model.meshes[0].positions).all()
    assert any("2 vertices" in w and "2 faces that use them" in w and "1 faces without area" in w for w in model.warnings)


def test_a_part_500_kilometres_away_keeps_its_millimetres(tmp_path):
    lines = "".join(f"v {500_000 + x:.4f} {y:.4f} {4_000_000 + z:.4f}\n" for x, y, z in ((0, 0, 0), (0.001, 0, 0), (0, 0.001, 0.002)))
    model = cad.read(write(tmp_path / "a.obj", lines + "f 1 2 3\n"), up="Z")
    size = model.bounds()[1] - model.bounds()[0]
    assert np.allclose(size, [0.001, 0.001, 0.002], rtol=1e-5) and np.allclose(model.bounds()[0], [500_000, 0, 4_000_000])


BAD = {
    "missing.stl": (None, "does not exist"),
    "empty.stl": (b"", "0 bytes"),
    "text.step": ("hello", "no STEP data"),
    "photo.jpg": (b"x", "no CAD file"),
    "renamed.stl": (two_materials_glb(), "rename it to renamed.glb"),
    "renamed.glb": (CUBE_OBJ + FACES.format(""), "rename it to renamed.obj"),
    "broken.step": ("ISO-10303-21;\nHEADER;\ngarbage", "cannot be read as STEP"),
    "cut.glb": (two_materials_glb()[:200], "cannot be read"),
    "points.obj": (CUBE_OBJ, "no face"),
    "flat.stl": (triangle_stl([[[0, 0, 0], [1, 0, 0], [2, 0, 0]]]), "without area"),
    "nan.stl": (triangle_stl([[[np.nan, 0, 0], [1, 0, 0], [0, 1, 0]]]), "NaN"),
    "none.stl": (triangle_stl([]), "no face"),
    "noise.off": (bytes(range(256)), "damaged or of another type"),
    "unzipped.3mf": (b"PK\x03\x04 and no more", "cannot be read"),
    "outside.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "cannot be read"),
    "header.ply": ("ply\nformat ascii 1.0\nend_header\n", "cannot be read|no face"),
    "draco.glb": (glb({"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression"]}), "no face"),
    "unplaced.glb": (two_materials_glb().replace(b'"nodes": [0]', b'"nodes":  []'), "places none"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_one_line_that_says_what_to_do(tmp_path, name):
    content, expected = BAD[name]
    if content is not None:
        write(tmp_path / name, content)
    with pytest.raises(CadFileError, match=expected) as raised:
        cad.read(tmp_path / name)
    message = str(raised.value)
    assert "\n" not in message and name.split(".")[0] in message and len(message) < 300


def test_a_folder_is_no_file(tmp_path):
    (tmp_path / "a.stl").mkdir()
    with pytest.raises(CadFileError, match="folder"):
        cad.read(tmp_path / "a.stl")


def test_a_failure_half_way_leaves_the_users_file_as_it_was(blend):
    triangle = CadMesh("m", np.eye(3), np.array([[0, 1, 2]]))
    broken = CadModel("broken", (triangle,), (CadPart("a", -1, 0, np.eye(4)), CadPart("b", -1, 5, np.eye(4))))
    before = {kind: len(getattr(blend.data, kind)) for kind in ("objects", "meshes", "materials", "collections")}
    with pytest.raises(IndexError):
        to_blender(broken, blend.context.scene.collection)
    assert before == {kind: len(getattr(blend.data, kind)) for kind in before}
    assert not blend.context.scene.collection.children


@pytest.mark.parametrize(("faces", "count"), [(["4 0 1 2 3"], 2), (["4 0 1 2 3", "3 0 1 2"], 3), (["5 0 1 2 3 4"], 3)])
@pytest.mark.parametrize("suffix", ["ply", "off"])
def test_polygons_of_ply_and_off_become_triangles(tmp_path, suffix, faces, count):
    header = {
        "off": f"OFF\n5 {len(faces)} 0\n",
        "ply": "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n",
    }[suffix]
    text = header + "0 0 0\n2 0 0\n2 2 0\n0 2 0\n-1 1 0\n" + "".join(f + "\n" for f in faces)
    model = cad.read(write(tmp_path / f"a.{suffix}", text))
    assert model.triangle_count == count and area(model) == (6 if count == 3 and len(faces) == 2 else 4 + (len(faces[0]) > 9))
