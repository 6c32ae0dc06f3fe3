"""Where results of the command line go: never over what is the user's, whatever the names."""

import json
from pathlib import Path

import pytest

from tests.blender.user_folder import BOX, OLD, SMALL, below, posix


@posix
def test_a_report_goes_to_a_plain_file_that_is_no_input(main, box, tmp_path, capfd):
    settings = tmp_path / "s.toml"
    settings.write_text("map_size = 64\n")
    link = tmp_path / "link.json"
    link.symlink_to(box)
    before = {path: path.read_bytes() for path in (box, settings)}
    for target, words in (
        (box, "an input of this run"),
        (settings, "an input of this run"),
        (link, "a link"),
        ("/dev/null", "a device"),
        (tmp_path, "a folder"),
    ):
        code = main(["analyse", str(box), "--settings", str(settings), "--report", str(target), "--size", "96x64", "--quiet"])
        assert code == 2, target
        assert words in capfd.readouterr().err
    assert main(["theory", "--near", "1", "--far", "9", "--settings", str(settings), "--report", str(settings)]) == 2
    assert {path: path.read_bytes() for path in before} == before
    assert Path("/dev/null").is_char_device()


def test_a_report_of_all_never_takes_the_place_of_a_report_of_one(main, box, tmp_path, capfd):
    (box.parent / "other.obj").write_text(BOX)
    out = tmp_path / "out"
    assert main(["preview", str(box.parent), "-o", str(out), "--report", str(out / "box_report.json"), *SMALL]) == 2
    assert not out.exists()
    assert main(["preview", str(box.parent), "-o", str(out), "--report", str(out / "box_combined.png"), *SMALL]) == 1
    assert "was written for" in capfd.readouterr().err
    assert (out / "box_combined.png").read_bytes().startswith(b"\x89PNG")
    assert main(["preview", str(box), "-o", str(out), "--report", str(out / "box_report.json"), *SMALL]) == 0


def test_results_never_replace_textures_or_linked_files_of_the_model(main, box, tmp_path, capfd):
    (box.parent / "any.mtl").write_text("newmtl red\nKd 1 0 0\nmap_bump box_normal.png\n")
    box.write_text("mtllib any.mtl\n" + BOX)
    texture = box.parent / "box_normal.png"
    texture.write_bytes(OLD)
    assert main(["preview", str(box), "-o", str(box.parent), "--passes", "normal", *SMALL]) == 1
    assert "box_normal.png is an input of this run" in capfd.readouterr().err
    assert texture.read_bytes() == OLD


def test_a_plane_never_replaces_the_blend_it_is_made_from(main, cube_scene, blend, tmp_path, capfd):
    first = tmp_path / "a.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(first))
    twin = tmp_path / "a_impostor.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(twin))
    before = twin.read_bytes()
    assert main(["impostor", str(first), str(twin), "-o", str(tmp_path), "--plane", "--format", "npz", *SMALL]) == 1
    assert "a_impostor.blend is an input of this run" in capfd.readouterr().err
    assert twin.read_bytes() == before


@pytest.mark.parametrize("name", ["o{a}", "{blend_name}", "{{x}}", "##", "%d", "ü ö"])
def test_output_folders_and_inputs_of_any_name_get_their_pictures(main, box, tmp_path, name):
    model = box.with_name(f"{name}.obj")
    box.rename(model)
    out = tmp_path / name
    assert main(["preview", str(model), "-o", str(out), *SMALL]) == 0
    assert below(out) == [f"{name}_combined.png", f"{name}_report.json"]


def test_a_folder_beyond_what_blender_can_name_is_one_line(main, box, tmp_path, capfd):
    out = tmp_path.joinpath(*["d" * 200] * 6)
    assert main(["preview", str(box), "-o", str(out), *SMALL]) == 1
    assert "longer than Blender can write to" in capfd.readouterr().err


def compositor(bpy, scene):
    """The scene's node tree of the compositor, empty."""
    if hasattr(scene, "compositing_node_group"):
        scene.compositing_node_group = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
        return scene.compositing_node_group
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree


def output_node(tree, folder, image):
    """A File Output node that writes what comes out of a socket to a folder."""
    node = tree.nodes.new("CompositorNodeOutputFile")
    if hasattr(node, "directory"):
        node.directory, node.file_name = str(folder), "stolen"
        node.file_output_items.new("RGBA", "Image")
    else:
        node.base_path = str(folder)
    tree.links.new(image, node.inputs[0])


@pytest.mark.parametrize("is_in_a_group", [False, True])
def test_file_outputs_of_a_blend_write_nowhere_and_are_said(main, cube_scene, blend, tmp_path, is_in_a_group):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    tree = compositor(blend, cube_scene)
    rendered = tree.nodes.new("CompositorNodeRLayers").outputs[0]
    if is_in_a_group:
        inner = blend.data.node_groups.new("inner", "CompositorNodeTree")
        inner.interface.new_socket("Image", in_out="INPUT", socket_type="NodeSocketColor")
        output_node(inner, elsewhere, inner.nodes.new("NodeGroupInput").outputs[0])
        group = tree.nodes.new("CompositorNodeGroup")
        group.node_tree = inner
        tree.links.new(rendered, group.inputs[0])
    else:
        output_node(tree, elsewhere, rendered)
    blend.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert main(["preview", str(tmp_path / "a.blend"), "-o", str(tmp_path / "out"), *SMALL]) == 0
    assert below(elsewhere) == []
    warnings = json.loads((tmp_path / "out" / "a_report.json").read_text())["warnings"]
    assert any("File Output" in line for line in warnings)
    assert not any(one.mute for group in blend.data.node_groups for one in group.nodes)


def test_a_stereo_scene_gives_one_whole_picture(main, cube_scene, blend, tmp_path):
    cube_scene.render.use_multiview = True
    blend.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert main(["preview", str(tmp_path / "a.blend"), "-o", str(tmp_path / "out"), *SMALL]) == 0
    assert below(tmp_path / "out") == ["a_combined.png", "a_report.json"]
    assert (tmp_path / "out" / "a_combined.png").stat().st_size > 100
