"""Section planes from an object or typed, in the panel, in F12 and on the command line."""

import json

import numpy as np
import pytest

from tests.scene.test_section import cap_area


@pytest.fixture
def sections(room):
    return room("blender.section_properties")


def planes(room, scene):
    return room("blender.properties").settings_from(scene.cad_shadow).section.planes


def test_a_typed_plane_is_the_settings(cube_scene, room):
    section = cube_scene.cad_shadow.section_2
    section.point, section.normal = (1.0, 2.0, 3.0), (0.0, 0.0, 2.0)
    assert planes(room, cube_scene) == ()
    section.use = True
    assert planes(room, cube_scene) == (1.0, 2.0, 3.0, 0.0, 0.0, 2.0)
    section.flip = True
    assert planes(room, cube_scene)[3:] == (0.0, 0.0, -2.0)


def test_a_plane_follows_its_object(cube_scene, room, blend):
    empty = blend.data.objects.new("Cut", None)
    cube_scene.collection.objects.link(empty)
    empty.location, empty.rotation_euler = (0.0, 0.0, 1.5), (np.pi / 2, 0.0, 0.0)
    section = cube_scene.cad_shadow.section_1
    section.use, section.object = True, empty
    blend.context.view_layer.update()
    assert planes(room, cube_scene) == pytest.approx((0.0, 0.0, 1.5, 0.0, -1.0, 0.0), abs=1e-6)


def test_one_click_cuts_the_model_open_through_its_middle(cube_scene, room, blend, api):
    assert blend.ops.cad_shadow.add_section() == {"FINISHED"}
    blend.context.view_layer.update()
    job = api.preview(size=(64, 48), view="front").outcome.job
    assert cap_area(job.scene) > 0.0
    for _ in range(2):
        blend.ops.cad_shadow.add_section()
    assert not blend.ops.cad_shadow.add_section.poll()


def test_a_section_shows_in_a_render_and_the_report_says_which(cube_scene, blend, api):
    section = cube_scene.cad_shadow.section_1
    section.use, section.point, section.normal = True, (0.0, 0.0, 0.5), (0.0, 0.0, 1.0)
    with_it, whole = api.preview(size=(64, 48)), None
    section.use = False
    whole = api.preview(size=(64, 48))
    assert not np.array_equal(with_it.combined, whole.combined)
    assert list(with_it.report["settings"]["section"]["planes"]) == [0.0, 0.0, 0.5, 0.0, 0.0, 1.0]
    assert list(whole.report["settings"]["section"]["planes"]) == []


def test_live_view_sets_engine_and_shading_and_puts_the_shading_back(room):
    live = room("operators.live_view")

    class Shading:
        type = "SOLID"

    class Space:
        type, shading = "VIEW_3D", Shading()

    context = type("Context", (), {})()
    context.space_data, context.screen = Space(), None
    context.scene = type("Scene", (), {"render": type("Render", (), {"engine": "BLENDER_EEVEE"})()})()
    live.CAD_SHADOW_OT_live_view.execute(None, context)
    assert (context.scene.render.engine, Space.shading.type) == ("CAD_SHADOW_PREVIEW", "RENDERED")
    live.CAD_SHADOW_OT_live_view.execute(None, context)
    assert Space.shading.type == "SOLID"


def test_the_command_line_cuts_lays_ground_and_takes_a_look(main, tmp_path):
    """One picture with all three, and what the report says of them."""
    box = tmp_path / "box.obj"
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
    box.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a} {b} {c} {d}\n" for a, b, c, d in faces))
    words = ("--look", "clay", "--ground", "-0.5", "--section", "0,0,0.5,0,0,1", "--section", "0.5,0,0,1,0,0", "--section-caps", "hatch")
    small = ("--size", "64x48", "--map-size", "64", "--samples", "1", "--up-axis", "Z", "--units", "m")
    assert main(["preview", str(box), "-o", str(tmp_path), "--passes", "combined,edges", "--edges", "2", *small, *words]) == 0
    settings = json.loads((tmp_path / "box_report.json").read_text())["settings"]
    assert settings["section"]["planes"] == [0, 0, 0.5, 0, 0, 1, 0.5, 0, 0, 1, 0, 0]
    assert settings["section"]["caps"] == "hatch"
    assert (settings["ground"]["kind"], settings["ground"]["height"]) == ("height", -0.5)
    assert (settings["shading"]["use_object_colors"], settings["edges"]["width"]) == (False, 2.0)
    assert (tmp_path / "box_edges.png").is_file()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("--section", "0,0,1"), "3 numbers, not 6"),
        (("--section", "0,0,1,0,0,0"), "normal is zero"),
        (("--ground", "low"), "neither auto, off, nor a height"),
        (("--look", "shiny"), "invalid choice"),
        (("--edges", "-1"), "does not lie between 0 and 16"),
    ],
)
def test_what_cannot_be_meant_is_bad_usage(main, tmp_path, capfd, words, complaint):
    assert main(["preview", "x.obj", "-o", str(tmp_path), *words]) == 2
    assert complaint in capfd.readouterr().err
