"""Files that are valid and odd: what each format allows and few writers do, with what is right of each."""

import base64
import json
import math
import struct
import zipfile

import numpy as np
import pytest

from addon.scene import cad
from tests.cad.gltf_writer import Gltf, box
from tests.cad.measured import area, color_of, colors, names, world_triangles

POINTS, TRIANGLES = box()
CUBE = "".join(f"v {x:g} {y:g} {z:g}\n" for x, y, z in POINTS)
FACES = "".join("f " + " ".join(str(k + 1) for k in t) + "\n" for t in TRIANGLES)
CASES = {}


def case(name, *args):
    """Register a maker of `name`, a file in the folder it is given, and the check it returns."""

    def keep(make):
        CASES[f"{make.__name__} {args[0] if args else ''}".strip()] = (name, make, args)
        return make

    return keep


def one_box(**header):
    gltf = Gltf(**header)
    gltf.node(mesh=gltf.mesh(*box(), name="Box"), name="Box")
    return gltf


@case("a.glb")
def sparse_without_a_view_moves_all(folder):
    gltf = one_box()
    accessor = gltf.document["accessors"][0]
    rows = np.asarray(POINTS * 2, "<f4").tobytes()
    del accessor["bufferView"]
    accessor["sparse"] = {
        "count": 8,
        "indices": {"bufferView": gltf.view(np.arange(8, dtype=np.uint8).tobytes()), "componentType": 5121},
        "values": {"bufferView": gltf.view(rows)},
    }
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: math.isclose(area(m), 24.0)


@case("a.gltf")
def data_uris_may_be_percent_encoded_and_have_parameters(folder):
    gltf = one_box()
    body = base64.b64encode(gltf.blob).decode().replace("+", "%2B").replace("/", "%2F").replace("=", "%3D")
    (folder / "a.gltf").write_bytes(gltf.gltf("data:application/gltf-buffer;charset=x;base64," + body))
    return lambda m: math.isclose(area(m), 6.0)


@case("a.glb")
def buffers_may_lie_in_several_places(folder):
    gltf = one_box()
    (folder / "second.bin").write_bytes(gltf.blob)
    data = "data:application/octet-stream;base64," + base64.b64encode(gltf.blob).decode()
    gltf.document["buffers"] = [
        {"byteLength": len(gltf.blob)},
        {"byteLength": len(gltf.blob), "uri": "second.bin"},
        {"byteLength": len(gltf.blob), "uri": data},
    ]
    for number, view in enumerate(gltf.document["bufferViews"]):
        view["buffer"] = number + 1
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: math.isclose(area(m), 6.0)


@case("a.glb")
def a_mirroring_matrix_keeps_faces_outwards(folder):
    gltf = Gltf()
    gltf.node(mesh=gltf.mesh(*box()), matrix=[-2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1])
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: np.allclose(m.bounds(), [[3, -1, 0], [5, 0, 1]]) and np.linalg.det(m.world_from_part()[0][:3, :3]) < 0


@case("a.glb")
def morph_weights_of_the_node_win_over_the_meshs(folder):
    gltf = Gltf()
    target = {"POSITION": gltf.accessor(np.asarray(POINTS, np.float32))}
    mesh = gltf.mesh(*box(), targets=[target])
    gltf.document["meshes"][mesh]["weights"] = [1.0]
    gltf.node(mesh=mesh, name="Still", weights=[0.0])
    gltf.node(mesh=mesh, name="Grown", weights=[2.0], translation=[10, 0, 0])
    gltf.node(mesh=mesh, name="Own", translation=[20, 0, 0])
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: [round(float(np.ptp(world_triangles(m, i)[..., 0])), 6) for i in range(3)] == [1.0, 3.0, 2.0]


@case("a.glb")
def a_skinned_mesh_stands_where_its_joints_put_it_or_says_so(folder):
    gltf = one_box()
    gltf.add("skins", joints=[0])
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: m.triangle_count == 12 and any("skeleton" in line for line in m.warnings)


@case("a.glb")
def masked_materials_and_variants_show_their_default(folder):
    gltf = Gltf(extensionsUsed=["KHR_materials_variants"], extensions={"KHR_materials_variants": {"variants": [{"name": "Blue"}]}})
    for color in ([1, 0, 0, 1], [0, 0, 1, 1]):
        gltf.add("materials", pbrMetallicRoughness={"baseColorFactor": color}, alphaMode="MASK", alphaCutoff=0.5)
    variants = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}
    gltf.node(mesh=gltf.mesh(*box(), material=0, extensions=variants), name="A")
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: color_of(m, "A").tolist() == [1, 0, 0, 1]


