"""COLLADA and 3DXML: trees, names, units, axes, colours and every way of writing triangles; what is left out is said."""

import math
import zipfile
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import CadFileError
from addon.scene import cad
from tests.cad.gltf_writer import box
from tests.cad.measured import area, color_of, colors, names

POINTS, TRIANGLES = box()
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
XML_NAMES = st.text(st.characters(min_codepoint=32, exclude_categories=["Cs", "Cn"], exclude_characters="￾￿"), min_size=1, max_size=12)


def words(values):
    return " ".join(repr(float(v)) if not float(v).is_integer() else str(int(v)) for v in np.ravel(values))


FORMS = {
    "triangles": f'<triangles count="12">{{inputs}}<p>{words(TRIANGLES)}</p></triangles>',
    "polylist": f'<polylist count="6">{{inputs}}<vcount>{"4 " * 6}</vcount><p>{words(QUADS)}</p></polylist>',
    "polygons": f'<polygons count="6">{{inputs}}{"".join(f"<p>{words(q)}</p>" for q in QUADS)}</polygons>',
    "trifans": f'<trifans count="6">{{inputs}}{"".join(f"<p>{words(q)}</p>" for q in QUADS)}</trifans>',
    "tristrips": f'<tristrips count="6">{{inputs}}{"".join(f"<p>{words([q[0], q[1], q[3], q[2]])}</p>" for q in QUADS)}</tristrips>',
}


def geometry(number, form="triangles", size=1.0, material="", extra=""):
    """A box of a given form; its primitive names the material's symbol."""
    inputs = f'<input semantic="VERTEX" source="#v{number}" offset="0"/>'
    primitive = (
        FORMS[form].replace("{inputs}", inputs).replace("count=", f"material={quoteattr(material)} count=" if material else "count=", 1)
    )
    return (
        f'<geometry id="g{number}" name="Mesh {number}"><mesh><source id="s{number}"><float_array id="a{number}" count="24">'
        f'{words(POINTS * size)}</float_array><technique_common><accessor source="#a{number}" count="8" stride="3"/></technique_common>'
        f'</source><vertices id="v{number}"><input semantic="POSITION" source="#s{number}"/></vertices>{primitive}{extra}</mesh></geometry>'
    )


def dae(nodes, geometries, unit="1", axis="Z_UP", effects=""):
    """A document; `effects` are (id, name, shader)."""
    materials = "".join(f'<material id="m{i}" name={quoteattr(n)}><instance_effect url="#e{i}"/></material>' for i, n, _ in effects)
    shaders = "".join(
        f'<effect id="e{i}"><profile_COMMON><technique sid="t"><phong>{shader}</phong></technique></profile_COMMON></effect>'
        for i, _, shader in effects
    )
    return (
        '<?xml version="1.0" encoding="utf-8"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f'<asset><unit meter="{unit}" name="u"/><up_axis>{axis}</up_axis></asset><library_effects>{shaders}</library_effects>'
        f"<library_materials>{materials}</library_materials><library_geometries>{geometries}</library_geometries>"
        f'<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#scene"/></scene></COLLADA>'
    )


def shown(number, symbol="", material=""):
    bound = f'<instance_material symbol={quoteattr(symbol)} target="#{material}"/>' if material else ""
    common = f"<technique_common>{bound}</technique_common>"
    return f'<instance_geometry url="#g{number}"><bind_material>{common}</bind_material></instance_geometry>'


def read(folder, text, name="a.dae"):
    (folder / name).write_text(text, encoding="utf-8")
    return cad.read(folder / name)


@pytest.mark.parametrize("form", FORMS)
def test_every_way_of_writing_faces_gives_the_box(tmp_path, form):
    model = read(tmp_path, dae(f'<node name="Box">{shown(0)}</node>', geometry(0, form)))
    assert (names(model), model.triangle_count, model.warnings) == (["Box"], 12, ())
    assert math.isclose(area(model), 6.0, rel_tol=1e-6)
    assert len(model.meshes[0].positions) == 8


@pytest.mark.parametrize(("unit", "metres"), [("0.001", 0.001), ("0.0254", 0.0254), ("1", 1.0), ("0.5", 0.5)])
@pytest.mark.parametrize(("axis", "low"), [("Z_UP", [0, 0, 0]), ("Y_UP", [0, -3, 0])])
def test_the_unit_and_the_axis_of_the_document_hold(tmp_path, unit, metres, axis, low):
    node = f"<node><scale>1 2 3</scale>{shown(0)}</node>"
    model = read(tmp_path, dae(node, geometry(0), unit, axis))
    size = [1, 2, 3] if axis == "Z_UP" else [1, 3, 2]
    assert np.allclose(model.bounds(), np.array([low, np.add(low, size)]) * metres)


def test_transformations_apply_in_their_order_and_nodes_may_be_shown_again(tmp_path):
    inner = f'<node id="n" name="Bolt"><translate>1 0 0</translate><rotate>0 0 1 90</rotate>{shown(0)}</node>'
    again = '<node name="Again"><matrix>1 0 0 10 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_node url="#n"/></node>'
    model = read(tmp_path, dae(inner + again, geometry(0)))
    assert names(model) == ["Bolt", "Bolt"] and len(model.meshes) == 1
    assert np.allclose(model.bounds(), [[0, 0, 0], [11, 1, 1]])


