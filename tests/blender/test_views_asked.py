"""Parallel views, frames, scenes and view layers by the command line and the API."""

import json

import numpy as np
import pytest

SMALL = ("--size", "48x32", "--samples", "1", "--map-size", "128")


@pytest.fixture
def file(cube_scene, blend, tmp_path):
    """A .blend with an animated cube, a second view layer without it, and a second scene with a ball."""
    cube = cube_scene.objects["Cube"]
    for frame, x in ((1, 0.0), (10, 9.0)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    cube_scene.frame_set(1)
    inside = blend.data.collections.new("parts")
    cube_scene.collection.children.link(inside)
    inside.objects.link(cube)
    cube_scene.collection.objects.unlink(cube)
    empty = cube_scene.view_layers.new("bare")
    empty.layer_collection.children["parts"].exclude = True
    other = blend.data.scenes.new("other")
    mesh = blend.data.meshes.new("plate")
    mesh.from_pydata([(0, 0, 0), (3, 0, 0), (0, 3, 0)], [], [(0, 1, 2)])
    other.collection.objects.link(blend.data.objects.new("plate", mesh))
    path = tmp_path / "scene.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def objects_of(main, file, tmp_path, *arguments):
    """(exit code, objects in the picture, depths) of a preview with these arguments."""
    code = main(["preview", str(file), *SMALL, "--format", "npz", "-o", str(tmp_path / "out"), "--quiet", *arguments])
    if code:
        return code, None, None
    passes = np.load(tmp_path / "out" / "scene.npz")
    return code, set(np.unique(passes["object"]).tolist()) - {-1}, passes["depth"]


def test_a_front_view_is_parallel_when_asked(main, file, tmp_path):
    _, _, perspective = objects_of(main, file, tmp_path, "--view", "front", "--view-layer", "ViewLayer")
    code, found, depth = objects_of(main, file, tmp_path, "--view", "front", "--ortho", "--view-layer", "ViewLayer")
    assert code == 0
    seen = np.isfinite(depth)
    cube_front = np.unique(np.round(depth[seen], 4))
    assert len(cube_front) <= 2, "the cube's front lies at one depth, the ground is edge-on"
    assert np.isfinite(perspective).any()


def test_a_frame_is_looked_at_and_the_file_stays_at_its_own(main, api, file, blend, tmp_path):
    _, _, first = objects_of(main, file, tmp_path, "--frame", "1", "--view-layer", "ViewLayer")
    code, _, last = objects_of(main, file, tmp_path, "--frame", "10", "--view-layer", "ViewLayer")
    assert code == 0
    assert not np.array_equal(first, last)
    assert blend.context.scene.frame_current == 1
    at_ten = api.preview(frame=10, size=(48, 32), samples=1, view_layer="ViewLayer")
    assert np.array_equal(at_ten.passes["depth"], last)
    assert blend.context.scene.frame_current == 1


def test_only_the_view_layer_asked_for_is_drawn(main, api, file, blend, tmp_path):
    _, everything, _ = objects_of(main, file, tmp_path, "--view-layer", "ViewLayer")
    code, bare, _ = objects_of(main, file, tmp_path, "--view-layer", "bare")
    assert code == 0
    assert len(bare) == len(everything) - 1
    assert all(layer.use for layer in blend.context.scene.view_layers), "they are as they were"
    assert len(np.unique(api.preview(view_layer="bare", size=(48, 32)).passes["object"])) == len(bare) + 1


def test_a_scene_is_chosen_by_name(main, file, tmp_path):
    report = tmp_path / "report.json"
    code, found, _ = objects_of(main, file, tmp_path, "--scene", "other", "--view", "top", "--ortho", "--report", str(report))
    assert code == 0
    assert json.loads(report.read_text())["geometry"]["instances"] == 1


@pytest.mark.parametrize(("option", "there"), [("--scene", "other"), ("--view-layer", "bare")])
def test_a_name_that_is_not_there_names_those_that_are(main, file, tmp_path, capsys, option, there):
    assert objects_of(main, file, tmp_path, option, "nothing")[0] == 1
    assert there in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--ortho"], ["--ortho", "--view", "iso", "--fov-y", "40"], ["--frame", "x"], ["--frame", "1.5"]])
def test_what_cannot_be_meant_is_bad_usage(main, file, tmp_path, arguments):
    with pytest.raises(SystemExit) as stopped:
        raise SystemExit(objects_of(main, file, tmp_path, *arguments)[0])
    assert stopped.value.code == 2


def test_a_render_border_does_not_make_one_pass_smaller_than_another(main, blend, file, tmp_path):
    blend.ops.wm.open_mainfile(filepath=str(file))
    render = blend.context.scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_max_x = render.border_max_y = 0.5
    blend.ops.wm.save_as_mainfile(filepath=str(file))
    report, out = tmp_path / "report.json", tmp_path / "out"
    passes = ["--passes", "combined,depth", "--format", "exr", "-o", str(out), "--report", str(report), "--quiet"]
    assert main(["preview", str(file), *SMALL, "--view-layer", "ViewLayer", *passes]) == 0
    sizes = set()
    for path in out.glob("*.exr"):
        image = blend.data.images.load(str(path))
        sizes.add(tuple(image.size))
    assert sizes == {(48, 32)}
    assert any("border" in line for line in json.loads(report.read_text())["warnings"])


def test_stereo_is_refused_in_words(cube_scene, blend, tmp_path):
    render = cube_scene.render
    render.use_multiview, render.filepath = True, str(tmp_path / "stereo.png")
    with pytest.raises(RuntimeError, match="Stereo"):
        blend.ops.render.render(write_still=True)
    assert not list(tmp_path.glob("*.png"))
