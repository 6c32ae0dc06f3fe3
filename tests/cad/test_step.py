"""STEP as its authors meant it: product names, one mesh for equal bodies, hidden parts, colours of occurrences, far origins, documents."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.errors import CadFileError
from addon.images.srgb import linear_from_srgb
from addon.scene import cad
from addon.scene.cad.step_text import STATEMENT, text_of
from tests.cad.measured import area, color_of, names, world_triangles
from tests.cad.step_writer import Step

pytest.importorskip("cascadio")


def read(folder, step, name="a.step"):
    path = folder / name
    path.write_text(step.text(), encoding="utf-8")
    return cad.read(path)


@pytest.mark.parametrize("name", ["", "NAUO1", "=>[0:1:1:2]", "7", "Next assembly relationship", "COMPONENT 3"])
def test_parts_without_a_name_of_their_own_are_called_after_their_product(tmp_path, name):
    step = Step()
    skid, valve = step.product("Skid"), step.product("Valve", step.box((100, 100, 200)))
    for i in range(3):
        step.occurrence(skid, valve, name, identifier=str(i), at=(200 * i, 0, 0))
    model = read(tmp_path, step)
    assert names(model) == ["Valve"] * 3
    assert [part.name for part in model.parts][0] == "Skid"
    assert len(model.meshes) == 1
    assert np.allclose(model.bounds(), [[0, 0, 0], [0.5, 0.1, 0.2]])


def test_occurrences_keep_the_names_their_authors_gave_in_any_letters(tmp_path):
    step = Step()
    skid = step.product("Skid")
    bolt = step.product("Bolt", step.box((10, 10, 10)))
    for written in ("Left bolt", "Bolzen \\X2\\00D6006C\\X0\\", "Öl 泵", "it''s", "a;b#1 = X(2);", "\\S\\|", "Bolt:1"):
        step.occurrence(skid, bolt, written)
    model = read(tmp_path, step)
    assert names(model) == ["Left bolt", "Bolzen Öl", "Öl 泵", "it's", "a;b#1 = X(2);", "ü", "Bolt:1"]


def test_a_single_product_is_called_by_its_name_or_identifier(tmp_path):
    step = Step()
    step.product("", step.box((10, 10, 10)), identifier="4711-A")
    assert names(read(tmp_path, step)) == ["4711-A"]


def test_two_hundred_bolts_are_one_mesh_also_as_products_of_their_own(tmp_path):
    step = Step()
    flange = step.product("Flange")
    bolt = step.product("Bolt", step.box((10, 10, 40)))
    other = step.product("Bolt copy", step.box((10, 10, 40)))
    for i in range(100):
        step.occurrence(flange, bolt, at=(20 * i, 0, 0))
        step.occurrence(flange, other, at=(20 * i, 50, 0))
    model = read(tmp_path, step)
    assert (model.part_count, len(model.meshes)) == (200, 1)


def test_invisible_parts_are_hidden_and_named(tmp_path):
    step = Step()
    skid = step.product("Skid")
    plate, space = step.box((1000, 500, 100)), step.box((3000, 3000, 3000))
    step.occurrence(skid, step.product("Base plate", plate))
    step.occurrence(skid, step.product("Space reservation", space), at=(-1000, -1000, -1000))
    step.colored(plate, (0.2, 0.4, 0.8))
    step.hidden(step.colored(space, "red"))
    model = read(tmp_path, step)
    assert [(p.name, p.is_hidden) for p in model.parts] == [("Skid", False), ("Base plate", False), ("Space reservation", True)]
    assert np.allclose(model.bounds(), [[0, 0, 0], [1, 0.5, 0.1]])
    assert any("1 part was hidden, as the file says (Space reservation)" in line for line in model.warnings)


@pytest.mark.parametrize("way", ["layer", "item", "occurrence"])
def test_layers_bare_geometry_and_single_occurrences_can_be_invisible(tmp_path, way):
    step = Step()
    skid, solid = step.product("Skid"), step.box((10, 10, 10))
    block = step.product("Block", solid)
    uses = [step.occurrence(skid, block, f"Block {i}", at=(20 * i, 0, 0)) for i in range(2)]
    if way == "layer":
        step.hidden(step.add(f"PRESENTATION_LAYER_ASSIGNMENT('construction','',(#{solid}))"))
    elif way == "item":
        step.hidden(solid)
    else:
        step.hidden(step.colored_occurrence(solid, step.colored(solid, "blue"), uses[1][1], "red"))
    model = read(tmp_path, step)
    assert [p.is_hidden for p in model.parts] == [False, way != "occurrence", True]


def test_a_hidden_body_within_a_part_that_is_shown_is_left_out_and_said(tmp_path):
    step = Step()
    shown, hidden = step.box((100, 100, 100)), step.box((900, 900, 900))
    step.product("Pump", shown, hidden)
    step.hidden(step.colored(hidden, "red"))
    model = read(tmp_path, step)
    assert math.isclose(area(model), 0.06, rel_tol=1e-5)
    assert any("1 hidden piece within parts that are shown was left out (Pump)" in line for line in model.warnings)


def test_the_colour_of_an_occurrence_wins_over_its_products(tmp_path):
    step = Step()
    skid, solid = step.product("Skid"), step.box((100, 100, 100))
    valve = step.product("Valve", solid)
    own = step.colored(solid, (0.6, 0.6, 0.6))
    for i, color in enumerate(["red", "green", (0.2, 0.4, 0.8), None]):
        _, context = step.occurrence(skid, valve, f"V{'abcd'[i]}", at=(200 * i, 0, 0))
        if color is not None:
            step.colored_occurrence(solid, own, context, color)
    model = read(tmp_path, step)
    wanted = [[1, 0, 0], [0, 1, 0], linear_from_srgb(np.array([0.2, 0.4, 0.8])), linear_from_srgb(np.full(3, 0.6))]
    for letter, color in zip("abcd", wanted, strict=True):
        assert np.allclose(color_of(model, f"V{letter}")[:3], color, atol=1e-6)


def test_transparency_is_kept(tmp_path):
    step = Step()
    glass = step.box((100, 100, 100))
    step.product("Glass", glass)
    step.colored(glass, (0.6, 0.8, 1.0), alpha=0.2)
    assert color_of(read(tmp_path, step), "Glass")[3] == pytest.approx(0.2)


@pytest.mark.parametrize(("unit", "scale"), [("mm", 0.001), ("m", 1.0), ("in", 0.0254), ("cm", 0.01)])
def test_geometry_far_from_its_origin_keeps_its_shape(tmp_path, unit, scale):
    step, at = Step(unit), np.array((450_000.0, 5_400_000.0, 100.0)) / scale
    step.product("Bollard", step.box(np.array((0.04, 0.04, 0.2)) / scale, at))
    model = read(tmp_path, step)
    assert model.triangle_count == 12
    assert math.isclose(area(model), 2 * 0.04 * 0.04 + 4 * 0.04 * 0.2, rel_tol=1e-4)
    assert np.allclose(model.bounds(), [[450_000, 5_400_000, 100], [450_000.04, 5_400_000.04, 100.2]], atol=1e-6)


def test_far_geometry_that_is_shared_with_a_placement_is_read_and_said(tmp_path):
    step = Step()
    site = step.product("Site")
    bollard = step.product("Bollard", step.box((40, 40, 200), (450_000_000, 5_400_000_000, 0)))
    step.occurrence(site, bollard)
    corner = next(i + 1 for i, line in enumerate(step.lines) if line.startswith("CARTESIAN_POINT") and "450000040" in line)
    axes = step.add(f"AXIS2_PLACEMENT_3D('',#{corner},$,$)")
    step.add(f"ITEM_DEFINED_TRANSFORMATION('','',#{step.origin},#{axes})")
    try:
        text = " ".join(read(tmp_path, step).warnings)
    except CadFileError as error:
        text = str(error)
    assert "1 part far from the origin, where shapes become coarse," in text or "without area" in text


def test_far_occurrences_stand_where_the_file_says_not_where_float32_does(tmp_path):
    step = Step()
    site, pile = step.product("Site"), step.product("Pile", step.box((400, 400, 9000)))
    at = np.array((450_000_123.456, 5_400_000_789.012, 1.5))
    step.occurrence(site, pile, at=at, z=(0, 0.6, 0.8), x=(0.8, -0.36, 0.48 * 0.5625))
    model = read(tmp_path, step)
    assert np.allclose(model.world_from_part()[1][:3, 3], at / 1000, atol=1e-9)


def test_products_in_files_beside_it_are_read_and_missing_ones_named(tmp_path):
    base, valve, skid = Step(), Step(), Step()
    base.product("base", base.box((1000, 500, 100)))
    valve.product("valve", valve.box((100, 100, 200)))
    top = skid.product("Skid")
    shell = {name: skid.product(name) for name in ("base", "valve", "pump")}
    skid.occurrence(top, shell["base"])
    for i in range(2):
        skid.occurrence(top, shell["valve"], at=(300 * (i + 1), 250, 100))
    skid.occurrence(top, shell["pump"])
    for name, product in shell.items():
        skid.document(product, f"{name}.stp")
    (tmp_path / "base.stp").write_text(base.text())
    (tmp_path / "valve.stp").write_text(valve.text())
    model = read(tmp_path, skid)
    assert sorted(names(model)) == ["base", "valve", "valve"]
    assert len(model.meshes) == 2
    assert np.allclose(model.bounds(), [[0, 0, 0], [1, 0.5, 0.3]])
    assert any("pump.stp is missing: put it beside a.step" in line for line in model.warnings)


def test_documents_that_refer_to_each_other_end(tmp_path):
    for name, other in (("a", "b"), ("b", "a")):
        step = Step()
        top, inner = step.product(f"top {name}"), step.product(f"inner {name}")
        step.occurrence(top, inner)
        step.occurrence(top, step.product(f"block {name}", step.box((10, 10, 10))))
        step.document(inner, f"{other}.stp")
        (tmp_path / f"{name}.stp").write_text(step.text())
    model = cad.read(tmp_path / "a.stp")
    assert sorted(names(model)) == ["block a", "block b"]
    assert any("refers back" in line for line in model.warnings)


def test_a_face_that_cannot_be_meshed_is_counted_and_its_part_named(tmp_path):
    step = Step()
    step.product("Pump", step.box((100, 100, 100)))
    plane = next(i for i, line in enumerate(step.lines) if line.startswith("PLANE"))
    axes = int(step.lines[plane].split("#")[1].rstrip(")"))
    point = int(step.lines[axes - 1].split("#")[1].rstrip(","))
    step.lines[point - 1] = "CARTESIAN_POINT('',(70.,50.,50.))"  # the face's plane no longer holds its edges
    loops = [i for i, line in enumerate(step.lines) if line.startswith("EDGE_LOOP")]
    step.lines[loops[0]] = "EDGE_LOOP('',(" + step.lines[loops[0]].split("((")[-1].split("(")[-1].split(",")[0].rstrip(")") + "))"
    model = read(tmp_path, step)
    assert model.triangle_count < 12
    assert any("1 face that OpenCASCADE cannot mesh was left out (Pump)" in line for line in model.warnings)


@pytest.mark.parametrize(
    ("written", "text"),
    [(b"'it''s'", "it's"), (b"'\\X2\\00D64E2D\\X0\\'", "Ö中"), (b"'\\X\\E4'", "ä"), (b"'\\S\\d'", "ä"), (b"'a\\\\b'", "a\\b"), (b"$", "")],
)
def test_strings_of_step_are_text(written, text):
    assert text_of(written) == text


def test_statements_end_where_they_end():
    data = b"#1=A('it''s ; #2=B(1);',#3);/* #4=C(2); */ #5 = ( D(1) E('x') ) ;\n#6=F(1"
    assert [(int(m[1]), m[2]) for m in STATEMENT.finditer(data)] == [(1, b"A"), (4, b"C"), (5, b"")]


@given(st.data())
@settings(max_examples=8)
def test_assemblies_of_any_names_and_places_are_read_back_equal(tmp_path_factory, data):
    letters = st.text("aZ9 _-äß泵{}%", min_size=1, max_size=8).map(str.strip).filter(lambda t: any(c.isalpha() for c in t))
    unit, scale = data.draw(st.sampled_from([("mm", 0.001), ("m", 1.0), ("in", 0.0254)]))
    step = Step(unit)
    top, wanted = step.product("top"), []
    shapes = [np.array(data.draw(st.tuples(*[st.integers(1, 9)] * 3)), float) for _ in range(2)]
    products = {}
    for _ in range(data.draw(st.integers(1, 5))):
        kind, name = data.draw(st.integers(0, 1)), data.draw(letters)
        at = np.array(data.draw(st.tuples(*[st.integers(-99, 99)] * 3)), float)
        x, y, z = np.eye(3)[list(data.draw(st.permutations(range(3))))]
        z = np.cross(x, y)
        if kind not in products:
            products[kind] = step.product(f"body {kind}", step.box(shapes[kind]))
        step.occurrence(top, products[kind], name, at=at, z=z, x=x)
        corners = np.array([at, at + np.stack([x, y, z], axis=1) @ shapes[kind]]) * scale
        wanted.append((name, np.sort(corners, axis=0)))
    model = read(tmp_path_factory.mktemp("step"), step)
    assert names(model) == [name for name, _ in wanted]
    assert len(model.meshes) <= len({tuple(shape) for shape in shapes})
    shown = [i for i, part in enumerate(model.parts) if part.mesh >= 0]
    for i, (_, corners) in zip(shown, wanted, strict=True):
        p = world_triangles(model, i).reshape(-1, 3)
        assert np.allclose([p.min(axis=0), p.max(axis=0)], corners, atol=1e-5 * max(scale * 99, 1))