def test_materials_are_bound_by_the_symbol_of_each_place(tmp_path):
    effects = [
        ("r", "Paint", "<diffuse><color>1 0 0 1</color></diffuse>"),
        ("b", "Paint", "<diffuse><color>0 0 1 1</color></diffuse><transparency><float>0.25</float></transparency>"),
        ("z", "Tr", '<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent><transparency><float>0</float></transparency>'),
    ]
    nodes = "".join(f'<node name="{one}">{shown(0, "S", "m" + one)}</node>' for one in "rbz")
    model = read(tmp_path, dae(nodes, geometry(0, material="S"), effects=effects))
    assert color_of(model, "r").tolist() == [1, 0, 0, 1]
    assert color_of(model, "b").tolist() == [0, 0, 1, 0.25]
    assert color_of(model, "z")[3] == 1.0, "nobody writes what cannot be seen"


def test_colours_of_corners_are_kept(tmp_path):
    shades = "".join(f"{x} {y} {z} " for x, y, z in POINTS)
    source = (
        f'<source id="c"><float_array id="ca" count="24">{shades}</float_array>'
        '<technique_common><accessor source="#ca" count="8" stride="3"/>'
        "</technique_common></source>"
    )
    text = geometry(0).replace("<vertices", source + "<vertices").replace("<p>", '<input semantic="COLOR" source="#c" offset="0"/><p>')
    model = read(tmp_path, dae(f"<node>{shown(0)}</node>", text))
    corners = model.meshes[0].positions[model.meshes[0].triangles]
    assert np.allclose(colors(model, 0)[..., :3], corners, atol=1e-6)


def test_what_collada_holds_and_is_not_read_is_said(tmp_path):
    lines = '<lines count="1"><input semantic="VERTEX" source="#v0" offset="0"/><p>0 1</p></lines>'
    node = f'<node name="A">{shown(0)}<instance_light url="#l"/><instance_camera url="#c"/></node><node name="B">{shown(7)}</node>'
    text = " ".join(read(tmp_path, dae(node, geometry(0, extra=lines))).warnings)
    for line in ("1 set of lines was left out (Mesh 0)", "1 light ", "1 camera ", "1 shape that are not in the file was"):
        assert line in text


@pytest.mark.parametrize(
    "text", ["<COLLADA", "<COLLADA/>", dae("<node/>", ""), dae(f"<node>{shown(0)}</node>", geometry(0).replace("#s0", "#x"))]
)
def test_a_collada_that_is_not_whole_is_one_line(tmp_path, text):
    with pytest.raises(CadFileError) as caught:
        read(tmp_path, text)
    assert str(caught.value).isprintable()


def test_a_node_within_itself_ends(tmp_path):
    with pytest.raises(CadFileError, match="within themselves"):
        read(tmp_path, dae(f'<node id="n">{shown(0)}<instance_node url="#n"/></node>', geometry(0)))


