"""The advice as a user meets it: the command, the operator, and Apply."""

import importlib
import json

import numpy as np
import pytest

SMALL = ("--size", "96x64", "--seconds", "300")


@pytest.fixture
def session(extension):
    return importlib.import_module(extension.__name__ + ".blender.session")


@pytest.fixture
def animated_blend(cube_scene, blend, tmp_path):
    """The cube scene saved, its camera moving from frame 1 to 20."""
    camera = cube_scene.camera
    camera.keyframe_insert("location", frame=1)
    camera.location = (12, -12, 8)
    camera.keyframe_insert("location", frame=20)
    path = tmp_path / "cube.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_the_command_writes_the_report_and_puts_the_frame_back(main, animated_blend, tmp_path, blend):
    out, report_file = tmp_path / "out", tmp_path / "report.json"
    assert (
        main(
            [
                "advise",
                str(animated_blend),
                "--texels",
                "65536",
                "--frames",
                "1-20",
                "-o",
                str(out),
                "--report",
                str(report_file),
                "--quiet",
                *SMALL,
            ]
        )
        == 0
    )
    report = json.loads((out / "cube_advice.json").read_text())
    assert report == json.loads(report_file.read_text())
    advice = report["advice"]
    assert advice["frames"][0] == 1
    assert advice["frames"][-1] == 20
    assert len(advice["frames"]) == 12
    assert advice["proposal"]["texels"] <= 65536
    assert len(advice["proposal"]["splits"]) == 12
    assert advice["current"]["map_size"] == report["settings"]["fit"]["size"]
    assert blend.context.scene.frame_current == 1


def test_the_proposal_given_back_as_options_has_the_error_it_promised(main, animated_blend, tmp_path):
    assert main(["advise", str(animated_blend), "--error", "0.5", "-o", str(tmp_path), "--quiet", *SMALL]) == 0
    proposal = json.loads((tmp_path / "cube_advice.json").read_text())["advice"]["proposal"]
    words = [f"--{name.replace('_', '-')}={','.join(map(str, v)) if isinstance(v, list) else v}" for name, v in proposal["options"].items()]
    assert main(["analyse", str(animated_blend), "-o", str(tmp_path), "--quiet", "--size", "96x64", *words]) == 0
    assert json.loads((tmp_path / "cube_report.json").read_text())["settings"]["fit"]["size"] == proposal["map_size"]
    assert proposal["rendered"]["m_p95"] <= 0.5


@pytest.mark.parametrize("wrong", [[], ["--texels", "1000000", "--error", "1"], ["--texels", "1000000", "--frames", "9-3"]])
def test_a_goal_is_asked_for_once_and_frames_in_order(main, wrong, capfd):
    assert main(["advise", "nothing.obj", *wrong]) == 2
    assert "advise" in capfd.readouterr().err


def test_a_budget_too_small_is_an_input_that_failed(main, animated_blend, tmp_path):
    assert main(["advise", str(animated_blend), "--texels", "10", "-o", str(tmp_path), "--quiet", *SMALL]) == 1


def test_the_operator_advises_and_apply_writes_the_settings(cube_scene, blend, session):
    bpy = blend
    props = cube_scene.cad_shadow
    props.map_size, props.use_eta, props.eta = 64, True, -0.5
    assert not bpy.ops.cad_shadow.apply_advice.poll()
    assert bpy.ops.cad_shadow.advise(goal="TEXELS", texels=0.25, seconds=300.0) == {"FINISHED"}
    proposal = session.last_advice()["proposal"]
    assert proposal["texels"] <= 2**18
    assert bpy.ops.cad_shadow.apply_advice() == {"FINISHED"}
    assert (props.warp, props.partition, props.fit, props.map_size) == tuple(proposal[k] for k in ("warp", "partition", "fit", "map_size"))
    assert not props.use_eta


def test_a_new_file_forgets_the_advice(cube_scene, blend, session):
    assert blend.ops.cad_shadow.advise(goal="ERROR", error=1.0, seconds=300.0) == {"FINISHED"}
    assert session.last_advice() is not None
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert session.last_advice() is None


def test_the_animation_is_seen_through_its_camera_and_the_frame_put_back(cube_scene, blend, session):
    cube_scene.frame_start, cube_scene.frame_end = 1, 3
    cube_scene.frame_set(2)
    assert blend.ops.cad_shadow.advise(goal="TEXELS", texels=0.25, use_animation=True, seconds=300.0) == {"FINISHED"}
    assert session.last_advice()["frames"] == [1, 2, 3]
    assert cube_scene.frame_current == 2


def test_an_empty_scene_makes_the_button_grey(blend):
    assert not blend.ops.cad_shadow.advise.poll()


def test_the_lights_view_is_a_picture(cube_scene, blend):
    assert blend.ops.cad_shadow.light_view() == {"FINISHED"}
    image = blend.data.images["CAD Shadow Preview: light's view"]
    assert tuple(image.size) == (960, 720)
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    assert len(np.unique(values.reshape(-1, 4), axis=0)) > 10


def test_the_command_line_writes_the_lights_view(main, animated_blend, tmp_path):
    assert main(["preview", str(animated_blend), "--light-view", "-o", str(tmp_path), "--quiet", "--size", "96x64"]) == 0
    assert (tmp_path / "cube_light_view.png").read_bytes().startswith(b"\x89PNG")


def test_the_overlay_has_lines_in_true_world_coordinates(extension, cube_scene, blend, session):
    """The cube stands far from the world's origin; the camera's own split and its maps surround it."""
    overlays = importlib.import_module(extension.__name__ + ".blender.hud.map_overlay")
    for ob in cube_scene.objects:
        ob.location.x += 500.0
    assert blend.ops.cad_shadow.analyse() == {"FINISHED"}
    used = sum(not p.is_empty for p in session.last().frame.plan.projections)
    splits, maps, both = (overlays.segments_of(session.last(), what) for what in ("SPLITS", "MAPS", "BOTH"))
    assert len(splits) == len(maps) == used
    assert len(both) == 2 * used
    for _, segments in maps:
        assert abs(segments[..., 0].mean() - 500.0) < 20.0
