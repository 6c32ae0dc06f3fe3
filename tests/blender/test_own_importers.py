"""USD and FBX, which Blender's own importers read, come through the doors of every other format: command line, import, drop."""

import warnings

import numpy as np
import pytest

from addon.errors import CadFileError
from addon.scene import cad
from addon.scene.cad.formats import BY_SUFFIX


def written(blend, folder, suffix):
    """A file by Blender's exporter: a 2 m cube named Tank, red, at (5, 0, 0), and a lamp."""
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    blend.ops.mesh.primitive_cube_add(size=2.0, location=(5.0, 0.0, 0.0))
    blend.context.object.name = "Tank"
    red = blend.data.materials.new("Red")
    red.diffuse_color = (1.0, 0.0, 0.0, 1.0)
    if blend.app.version < (5, 0, 0):
        red.use_nodes = True
    next(n for n in red.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"].default_value = (1.0, 0.0, 0.0, 1.0)
    blend.context.object.data.materials.append(red)
    path = folder / f"plant{suffix}"
    if suffix == ".fbx":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of numpy, on the account of Blender's exporter
            blend.ops.export_scene.fbx(filepath=str(path))
    else:
        blend.ops.wm.usd_export(filepath=str(path))
    return path


def boxes(blend):
    """Name and (2, 3) bounds of each mesh of the scene."""
    blend.context.view_layer.update()
    found = {}
    for ob in blend.context.scene.objects:
        if ob.type == "MESH":
            points = np.array([ob.matrix_world @ v.co for v in ob.data.vertices])
            found[ob.name] = np.stack([points.min(axis=0), points.max(axis=0)])
    return found


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd", ".usdz", ".fbx"])
def test_files_of_blenders_own_formats_open_like_any_other(blend, tmp_path, suffix):
    from addon.blender.inputs import open_input

    path = written(blend, tmp_path, suffix)
    scene, said = open_input(str(path))
    assert said == ()
    assert [c.name for c in scene.collection.children] == ["plant"]
    ((name, box),) = boxes(blend).items()
    assert "Tank" in name or "Cube" in name
    assert np.allclose(box, [[4, -1, -1], [6, 1, 1]], atol=1e-4)
    material = next(ob for ob in scene.objects if ob.type == "MESH").data.materials[0]
    shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    assert np.allclose(shader.inputs["Base Color"].default_value[:3], [1, 0, 0], atol=1e-3)
    assert any("are not used" in line for line in open_input(str(path), units="mm")[1])


def test_the_importer_takes_them_beside_cad_files(blend, tmp_path):
    path = written(blend, tmp_path, ".fbx")
    (tmp_path / "part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    files = [{"name": path.name}, {"name": "part.obj"}]
    assert blend.ops.cad_shadow.import_cad(directory=str(tmp_path), files=files) == {"FINISHED"}
    assert sorted(c.name for c in blend.context.scene.collection.children) == ["part", "plant"]
    assert {ob.name for ob in blend.context.scene.objects} >= {"Tank", "part"}
    assert not blend.context.selected_objects
    assert {".usd", ".fbx"} <= set(blend.types.FileHandler.bl_rna_get_subclass_py("CAD_SHADOW_FH_import_cad").bl_file_extensions.split(";"))


@pytest.mark.parametrize(("name", "data"), [("a.fbx", b"nonsense"), ("a.usda", b"#usda 1.0\n()\n"), ("a.usdc", b"PXR-USDC" + bytes(80))])
def test_what_blender_cannot_read_is_one_line_and_leaves_nothing_behind(blend, tmp_path, name, data):
    from addon.blender.own_importers import imported

    (tmp_path / name).write_bytes(data)
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    before = len(blend.data.objects), len(blend.data.collections)
    with pytest.raises(CadFileError, match=name) as caught:
        imported(tmp_path / name, blend.context.scene.collection)
    assert "\n" not in str(caught.value)
    assert (len(blend.data.objects), len(blend.data.collections)) == before


def test_a_format_that_this_blender_lacks_is_named(blend, tmp_path, monkeypatch):
    from addon.blender import own_importers

    (tmp_path / "a.fbx").write_bytes(b"Kaydara FBX Binary  \0")
    row = BY_SUFFIX[".fbx"]
    monkeypatch.setitem(BY_SUFFIX, ".fbx", type(row)(row.name, row.signatures, row.read, row.place, importers=("wm.no_such_import",)))
    with pytest.raises(CadFileError, match="has no importer for FBX"):
        own_importers.imported(tmp_path / "a.fbx", blend.context.scene.collection)


def test_without_blender_they_say_that_it_takes_blender(tmp_path):
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    with pytest.raises(CadFileError, match="is read by Blender's own USDA importer"):
        cad.read(tmp_path / "a.usda")
