"""OBJ, STL, OFF, PLY and 3MF as their authors meant them."""

import io
import struct
import zipfile

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from addon.errors import CadFileError
from addon.scene import cad
from tests.cad.gltf_writer import box
from tests.cad.measured import area, color_of, colors, names, world_triangles

CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
RINGS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
FACES = "".join("f " + " ".join(str(i + 1) for i in ring) + "\n" for ring in RINGS)


@pytest.fixture
def obj(tmp_path):
    """Read an OBJ of this text beside these files."""

    def read(text, name="a.obj", **files):
        for file, content in files.items():
            (tmp_path / file).write_bytes(content)
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return cad.read(path, up="Z")

    return read


def told(model):
    return [line for line in model.warnings if "names no unit" not in line]


# ---- OBJ


def test_polygons_with_holes_keep_them(obj):
    square = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 3 1 0\nv 3 3 0\nv 1 3 0\n"
    assert area(obj(square + "f 1 2 3 4 1 5 8 7 6 5\n")) == pytest.approx(12.0)


@pytest.mark.parametrize(
    "corner", ["{0}", "{0}/", "{0}//", "{0}/{0}", "{0}/{0}/", "{0}//{0}", "{0}/{0}/{0}", "{1}", "{1}//{1}", "{1}/{1}/{1}"]
)
def test_corners_of_any_form_name_the_vertex(obj, corner):
    tables = "".join(f"v {x} {y} 0\nvt {x} {y}\nvn 0 0 1\n" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    text = tables + "f " + " ".join(corner.format(i, i - 5) for i in (1, 2, 3, 4)) + "\n"
    model = obj(text + "v 9 9 9\n")
    assert (model.triangle_count, area(model)) == (2, pytest.approx(1.0))
    assert (model.meshes[0].normals is not None) == ("//{" in corner or corner.count("/{") == 2)


def test_corners_of_different_forms_may_stand_in_one_part(obj):
    tables = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
    assert area(obj(tables + "f 1/1 2 3//1\nf 1/1/1 -2 -1/1\n")) == pytest.approx(1.0)


def test_equal_object_names_are_parts_of_their_own_and_equal_groups_are_one(obj):
    three = obj("".join(f"o Valve\n{CUBE}f {i + 1} {i + 2} {i + 4}\n" for i in (0, 8, 16)))
    assert names(three) == ["Valve"] * 3
    groups = obj(CUBE + "g wall\nf 1 2 3\ng floor\nf 1 2 4\ng wall\nf 5 6 7\n")
    assert names(groups) == ["wall", "floor"]


RED_BLUE = b"newmtl Red\nKd 1 0 0\nnewmtl Blue\nKd 0 0 1\n"
LIBRARIES = {
    "an inline comment": (b"mtllib two.mtl # by hand\nusemtl Red # pump\n", "two.mtl"),
    "another case": (b"mtllib TWO.MTL\nusemtl Red\n", "two.mtl"),
    "an absolute path": (b"mtllib C:\\Users\\x\\Desktop\\two.mtl\nusemtl Red\n", "two.mtl"),
    "several on a line": (b"mtllib other.mtl two.mtl\nusemtl Red\n", "two.mtl"),
    "a name with blanks": (b"mtllib two of them.mtl\nusemtl Red\n", "two of them.mtl"),
    "the model's name": (b"mtllib gone.mtl\nusemtl Red\n", "a.mtl"),
    "no line at all": (b"usemtl Red\n", "a.mtl"),
    "Latin-1": (b"mtllib Tr\xe4ger.mtl\nusemtl Red\n", "Träger.mtl"),
    "a byte order mark": (b"\xef\xbb\xbfmtllib two.mtl\nusemtl Red\n", "two.mtl"),
    "letters and marks apart": ("mtllib Tra\u0308ger.mtl\nusemtl Red\n".encode(), "Träger.mtl"),
}


@pytest.mark.parametrize("name", LIBRARIES)
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_material_files_are_found_however_they_are_named(obj, name, mark):
    head, file = LIBRARIES[name]
    model = obj(head + (CUBE + FACES).encode(), **{file: mark + RED_BLUE})
    assert color_of(model, "a").tolist() == [1, 0, 0, 1]
    assert not [line for line in told(model) if "other.mtl" not in line]


def test_names_in_latin_1_and_behind_a_byte_order_mark_are_read(obj):
    model = obj(b"o Tr\xe4ger\nusemtl Gr\xfcn\n" + (CUBE + FACES).encode(), **{"a.mtl": b"newmtl Gr\xfcn\nKd 0 1 0\n"})
    assert names(model) == ["Träger"]
    assert model.materials[0].name == "Grün"
    assert names(obj(b"\xef\xbb\xbfo Pump\n" + (CUBE + FACES).encode())) == ["Pump"]


@pytest.mark.parametrize(
    ("lines", "opacity"),
    [
        ("Tr 1", 1),
        ("Tr 1.0", 1),
        ("Tr 0", 1),
        ("Tr 0.25", 0.75),
        ("d 0.5", 0.5),
        ("d -halo 0.5", 0.5),
        ("d 0.5\nTr 1", 0.5),
        ("d 1\nTr 0", 1),
    ],
)
def test_opacity_is_what_the_writers_of_material_files_mean(obj, lines, opacity):
    model = obj("usemtl M\n" + CUBE + FACES, **{"a.mtl": f"newmtl M\nKd 1 .5 0\n{lines}\n".encode()})
    assert model.materials[0].base_color[3] == opacity


@pytest.mark.parametrize("line", ["rust.png", "-s 2 2 1 -o 0.5 0 rust.png", "-clamp on rust.png", "..\\maps\\rust.png", "old rust.png"])
def test_a_picture_of_a_material_comes_with_its_coordinates(obj, tmp_path, line):
    file = "old rust.png" if line.startswith("old") else "rust.png"
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl M\nf 1/1 2/2 3/3 4/4\n"
    model = obj(square, **{"a.mtl": f"newmtl M\nKd 0 0 0\nmap_Kd {line}\nmap_Bump bump.png\n".encode(), file: b"\x89PNG"})
    (material,) = model.materials
    assert material.image.path == str(tmp_path / file)
    assert material.base_color == (1.0, 1.0, 1.0, 1.0)
    mesh = model.meshes[0]
    assert np.allclose(mesh.corner_uvs, mesh.positions[mesh.triangles][..., :2])
    assert any("1 texture other than base colours" in line for line in told(model))


def test_lines_points_and_curves_are_counted_with_the_part_they_belong_to(obj):
    text = "\n".join(told(obj(f"o frame\n{CUBE}{FACES}l 1 2 3 4\np 1\np 2\ncurv 0 1 1 2\n")))
    for words in ("1 line was left out (frame)", "2 points were left out (frame)", "1 curve was left out (frame)"):
        assert words in text


def test_decimal_commas_are_read_and_said(obj):
    model = obj(CUBE.replace("1", "1,5") + FACES)
    assert np.allclose(model.bounds()[1], 1.5)
    assert any("decimal commas" in line for line in told(model))
    with pytest.raises(CadFileError, match="with commas and with points"):
        obj("v 1,5 2.5 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")


def test_relative_indices_count_back_from_their_line_whatever_stands_between(obj):
    strip = "".join(
        f"v {i} 0 0\nv {i + 1} 0 0\nv {i + 1} 1 0\nv {i} 1 0\nvn 0 0 1\nf -4//-1 -3//-1 -2//-1 -1//-1\n" for i in range(0, 600, 2)
    )
    model = obj(strip)
    assert (model.triangle_count, area(model)) == (600, pytest.approx(300.0))
    assert np.allclose(model.bounds(), [[0, 0, 0], [599, 1, 0]])


def test_relative_indices_cost_no_walk_over_the_faces(obj, monkeypatch):
    seen = []
    monkeypatch.setattr("addon.scene.cad.obj.triangulate", lambda p, s: seen.append(len(s)) or triangulate(p, s))
    from addon.scene.cad.polygons import triangulate

    obj("".join(f"v {i} 0 0\nv {i} 1 0\nv {i + 1} 0 0\nf -3 -2 -1\n" for i in range(2000)))
    assert seen == [2000], "all faces of a part are one run"


def test_vertex_colours_may_run_to_one_or_to_255(obj):
    for most in (1, 255):
        text = "".join(line + f" {most} 0 0\n" for line in CUBE.splitlines())
        assert color_of(obj(text + FACES), "a").tolist() == [1, 0, 0, 1]


NAMES = st.text(st.characters(exclude_categories=["Cs", "Cc", "Zl", "Zp", "Zs"], exclude_characters="#\\"), min_size=1, max_size=10)


@given(
    st.lists(st.tuples(NAMES, st.sampled_from("abc"), st.integers(-50, 50), st.booleans()), min_size=1, max_size=6),
    st.sampled_from(["\n", "\r\n"]),
)
@settings(max_examples=40)
def test_obj_parts_of_any_names_colours_and_places_are_read_back_equal(tmp_path_factory, parts, newline):
    folder = tmp_path_factory.mktemp("obj")
    palette = {"a": (1, 0, 0), "b": (0, 0.5, 0), "c": (0.25, 0.25, 1)}
    (folder / "p.mtl").write_text("".join(f"newmtl {key}\nKd {r} {g} {b}\n" for key, (r, g, b) in palette.items()))
    lines = ["mtllib p.mtl"]
    for i, (name, material, x, relative) in enumerate(parts):
        points, _ = box((1, 2, 3), (x, 0, 0))
        lines += [f"o {name}", *(f"v {a} {b} {c}" for a, b, c in points), f"usemtl {material}"]
        lines += ["f " + " ".join(str(k - 8 if relative else 8 * i + k + 1) for k in ring) for ring in RINGS]
    (folder / "a.obj").write_bytes(newline.join(lines).encode())
    model = cad.read(folder / "a.obj", up="Z")
    assert names(model) == [name for name, *_ in parts]
    for i, (_, material, x, _) in enumerate(parts):
        p = world_triangles(model, i).reshape(-1, 3)
        assert np.allclose([p.min(axis=0), p.max(axis=0)], [[x, 0, 0], [x + 1, 2, 3]])
        assert np.allclose(colors(model, i)[..., :3], palette[material])


# ---- STL


def text_stl(points, triangles, name="BODY", end="endsolid"):
    loops = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join("  vertex {:.6E} {:.6E} {:.6E}\n".format(*points[i]) for i in t)
        + " endloop\nendfacet\n"
        for t in triangles
    )
    return f"solid {name}\n{loops}{end}{' ' + name if end else ''}\n"