@case("a.glb")
def indices_of_bytes_and_strips_that_begin_anew(folder):
    gltf = Gltf()
    index = gltf.accessor(np.array([0, 1, 3, 2, 2, 2, 4, 4, 6, 5, 7], np.uint8))  # the degenerate ones join two strips
    position = gltf.accessor(np.asarray(POINTS, np.float32))
    gltf.add("meshes", primitives=[{"attributes": {"POSITION": position}, "indices": index, "mode": 5}])
    gltf.node(mesh=0)
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: area(m) > 1.0


@case("a.gltf")
def names_may_be_of_any_script_and_escaped(folder):
    gltf = one_box()
    gltf.document["nodes"][0]["name"] = 'Клапан \ud83d\udd29 "A"'
    text = json.dumps(json.loads(gltf.gltf()), ensure_ascii=True)
    (folder / "a.gltf").write_text(text)
    return lambda m: names(m) == ['Клапан 🔩 "A"']


@case("a.glb")
def texture_coordinates_are_turned_by_their_transform(folder):
    gltf = Gltf()
    png = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==")
    gltf.add("images", bufferView=gltf.view(png), mimeType="image/png")
    gltf.add("textures", source=0)
    transform = {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2]}}
    gltf.add("materials", pbrMetallicRoughness={"baseColorTexture": {"index": 0, "extensions": transform}})
    uvs = gltf.accessor(np.asarray(POINTS[:, :2], np.float32))
    gltf.node(mesh=gltf.mesh(*box(), material=0, attributes={"TEXCOORD_0": uvs}))
    (folder / "a.glb").write_bytes(gltf.glb())
    return lambda m: np.allclose([m.meshes[0].corner_uvs.min(axis=(0, 1)), m.meshes[0].corner_uvs.max(axis=(0, 1))], [[0.5, -1], [2.5, 1]])


@case("a.obj")
def lines_may_go_on_behind_a_backslash(folder):
    (folder / "a.obj").write_text(CUBE + FACES.replace("f ", "f \\\n  "))
    return lambda m: math.isclose(area(m), 6.0)


@case("a.obj")
def material_libraries_may_come_behind_their_use(folder):
    (folder / "a.mtl").write_text("newmtl Red paint\nKd 1 0 0\n")
    (folder / "a.obj").write_text("o A B\nusemtl Red paint\n" + CUBE + FACES + "mtllib a.mtl\n")
    return lambda m: names(m) == ["A B"] and color_of(m, "A B").tolist() == [1, 0, 0, 1]


@case("a.obj")
def smoothing_groups_levels_and_display_settings_are_no_faces(folder):
    rest = "s 1\ns off\nlod 2\nbevel on\nc_interp off\nd_interp off\nmg 1 0.5\nshadow_obj x\nctech cparm 1\n"
    (folder / "a.obj").write_text(CUBE + rest + FACES)
    return lambda m: m.triangle_count == 12


@case("a.obj")
def weights_behind_coordinates_are_no_colours(folder):
    (folder / "a.obj").write_text("".join(line + " 1.0\n" for line in CUBE.splitlines()) + FACES)
    return lambda m: math.isclose(area(m), 6.0) and not m.materials


@case("a.obj")
def numbers_may_be_written_in_any_form(folder):
    (folder / "a.obj").write_text(CUBE.replace("v 0 0 0", "v\t-0.0e0   +0.\t.0E+00") + FACES)
    return lambda m: np.allclose(m.bounds(), [[0, -1, 0], [1, 0, 1]])


@case("a.obj")
def absolute_and_relative_indices_may_stand_in_one_face(folder):
    (folder / "a.obj").write_text(CUBE + "f 1 -7 4\n" + FACES[FACES.index("\n") + 1 :])
    return lambda m: math.isclose(area(m), 6.0)


@case("a.obj")
def empty_groups_are_no_parts(folder):
    (folder / "a.obj").write_text("g\ng default\n" + CUBE + "g Empty\ng Body Left\n" + FACES)
    return lambda m: names(m) == ["Body Left"]


def ply(header, data):
    return ("ply\n" + header + "end_header\n").encode() + data