def test_an_archive_holds_its_document(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.zae", "w") as archive:
        archive.writestr("models/a.dae", dae(f"<node>{shown(0)}</node>", geometry(0)))
    assert cad.read(tmp_path / "a.zae").triangle_count == 12


@given(
    parts=st.lists(
        st.tuples(
            XML_NAMES, st.sampled_from(sorted(FORMS)), st.lists(st.integers(-(10**6), 10**6), min_size=3, max_size=3), st.integers(-1, 3)
        ),
        min_size=1,
        max_size=5,
    ),
    is_mirrored=st.booleans(),
)
def test_collada_trees_of_any_names_and_places_are_read_back_equal(tmp_path_factory, parts, is_mirrored):
    folder = tmp_path_factory.mktemp("dae")
    forms = sorted({form for _, form, _, _ in parts})
    text, open_nodes, world, matrix = "", 0, [], np.eye(4)
    for name, form, move, depth in parts:  # a chain: each within the one before, unless it begins anew
        if depth < 0:
            text += "</node>" * open_nodes
            open_nodes, matrix = 0, np.eye(4)
        own = np.diag([-1.0 if is_mirrored else 1.0, 1.0, 1.0, 1.0])
        own[:3, 3] = move
        matrix = matrix @ own
        scale = "<scale>-1 1 1</scale>" if is_mirrored else ""
        text += f"<node name={quoteattr(name)}><translate>{words(move)}</translate>{scale}{shown(forms.index(form))}"
        open_nodes += 1
        world.append(matrix)
    text += "</node>" * open_nodes
    model = read(folder, dae(text, "".join(geometry(i, form) for i, form in enumerate(forms))))
    assert names(model) == [name for name, _, _, _ in parts]
    assert len(model.meshes) == len(forms)
    assert np.allclose(model.world_from_part(), world)


REP = (
    '<XMLRepresentation xmlns="http://www.3ds.com/xsd/3DXML" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
    '<Root xsi:type="BagRepType">'
    '<Rep xsi:type="PolygonalRepType"><SurfaceAttributes>'
    '<Color xsi:type="RGBAColorType" red="0" green="0" blue="1" alpha="1"/></SurfaceAttributes>'
    '<PolygonalLOD accuracy="9"><Faces><Face triangles="0 1 3"/></Faces></PolygonalLOD><Faces>{faces}</Faces>'
    "<VertexBuffer><Positions>{points}</Positions></VertexBuffer></Rep></Root></XMLRepresentation>"
)
RED = '<SurfaceAttributes><Color red="1" green="0" blue="0" alpha="1"/></SurfaceAttributes>'


def package(folder, instances, shape, name="a.3dxml"):
    """A package whose root 1 holds instances (name, matrix) of the reference 2, which shows `shape`."""
    text = "".join(
        f"<Instance3D id='{10 + i}' name={quoteattr(one)}><IsAggregatedBy>1</IsAggregatedBy>"
        f"<IsInstanceOf>urn:3DXML:Reference:loc:2</IsInstanceOf>"
        f"<RelativeMatrix>{words(matrix)}</RelativeMatrix></Instance3D>"
        for i, (one, matrix) in enumerate(instances)
    )
    root = (
        '<Model_3dxml xmlns="http://www.3ds.com/xsd/3DXML"><ProductStructure root="1"><Reference3D id="1" name="Plant"/>'
        '<Reference3D id="2" name="r">'
        f"<V_Name>{escape('Valve <1>')}</V_Name></Reference3D>{text}"
        "<ReferenceRep id='3' format='TESSELLATED' associatedFile='urn:3DXML:Shape.3DRep'/>"
        "<InstanceRep id='4'><IsAggregatedBy>2</IsAggregatedBy><IsInstanceOf>3</IsInstanceOf></InstanceRep>"
        "</ProductStructure></Model_3dxml>"
    )
    with zipfile.ZipFile(folder / name, "w") as archive:
        archive.writestr("Manifest.xml", "<Manifest><Root>root.3dxml</Root></Manifest>")
        archive.writestr("root.3dxml", root)
        archive.writestr("Shape.3DRep", shape)
    return cad.read(folder / name)


def shape_of(faces):
    return REP.replace("{faces}", faces).replace("{points}", ", ".join(words(p * 1000) for p in POINTS))


UNIT = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]


def test_a_3dxml_gives_its_tree_instances_and_colours_in_metres(tmp_path):
    half = TRIANGLES[:6]
    fans = ",".join(words(q) for q in QUADS)
    moved = [0, 1, 0, -1, 0, 0, 0, 0, 1, 5000, 0, 0]
    faces = f'<Face triangles="{words(half)}">{RED}</Face><Face fans="{fans}"/>'
    model = package(tmp_path, [("V-1", UNIT), ("V-2", moved)], shape_of(faces))
    assert names(model) == ["V-1", "V-2"] and [p.name for p in model.parts if p.mesh < 0] == ["Plant"]
    assert len(model.meshes) == 1 and model.meshes[0].name == "Valve <1>"
    assert model.triangle_count == 2 * 18
    assert np.allclose(model.bounds(), [[0, 0, 0], [5, 1, 1]])
    assert sorted({tuple(np.round(c, 6)) for c in colors(model, 1).reshape(-1, 4)}) == [(0, 0, 1, 1), (1, 0, 0, 1)]


def test_strips_of_3dxml_cover_the_box(tmp_path):
    strips = ",".join(words([q[0], q[1], q[3], q[2]]) for q in QUADS)
    model = package(tmp_path, [("V", UNIT)], shape_of(f'<Face strips="{strips}"/>'))
    assert math.isclose(area(model), 6.0, rel_tol=1e-6)


def test_shapes_in_the_makers_binary_form_are_counted_and_named(tmp_path):
    with pytest.raises(CadFileError, match=r"holds no face to draw: .* 1 shape in a binary form .* \(V\)"):
        package(tmp_path, [("V", UNIT)], b"\x00\x01CGR")


@given(
    st.lists(st.tuples(XML_NAMES, st.lists(st.integers(-(10**6), 10**6), min_size=3, max_size=3), st.booleans()), min_size=1, max_size=5)
)
def test_3dxml_instances_of_any_names_and_places_are_read_back_equal(tmp_path_factory, parts):
    turned = {False: UNIT[:9], True: [-1, 0, 0, 0, -1, 0, 0, 0, 1]}
    folder = tmp_path_factory.mktemp("3dxml")
    model = package(folder, [(n, [*turned[t], *m]) for n, m, t in parts], shape_of(f'<Face triangles="{words(TRIANGLES)}"/>'))
    assert names(model) == [name for name, _, _ in parts]
    got = np.array([m[:3] for p, m in zip(model.parts, model.world_from_part(), strict=True) if p.mesh >= 0])
    assert np.allclose(got[:, :, 3] * 1000, [m for _, m, _ in parts])
    assert np.allclose(got[:, 0, 0], [-1 if t else 1 for _, _, t in parts])