def binary_stl(points, triangles, count=None, header=b"", attribute=0, behind=b""):
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *points[t].ravel(), attribute) for t in triangles)
    return header.ljust(80, b"\0") + struct.pack("<I", len(triangles) if count is None else count) + facets + behind


STLS = {
    "capitals": text_stl(*box()).upper(),
    "no end": text_stl(*box(), end=""),
    "no name": text_stl(*box(), name=""),
    "a byte order mark": "\ufeff" + text_stl(*box()),
    "DOS lines": text_stl(*box()).replace("\n", "\r\n"),
    "bytes behind": binary_stl(*box(), behind=b"made by a program"),
    "count 0": binary_stl(*box(), count=0),
    "a header that says solid": binary_stl(*box(), header=b"solid facet endsolid"),
    "plain": binary_stl(*box()),
}


@pytest.mark.parametrize("name", STLS)
def test_stl_files_of_any_make_are_read(tmp_path, name):
    content = STLS[name]
    (tmp_path / "a.stl").write_bytes(content if isinstance(content, bytes) else content.encode())
    model = cad.read(tmp_path / "a.stl")
    assert (model.triangle_count, area(model)) == (12, pytest.approx(6.0))
    assert names(model) == ["BODY" if isinstance(content, str) and name != "no name" else "a"]