@case("a.ply", "big")
def ply_of_every_order_and_count_type(folder, order):
    mark = ">" if order == "big" else "<"
    header = (
        f"format binary_{order}_endian 1.0\ncomment x\nobj_info y\nelement camera 1\nproperty double f\nproperty list uint16 int8 l\n"
        "element vertex 8\nproperty float64 x\nproperty double y\nproperty float z\n"
        "element face 12\nproperty uchar flags\nproperty list uint32 int16 vertex_index\nproperty list uchar float texcoord\n"
    )
    data = struct.pack(mark + "dHbb", 1.0, 2, 3, 4)
    data += b"".join(struct.pack(mark + "ddf", *p) for p in POINTS)
    data += b"".join(struct.pack(mark + "BI3hB", 7, 3, *t, 0) for t in TRIANGLES)
    (folder / "a.ply").write_bytes(ply(header, data))
    return lambda m: math.isclose(area(m), 6.0)


@case("a.ply")
def faces_of_a_ply_may_stand_before_its_vertices(folder):
    faces = "".join(f"3 {a} {b} {c}\n" for a, b, c in TRIANGLES)
    points = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS)
    header = "format ascii 1.0\nelement face 12\nproperty list uchar int vertex_indices\nelement vertex 8\n"
    header += "".join(f"property float {k}\n" for k in "xyz")
    (folder / "a.ply").write_bytes(ply(header, (faces + points).encode()))
    return lambda m: math.isclose(area(m), 6.0)


@case("a.ply")
def colours_of_faces_in_a_ply(folder):
    faces = "".join(f"3 {a} {b} {c} 255 0 0\n" for a, b, c in TRIANGLES)
    points = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS)
    header = "format ascii 1.0\nelement vertex 8\n" + "".join(f"property float {k}\n" for k in "xyz")
    header += "element face 12\nproperty list uchar int vertex_indices\n" + "".join(
        f"property uchar {k}\n" for k in ("red", "green", "blue")
    )
    (folder / "a.ply").write_bytes(ply(header, (points + faces).encode()))
    return lambda m: color_of(m, "a").tolist() == [1, 0, 0, 1]


@case("a.ply")
def line_ends_of_windows_in_a_binary_ply(folder):
    header = "format binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 12\nproperty list uchar int vertex_indices\n"
    data = POINTS.astype("<f4").tobytes() + b"".join(struct.pack("<B3i", 3, *t) for t in TRIANGLES)
    (folder / "a.ply").write_bytes(("ply\n" + header + "end_header\n").replace("\n", "\r\n").encode() + data)
    return lambda m: math.isclose(area(m), 6.0)


@case("a.stl")
def solids_without_names_and_with_equal_ones(folder):
    solid = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in POINTS[t]) + "endloop\nendfacet\n"
        for t in TRIANGLES
    )
    (folder / "a.stl").write_text(f"solid\n{solid}endsolid\nsolid A\n{solid}endsolid A\nsolid A\n{solid}endsolid A\n")
    return lambda m: names(m) == ["a", "A", "A"] and math.isclose(area(m), 18.0)


@case("a.stl")
def a_solid_named_vertex_is_no_corner(folder):
    solid = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in POINTS[t]) + "endloop\nendfacet\n"
        for t in TRIANGLES
    )
    (folder / "a.stl").write_text(f"solid vertex 1 2 3\n{solid}endsolid vertex 1 2 3\n")
    return lambda m: names(m) == ["vertex 1 2 3"] and m.triangle_count == 12


@case("a.stl")
def a_text_stl_on_lines_of_windows_with_tabs(folder):
    solid = "".join(
        "\tFACET NORMAL 0 0 0\r\n\t\tOUTER LOOP\r\n"
        + "".join(f"\t\t\tVERTEX\t{x:e}\t{y:e}\t{z:e}\r\n" for x, y, z in POINTS[t])
        + "\t\tENDLOOP\r\n\tENDFACET\r\n"
        for t in TRIANGLES
    )
    (folder / "a.stl").write_bytes(f"SOLID Ventil, links\r\n{solid}ENDSOLID\r\n".encode())
    return lambda m: names(m) == ["Ventil, links"] and math.isclose(area(m), 6.0)


OFF_POINTS = "".join(f"{x:g} {y:g} {z:g}\n" for x, y, z in POINTS)
OFF_FACES = "".join(f"3 {a} {b} {c}\n" for a, b, c in TRIANGLES)


