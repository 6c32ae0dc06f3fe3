"""IFC and BREP: read where their library is installed, and a line that names it where it is not."""

import math
import sys

import numpy as np
import pytest

from addon.errors import CadFileError
from addon.scene import cad
from addon.scene.cad.formats import BY_SUFFIX
from addon.scene.cad.sniff import sniff
from addon.scene.child_python import _folder
from tests.cad.measured import area, color_of, names

IFC_HEAD = b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('v'),'2;1');\nFILE_SCHEMA (('IFC4X3'));\n"
BREP_HEAD = b"\nCASCADE Topology V3, (c) Open Cascade\nLocations 0\n"


@pytest.mark.parametrize(
    ("library", "name", "head", "way_out"),
    [("ifcopenshell", "a.ifc", IFC_HEAD, "install the extension Bonsai"), ("OCP", "a.brep", BREP_HEAD, "export it as STEP")],
)
def test_a_missing_library_is_named_with_the_way_out(tmp_path, monkeypatch, library, name, head, way_out):
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.setitem(sys.modules, f"{library}.BinTools", None)
    (tmp_path / name).write_bytes(head)
    with pytest.raises(CadFileError, match=way_out) as caught:
        cad.read(tmp_path / name)
    assert str(caught.value).startswith(f"{name} is a")


def test_ifc_and_brep_are_known_by_what_they_begin_with(tmp_path):
    assert sniff(IFC_HEAD, 1000, BY_SUFFIX) == (".ifc",)
    assert sniff(BREP_HEAD, 1000, BY_SUFFIX)[0] == ".brep"
    (tmp_path / "a.step").write_bytes(IFC_HEAD)
    with pytest.raises(CadFileError, match="is a IFC file under a wrong name: rename it to a.ifc"):
        cad.read(tmp_path / "a.step")


def test_libraries_of_one_file_are_found_where_they_lie(tmp_path, monkeypatch):
    (tmp_path / "single_library.py").write_text("")
    (tmp_path / "whole_library").mkdir()
    (tmp_path / "whole_library" / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    assert _folder("single_library") == _folder("whole_library") == str(tmp_path)


def test_an_ifc_gives_its_tree_names_and_colours_and_hides_its_rooms(tmp_path):
    ifcopenshell = pytest.importorskip("ifcopenshell", reason="IfcOpenShell is not installed")
    from ifcopenshell.api import run

    model = run("project.create_file", version="IFC4")
    project = run("root.create_entity", model, ifc_class="IfcProject", name="P")
    run("unit.assign_unit", model, units=[run("unit.add_si_unit", model, unit_type="LENGTHUNIT", prefix="MILLI")])
    whole = run("context.add_context", model, context_type="Model")
    body = run("context.add_context", model, context_type="Model", context_identifier="Body", target_view="MODEL_VIEW", parent=whole)
    storey = run("root.create_entity", model, ifc_class="IfcBuildingStorey", name="Level 1")
    run("aggregate.assign_object", model, products=[storey], relating_object=project)
    for i, (kind, name) in enumerate([("IfcWall", "Wall"), ("IfcWall", "Träger {1}"), ("IfcSpace", "Room")]):
        product = run("root.create_entity", model, ifc_class=kind, name=name)
        place = np.eye(4)
        place[0, 3] = 5.0 * i
        run("geometry.edit_object_placement", model, product=product, matrix=place)
        shape = run("geometry.add_wall_representation", model, context=body, length=4, height=3, thickness=0.2)
        run("geometry.assign_representation", model, product=product, representation=shape)
        if kind == "IfcSpace":
            run("aggregate.assign_object", model, products=[product], relating_object=storey)
        else:
            run("spatial.assign_container", model, products=[product], relating_structure=storey)
        if i == 1:
            style = run("style.add_style", model, name="Red")
            look = {"SurfaceColour": {"Name": None, "Red": 1.0, "Green": 0.0, "Blue": 0.0}, "Transparency": 0.5}
            run("style.add_surface_style", model, style=style, ifc_class="IfcSurfaceStyleShading", attributes=look)
            run("style.assign_representation_styles", model, shape_representation=shape, styles=[style])
    model.write(str(tmp_path / "a.ifc"))
    assert ifcopenshell.open(str(tmp_path / "a.ifc")) is not None
    read = cad.read(tmp_path / "a.ifc")
    assert names(read) == ["Wall", "Träger {1}", "Room"]
    assert [part.name for part in read.parts if part.mesh < 0] == ["P", "Level 1"]
    assert [part.name for part in read.parts if part.is_hidden] == ["Room"]
    assert np.allclose(read.bounds(), [[0, 0, 0], [9, 0.2, 3]])
    assert color_of(read, "Träger {1}").tolist() == [1, 0, 0, 0.5]
    assert any("1 room was imported hidden" in line for line in read.warnings)


@pytest.mark.parametrize("is_binary", [False, True])
def test_a_brep_gives_the_shapes_it_is_composed_of_facing_outwards(tmp_path, is_binary):
    pytest.importorskip("OCP", reason="OCP is not installed")
    from OCP.BinTools import BinTools
    from OCP.BRep import BRep_Builder
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
    from OCP.BRepTools import BRepTools
    from OCP.gp import gp_Trsf, gp_Vec
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS_Compound

    compound, move = TopoDS_Compound(), gp_Trsf()
    BRep_Builder().MakeCompound(compound)
    move.SetTranslation(gp_Vec(100, 0, 0))
    for shape in (BRepPrimAPI_MakeBox(10, 20, 30).Shape(), BRepPrimAPI_MakeCylinder(5, 40).Shape().Moved(TopLoc_Location(move))):
        BRep_Builder().Add(compound, shape)
    (BinTools if is_binary else BRepTools).Write_s(compound, str(tmp_path / "part.brep"))
    model = cad.read(tmp_path / "part.brep")
    assert names(model) == ["part 1", "part 2"]
    assert math.isclose(area(model) * 1e6, 2200 + 50 * math.pi + 400 * math.pi, rel_tol=2e-3)
    corners = [mesh.positions[mesh.triangles].astype(float) for mesh in model.meshes]
    volumes = [float(np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum()) / 6e-9 for p in corners]
    assert np.allclose(volumes, [6000, 1000 * math.pi], rtol=1e-2)