def test_a_cut_off_stl_says_how_much_is_there(tmp_path):
    (tmp_path / "a.stl").write_bytes(binary_stl(*box(), count=100))
    model = cad.read(tmp_path / "a.stl")
    assert model.triangle_count == 12
    assert any("announces 100 facets and holds 12" in line for line in told(model))


def test_each_solid_of_a_text_is_a_part_and_polygons_are_cut(tmp_path):
    square = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "a.stl").write_text(
        text_stl(*box(), name="one part") + "solid one part\n" + square + "endsolid\n" + text_stl(*box(), name="Träger")
    )
    model = cad.read(tmp_path / "a.stl")
    assert names(model) == ["one part", "one part", "Träger"]
    assert [len(mesh.triangles) for mesh in model.meshes] == [12, 2, 12]


@pytest.mark.parametrize(
    ("header", "attribute", "color"),
    [
        (b"", 0x8000 | 31 << 10, [1, 0, 0, 1]),
        (b"COLOR=\xff\0\0\xff", 0x8000, [1, 0, 0, 1]),
        (b"COLOR=\0\0\0\xff", 31, [1, 0, 0, 1]),
        (b"", 0, None),
    ],
)
def test_the_colours_of_two_makers_of_stl_are_known(tmp_path, header, attribute, color):
    (tmp_path / "a.stl").write_bytes(binary_stl(*box(), header=header, attribute=attribute))
    model = cad.read(tmp_path / "a.stl")
    assert color_of(model, "a").tolist() == (color or [0.8, 0.8, 0.8, 1.0])


