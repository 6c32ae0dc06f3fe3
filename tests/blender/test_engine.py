"""The render engine in Blender: files and passes are written when it succeeds, none when it fails."""

import numpy as np
import pytest


def loaded(bpy, path):
    """(h, w, 4) raw values of an image file, row 0 at the top."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)[::-1]


def render_to(scene, path, kind="PNG"):
    import bpy

    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE" if kind == "OPEN_EXR_MULTILAYER" else "IMAGE"
    image.file_format = kind
    if kind == "OPEN_EXR":
        image.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


@pytest.fixture
def session(extension):
    import importlib

    return importlib.import_module(extension.__name__ + ".blender.session")


def test_a_render_writes_the_picture_of_the_frame(cube_scene, blend, session, tmp_path):
    path = tmp_path / "cube.exr"
    render_to(cube_scene, path, "OPEN_EXR")
    combined = session.last().frame.passes["combined"]
    written = loaded(blend, path)
    assert written.shape == combined.shape == (64, 96, 4)
    assert np.array_equal(written, combined)
    assert np.ptp(combined[..., 0]) > 0.1


def test_light_shadow_and_background_are_all_in_the_picture(cube_scene, session, tmp_path):
    cube_scene.cad_shadow.light_source, cube_scene.cad_shadow.light_direction = "DIRECTION", (-1.0, 1.0, 1.0)
    render_to(cube_scene, tmp_path / "cube.png")
    passes = session.last().frame.passes
    shown = np.isfinite(passes["depth"])
    shadow = passes["shadow"][shown]
    assert 0.02 < (shadow < 0.5).mean() < 0.6
    assert (shadow > 0.5).mean() > 0.4
    assert 0.2 < shown.mean() <= 1.0


def exr_layers(path):
    """Names of the channels in a (multi-part) EXR's header."""
    head = path.read_bytes()[:8000]
    return {
        name
        for name in ("Combined", "Depth", "Normal", "Shadow", "Aliasing")
        if f".{name}.".encode() in head or f"{name}\0".encode() in head
    }


@pytest.fixture
def all_on(blend):
    """The view layer's switches of our usual passes."""
    layer = blend.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_shadow = True


def test_every_pass_that_is_on_is_in_a_multilayer_exr(cube_scene, all_on, tmp_path):
    path = tmp_path / "cube.exr"
    render_to(cube_scene, path, "OPEN_EXR_MULTILAYER")
    assert exr_layers(path) == {"Combined", "Depth", "Normal", "Shadow", "Aliasing"}


def test_the_compositor_sees_the_passes(cube_scene, all_on):
    import bpy

    bpy.ops.render.render()
    if bpy.app.version < (5, 0, 0):
        cube_scene.use_nodes = True
        tree = cube_scene.node_tree
    else:
        tree = cube_scene.compositing_node_group = bpy.data.node_groups.new("comp", "CompositorNodeTree")
    node = tree.nodes.new("CompositorNodeRLayers")
    assert {"Depth", "Normal", "Shadow", "Aliasing"} <= {socket.name for socket in node.outputs if socket.enabled}


def test_the_picture_is_not_upside_down(cube_scene, session, tmp_path):
    render_to(cube_scene, tmp_path / "cube.png")
    depth = session.last().frame.passes["depth"]
    assert np.median(depth[-8:]) < np.median(depth[:8]), "the floor is nearer at the bottom of the picture"


def test_a_render_border_with_crop_writes_that_part(cube_scene, session, blend, tmp_path):
    render = cube_scene.render
    render_to(cube_scene, tmp_path / "whole.png")
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
    render_to(cube_scene, tmp_path / "part.png")
    whole, part = loaded(blend, tmp_path / "whole.png"), loaded(blend, tmp_path / "part.png")
    assert np.array_equal(part, whole[:32, 24:72])


def test_film_transparency_empties_the_background(cube_scene, session, tmp_path):
    cube_scene.render.film_transparent = True
    cube_scene.cad_shadow.samples = "1"
    render_to(cube_scene, tmp_path / "cube.png")
    passes = session.last().frame.passes
    nothing = ~np.isfinite(passes["depth"])
    assert nothing.any()
    assert not passes["combined"][nothing].any()


def fails(scene, path, match):
    with pytest.raises(RuntimeError, match=match):
        render_to(scene, path)
    assert not path.exists()


def test_a_scene_without_a_mesh_writes_no_file(cube_scene, blend, tmp_path):
    for ob in [o for o in cube_scene.objects if o.type == "MESH"]:
        blend.data.objects.remove(ob)
    fails(cube_scene, tmp_path / "empty.png", "nothing to draw")


def test_a_panoramic_camera_writes_no_file(cube_scene, tmp_path):
    cube_scene.camera.data.type = "PANO"
    fails(cube_scene, tmp_path / "pano.png", "panoramic")


def test_clip_start_beyond_clip_end_writes_no_file(cube_scene, tmp_path):
    cube_scene.camera.data.clip_start, cube_scene.camera.data.clip_end = 10.0, 1.0
    fails(cube_scene, tmp_path / "clip.png", "clip")


def test_a_light_that_is_not_chosen_writes_no_file(cube_scene, tmp_path):
    cube_scene.cad_shadow.light_source = "OBJECT"
    fails(cube_scene, tmp_path / "light.png", "No light object is chosen")


def test_a_defect_of_ours_writes_no_file(cube_scene, extension, tmp_path, monkeypatch):
    import importlib

    sources = importlib.import_module(extension.__name__ + ".blender.sources")

    def broken(_depsgraph):
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr(sources, "job_for_render", broken)
    fails(cube_scene, tmp_path / "defect.png", "a defect")


def test_the_light_direction_moves_the_shadow(cube_scene, session, tmp_path):
    shadows = []
    cube_scene.cad_shadow.light_source = "DIRECTION"
    for direction in ((1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)):
        cube_scene.cad_shadow.light_direction = direction
        render_to(cube_scene, tmp_path / "cube.png")
        shadows.append(session.last().frame.passes["shadow"])
        assert session.last().job.light.direction_ws == pytest.approx(np.array(direction) / np.sqrt(2.0))
    assert not np.array_equal(*shadows)


def test_an_animation_reads_the_moving_object(cube_scene, session, tmp_path):
    import bpy

    cube = bpy.data.objects["Cube"]
    for frame, x in ((1, -1.0), (2, 1.0)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    cube_scene.frame_start, cube_scene.frame_end = 1, 2
    cube_scene.render.filepath = str(tmp_path / "f_")
    bpy.ops.render.render(animation=True)
    first, second = (loaded(bpy, path) for path in sorted(tmp_path.glob("f_*.png")))
    assert not np.array_equal(first, second)
