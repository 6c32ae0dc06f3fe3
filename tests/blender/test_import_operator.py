"""File > Import > CAD as a user meets it: what it takes, what it refuses, and what becomes of Blender's start-up cube."""

import numpy as np
import pytest

from addon.scene import cad

CORNERS = "".join(f"v {x} {y} {z}\n" for x in (0, 2) for y in (0, 4) for z in (0, 6))
FACES = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"


def box(folder):
    """A box of 2 × 4 × 6 as good.obj in the folder; its path."""
    path = folder / "good.obj"
    path.write_text(CORNERS + FACES)
    return path


def test_the_operator_imports_what_it_can_and_names_what_it_cannot(tmp_path, blend):
    box(tmp_path)
    (tmp_path / "bad.stl").write_text("nonsense")
    with pytest.raises(RuntimeError, match="bad.stl"):
        blend.ops.cad_shadow.import_cad(directory=str(tmp_path), files=[{"name": "bad.stl"}, {"name": "good.obj"}])
    assert [c.name for c in blend.context.scene.collection.children] == ["good"]
    assert blend.context.object.name == "good"


def test_an_import_selects_nothing_and_keeps_what_was_selected(tmp_path, blend):
    box(tmp_path)
    other = blend.data.objects.new("other", None)
    blend.context.scene.collection.objects.link(other)
    other.select_set(True)
    blend.ops.cad_shadow.import_cad(filepath=str(tmp_path / "good.obj"))
    assert blend.context.selected_objects == [other]


def test_an_import_is_as_large_and_where_it_is_asked_to_be(tmp_path, blend):
    box(tmp_path)
    inner = blend.data.collections.new("inner")
    blend.context.scene.collection.children.link(inner)
    blend.context.view_layer.active_layer_collection = blend.context.view_layer.layer_collection.children["inner"]
    for place, parent in (("ACTIVE", inner), ("SCENE", blend.context.scene.collection)):
        before = set(parent.children)
        blend.ops.cad_shadow.import_cad(filepath=str(tmp_path / "good.obj"), up="Z", scale=2.5, place=place)
        (made,) = set(parent.children) - before
        blend.context.view_layer.update()
        assert np.allclose(made.all_objects[0].dimensions, (5.0, 10.0, 15.0))


def test_a_folder_without_a_file_is_not_called_a_file(tmp_path, blend):
    with pytest.raises(RuntimeError, match="No file is chosen"):
        blend.ops.cad_shadow.import_cad(filepath=f"{tmp_path}/")


def test_the_operator_takes_units_and_a_single_path(tmp_path, blend):
    box(tmp_path)
    assert blend.ops.cad_shadow.import_cad(filepath=str(tmp_path / "good.obj"), units="mm", up="Z") == {"FINISHED"}
    blend.context.view_layer.update()
    assert np.allclose(blend.context.object.dimensions, (0.002, 0.004, 0.006))


@pytest.mark.parametrize("touched", ["", "moved", "edited", "modified", "followed", "kept"])
def test_the_start_up_cube_goes_only_while_nobody_has_touched_it(tmp_path, blend, touched):
    blend.ops.wm.read_homefile(use_factory_startup=True)
    cube = blend.context.scene.objects["Cube"]
    if touched == "moved":
        cube.location.z = 1.0
    elif touched == "edited":
        cube.data.vertices[0].co.x = -2.0
    elif touched == "modified":
        cube.modifiers.new("array", "ARRAY")
    elif touched == "followed":
        blend.context.scene.objects["Light"].parent = cube
    path = box(tmp_path)
    assert blend.ops.cad_shadow.import_cad(filepath=str(path), replaces_cube=touched != "kept") == {"FINISHED"}
    assert ("Cube" in blend.data.objects) == bool(touched)


def test_dropping_a_cad_file_is_offered(blend):
    handler = blend.types.FileHandler.bl_rna_get_subclass_py("CAD_SHADOW_FH_import_cad")
    assert handler.bl_import_operator == "cad_shadow.import_cad" and set(handler.bl_file_extensions.split(";")) == set(cad.SUFFIXES)