def test_pictures_are_no_stl(tmp_path):
    (tmp_path / "a.stl").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 40)
    with pytest.raises(CadFileError, match="no STL data"):
        cad.read(tmp_path / "a.stl")


@given(st.lists(st.tuples(*[st.floats(-1e3, 1e3, width=32)] * 9), min_size=1, max_size=12), st.booleans())
def test_triangles_of_any_stl_are_read_back_equal(tmp_path_factory, rows, as_text):
    points = np.array(rows, np.float32).reshape(-1, 3)
    points[np.abs(points) < 1e-3] = 0.0
    triangles = np.arange(len(points)).reshape(-1, 3)
    cross = np.cross(points[1::3] - points[::3], points[2::3] - points[::3])
    assume(bool((np.linalg.norm(cross, axis=1) > 1.0).all()))
    path = tmp_path_factory.mktemp("stl") / "a.stl"
    path.write_bytes(text_stl(points, triangles).encode() if as_text else binary_stl(points, triangles))
    assert np.allclose(world_triangles(cad.read(path), 0), points[triangles], rtol=2e-6, atol=1e-3 if as_text else 1e-6)


# ---- OFF and PLY


def off(face, head="OFF\n8 6 0\n", between="\n"):
    points, _ = box()
    rows = [" ".join(f"{c:g}" for c in p) for p in points] + [face.format(*ring) for ring in RINGS]
    return head + between.join(rows) + between


@pytest.mark.parametrize(
    ("text", "color"),
    [
        (off("4 {} {} {} {} 255 0 0"), [1, 0, 0, 1]),
        (off("4 {} {} {} {} 1.0 0.0 0.0"), [1, 0, 0, 1]),
        (off("4 {} {} {} {} 255 0 0 51"), [1, 0, 0, 0.2]),
        (off("4 {} {} {} {} 7"), [0.8, 0.8, 0.8, 1]),
        (off("4 {} {} {} {}"), [0.8, 0.8, 0.8, 1]),
        (off("4 {} {} {} {}", "OFF 8 6 0 ", " "), [0.8, 0.8, 0.8, 1]),
        (off("4 {} {} {} {}", "OFF 8 6 0\n"), [0.8, 0.8, 0.8, 1]),
        (off("4 {} {} {} {} # red", "OFF # made\n# by hand\n8 6 12\n"), [0.8, 0.8, 0.8, 1]),
        ("\ufeff" + off("4 {} {} {} {}").replace("\n", "\r\n"), [0.8, 0.8, 0.8, 1]),
    ],
)
def test_off_files_of_any_lines_are_read_with_the_colours_of_their_faces(tmp_path, text, color):
    (tmp_path / "a.off").write_text(text, newline="", encoding="utf-8")
    model = cad.read(tmp_path / "a.off")
    assert (model.triangle_count, area(model)) == (12, pytest.approx(6.0))
    assert np.allclose(color_of(model, "a"), color)