@case("a.off", "COFF")
@case("a.off", "NOFF")
@case("a.off", "STOFF")
@case("a.off", "4OFF")
def off_with_more_than_places(folder, head):
    more = {"COFF": " 255 0 0 255", "NOFF": " 0 0 1", "STOFF": " 0.5 0.5", "4OFF": " 1"}[head]
    points = "".join(line + more + "\n" for line in OFF_POINTS.splitlines())
    (folder / "a.off").write_text(f"{head}\n8 12 0\n{points}{OFF_FACES}")
    return lambda m: math.isclose(area(m), 6.0) and (head != "COFF" or color_of(m, "a").tolist() == [1, 0, 0, 1])


@case("a.off")
def off_with_comments_and_counts_on_its_first_line(folder):
    (folder / "a.off").write_text(f"OFF 8 12 0 # made by hand\n# corners\n{OFF_POINTS}\n# faces\n{OFF_FACES}")
    return lambda m: math.isclose(area(m), 6.0)


MODEL = '<model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"{more}><resources>{inside}</resources>{build}</model>'
MESH = (
    "<mesh><vertices>" + "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in POINTS) + "</vertices><triangles>"
    + "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in TRIANGLES) + "</triangles></mesh>"
)  # fmt: skip


def write_3mf(folder, models):
    with zipfile.ZipFile(folder / "a.3mf", "w", zipfile.ZIP_DEFLATED) as archive:
        relation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
        target = f'<Relationship Target="/{next(iter(models))}" Id="r" Type="{relation}"/>'
        archive.writestr("_rels/.rels", f"<Relationships>{target}</Relationships>")
        for name, text in models.items():
            archive.writestr(name, text)


@case("a.3mf", "inch")
@case("a.3mf", "micron")
@case("a.3mf", "foot")
def the_unit_of_a_3mf_and_nested_components(folder, unit):
    moved, turned = ('transform="1 0 0 0 1 0 0 0 1 2 0 0"', 'transform="0 1 0 -1 0 0 0 0 1 0 0 5"')
    pair = f'<component objectid="1" {moved}/><component objectid="1"/>'
    inside = f'<object id="1" name="Pin" type="model">{MESH}</object><object id="2"><components>{pair}</components></object>'
    inside += f'<object id="3"><components><component objectid="2" {turned}/></components></object>'
    build = '<build><item objectid="3"/></build>'
    write_3mf(folder, {"3D/a.model": MODEL.format(unit=unit, more="", inside=inside, build=build)})
    size = {"inch": 0.0254, "micron": 1e-6, "foot": 0.3048}[unit]
    return lambda m: names(m) == ["Pin", "Pin"] and np.allclose(m.bounds() / size, [[-1, 0, 5], [0, 3, 6]], atol=1e-4)


@case("a.3mf")
def the_production_extension_places_objects_of_other_files(folder):
    more = ' xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"'
    root = '<object id="9"><components><component p:path="/3D/parts/pin.model" objectid="1"/></components></object>'
    build = '<build><item objectid="9"/></build>'
    write_3mf(
        folder,
        {
            "3D/a.model": MODEL.format(unit="meter", more=more, inside=root, build=build),
            "3D/parts/pin.model": MODEL.format(unit="meter", more="", inside=f'<object id="1" name="Pin">{MESH}</object>', build=""),
        },
    )
    return lambda m: names(m) == ["Pin"] and math.isclose(area(m), 6.0)


@case("a.3mf")
def base_materials_of_single_triangles(folder):
    inside = '<basematerials id="5"><base name="R" displaycolor="#FF0000"/><base name="B" displaycolor="#0000FF80"/></basematerials>'
    mesh = MESH.replace('v3="3"/>', 'v3="3" pid="5" p1="1"/>', 1)
    inside += f'<object id="1" name="A" pid="5" pindex="0">{mesh}</object>'
    write_3mf(folder, {"3D/a.model": MODEL.format(unit="meter", more="", inside=inside, build='<build><item objectid="1"/></build>')})
    return lambda m: sorted({tuple(np.round(c, 2).tolist()) for c in colors(m, 0)[:, 0]}) == [(0.0, 0.0, 1.0, 0.5), (1.0, 0.0, 0.0, 1.0)]


@pytest.mark.parametrize("name", CASES)
def test_what_is_valid_and_odd_is_read_as_it_was_meant(tmp_path, name):
    file, make, args = CASES[name]
    check = make(tmp_path, *args)
    model = cad.read(tmp_path / file)
    assert check(model), (names(model), model.bounds().tolist(), area(model), model.warnings)