def test_few_faces_with_a_colour_leave_the_others_grey(tmp_path):
    text = off("4 {} {} {} {}").splitlines()
    text[-1] += " 0 0 255"
    (tmp_path / "a.off").write_text("\n".join(text))
    own = colors(cad.read(tmp_path / "a.off"), 0)[:, 0, :3]
    assert sorted(map(tuple, own.tolist())) == [(0.0, 0.0, 1.0)] * 2 + [(0.8, 0.8, 0.8)] * 10


def ply(order, faces, strips=()):
    points, _ = box()
    mark = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    head = f"ply\nformat {mark} 1.0\ncomment x\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    data = points.astype(order + "f4").tobytes()
    if faces:
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
        data += b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in faces)
    if strips:
        head += "element tristrips 1\nproperty list int int vertex_indices\n"
        data += struct.pack(f"{order}i{len(strips)}i", len(strips), *strips)
    return (head + "end_header\n").encode() + data


@pytest.mark.parametrize("order", "<>")
def test_ply_may_mix_triangles_and_polygons_and_hold_strips(tmp_path, order):
    mixed = [*RINGS[:3], *(t for ring in RINGS[3:] for t in (ring[:3], (ring[0], ring[2], ring[3])))]
    (tmp_path / "a.ply").write_bytes(ply(order, mixed))
    model = cad.read(tmp_path / "a.ply")
    assert (model.triangle_count, area(model)) == (12, pytest.approx(6.0))
    strips = [i for ring in RINGS for i in (ring[0], ring[1], ring[3], ring[2], -1)]
    (tmp_path / "b.ply").write_bytes(ply(order, (), strips))
    model = cad.read(tmp_path / "b.ply")
    p = world_triangles(model, 0)
    outwards = np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p.mean(axis=1) - 0.5)
    assert (model.triangle_count, area(model)) == (12, pytest.approx(6.0))
    assert (outwards > 0).all()


@pytest.mark.parametrize(("kind", "most"), [("uchar", 255), ("ushort", 65535), ("float", 1), ("float", 255)])
def test_colours_of_ply_run_to_what_their_type_says_or_to_255(tmp_path, kind, most):
    points, triangles = box()
    head = "ply\nformat ascii 1.0\nelement vertex 8\n" + "".join(f"property float {axis}\n" for axis in "xyz")
    head += "".join(f"property {kind} {c}\n" for c in ("red", "green", "blue"))
    head += "element face 12\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [f"{x:g} {y:g} {z:g} {most} 0 0" for x, y, z in points] + [f"3 {a} {b} {c}" for a, b, c in triangles]
    (tmp_path / "a.ply").write_text(head + "\n".join(rows) + "\n")
    assert color_of(cad.read(tmp_path / "a.ply"), "a").tolist() == [1, 0, 0, 1]


# ---- 3MF


def package(folder, resources, build='<item objectid="1"/>', root="3D/3dmodel.model", others=()):
    """A 3MF whose relationship names the root."""
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    kind = core.replace("core/2015/02", "2013/01/3dmodel")
    relation = f'<Relationships xmlns="r"><Relationship Target="/{root}" Id="r0" Type="{kind}"/></Relationships>'

    def model(resources, build):
        spaces = f'xmlns="{core}" xmlns:m="m" xmlns:b="b"'
        return f'<model unit="millimeter" {spaces}><resources>{resources}</resources><build>{build}</build></model>'

    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for name, other in others:
            archive.writestr(name, model(other, build))
        archive.writestr("_rels/.rels", relation)
        archive.writestr(root, model(resources, build))
    path = folder / "a.3mf"
    path.write_bytes(data.getvalue())
    return path


def cube_3mf(size=10, triangle="", ident="1", attributes="", extra=""):
    points, triangles = box((size, size, size))
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in points)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}" {triangle}/>' for a, b, c in triangles)
    return f'<object id="{ident}" {attributes}><mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles>{extra}</mesh></object>'


def test_the_relationship_names_the_part_that_counts(tmp_path):
    path = package(
        tmp_path, cube_3mf(), root="3D/assembly.model", others=[("3D/Other/a.model", cube_3mf(1000)), ("3D/3dmodel.model", cube_3mf(99))]
    )
    assert np.allclose(cad.read(path).bounds()[1], 0.01)


COLORS = '<m:colorgroup id="5"><m:color color="#FF0000"/><m:color color="#00FF00"/><m:color color="#0000FF"/></m:colorgroup>'


def test_the_corners_of_a_triangle_have_colours_of_their_own(tmp_path):
    model = cad.read(package(tmp_path, COLORS + cube_3mf(triangle='pid="5" p1="0" p2="1" p3="2"')))
    assert np.allclose(colors(model, 0), [np.eye(3, 4) + [0, 0, 0, 1]] * 12)
    plain = cad.read(package(tmp_path, COLORS + cube_3mf(triangle='pid="5" p1="1"')))
    assert color_of(plain, "Object 1").tolist() == [0, 1, 0, 1]


def test_composites_and_layers_are_mixtures(tmp_path):
    base = '<basematerials id="2"><base name="a" displaycolor="#FF0000"/><base name="b" displaycolor="#0000FF"/></basematerials>'
    mixed = '<m:compositematerials id="3" matid="2" matindices="0 1"><m:composite values="0.25 0.75"/></m:compositematerials>'
    model = cad.read(package(tmp_path, base + mixed + cube_3mf(attributes='pid="3" pindex="0"')))
    assert np.allclose(color_of(model, "Object 1"), [0.25, 0, 0.75, 1])
    glass = '<m:colorgroup id="6"><m:color color="#00FF0080"/></m:colorgroup>'
    layers = '<m:multiproperties id="4" pids="2 6"><m:multi pindices="0 0"/></m:multiproperties>'
    model = cad.read(package(tmp_path, base + glass + layers + cube_3mf(attributes='pid="4" pindex="0"')))
    assert np.allclose(color_of(model, "Object 1"), [1 - 128 / 255, 128 / 255, 0, 1])


def test_a_beam_lattice_is_named_and_not_taken_for_an_empty_mesh(tmp_path):
    beams = "<b:beamlattice><b:beams><b:beam v1='0' v2='1'/></b:beams></b:beamlattice>"
    empty = f'<object id="2" name="Lattice"><mesh><vertices><vertex x="0" y="0" z="0"/></vertices><triangles/>{beams}</mesh></object>'
    model = cad.read(package(tmp_path, cube_3mf() + empty, '<item objectid="1"/><item objectid="2"/>'))
    assert told(model) == ["a.3mf: 1 beam lattice was left out (Lattice)."]
    assert model.triangle_count == 12


@given(st.lists(st.tuples(NAMES, st.integers(-9, 9), st.sampled_from([1, -1, 2]), st.integers(0, 2)), min_size=1, max_size=5))
@settings(max_examples=30)
def test_3mf_parts_of_any_names_places_and_colours_are_read_back_equal(tmp_path_factory, parts):
    from xml.sax.saxutils import quoteattr

    resources, build = COLORS, ""
    for i, (name, x, scale, color) in enumerate(parts):
        resources += cube_3mf(10, "", str(i + 10), f'name={quoteattr(name)} pid="5" pindex="{color}"')
        build += f'<item objectid="{i + 10}" transform="{scale} 0 0 0 1 0 0 0 1 {x} 0 0"/>'
    model = cad.read(package(tmp_path_factory.mktemp("3mf"), resources, build))
    assert names(model) == [name for name, *_ in parts]
    for i, (_, x, scale, color) in enumerate(parts):
        p = world_triangles(model, i).reshape(-1, 3) * 1000
        ends = sorted((x, x + 10 * scale))
        assert np.allclose([p.min(axis=0), p.max(axis=0)], [[ends[0], 0, 0], [ends[1], 10, 10]], atol=1e-4)
        assert np.allclose(colors(model, i)[0, 0, :3], np.eye(3)[color])


def test_a_model_too_far_away_for_blender_says_how_far_and_how_coarse(obj):
    near, far = (obj("".join(f"v {x + at} {y} 0\n" for x, y in ((0, 0), (1, 0), (0, 1))) + "f 1 2 3\n") for at in (10_000, 5_400_000))
    assert not told(near)
    assert any("5,400,000 m from the origin" in line and "steps of 0.5 m" in line for line in told(far))
