"""Scripting: three lines give arrays, numbers and a picture in Blender, the same as F12, and leave the scene as it was."""

import importlib
import json

import numpy as np
import pytest


@pytest.fixture
def api(extension):
    return importlib.import_module(extension.__name__ + ".api")


@pytest.fixture
def errors(extension):
    return importlib.import_module(extension.__name__ + ".errors")


def test_preview_gives_every_pass_as_an_array(api, cube_scene):
    result = api.preview(map_size=128)
    assert {name: image.shape for name, image in result.passes.items()} == {
        "combined": (64, 96, 4), "shadow": (64, 96), "depth": (64, 96), "normal": (64, 96, 3), "object": (64, 96), "partition": (64, 96),
        "aliasing": (64, 96, 3)}  # fmt: skip
    assert result.report["settings"]["fit"]["size"] == 128


def test_preview_is_f12(api, cube_scene, blend, extension):
    session = importlib.import_module(extension.__name__ + ".blender.session")
    blend.ops.render.render()
    f12 = session.last().frame.passes["combined"]
    assert np.array_equal(api.preview().combined, f12)


def values_of(group, *kinds):
    """The plain values of a property group, as text."""
    return {p.identifier: str(getattr(group, p.identifier)) for p in group.bl_rna.properties if p.type in kinds}


def snapshot_of(scene):
    """Everything of a scene that rendering could leave changed."""
    image = scene.render.image_settings
    return {
        "render": values_of(scene.render, "INT", "FLOAT", "ENUM", "STRING", "BOOLEAN"),
        "image": (image.file_format, image.color_mode, image.color_depth),
        "settings": values_of(scene.cad_shadow, "INT", "ENUM", "BOOLEAN"),
        "objects": sorted(scene.objects.keys()),
        "camera": scene.camera and scene.camera.name,
    }


@pytest.mark.parametrize("has_camera", [True, False])
def test_a_preview_leaves_the_scene_as_it_was(api, cube_scene, blend, has_camera):
    if not has_camera:
        blend.data.objects.remove(cube_scene.camera)
    cube_scene.render.engine = "BLENDER_WORKBENCH"
    before, cameras = snapshot_of(cube_scene), len(blend.data.cameras)
    result = api.preview(size=(40, 30), warp="psm", view=None if has_camera else "top")
    assert result.combined.shape == (30, 40, 4)
    assert snapshot_of(cube_scene) == before
    assert len(blend.data.cameras) == cameras


def test_a_failed_preview_leaves_the_scene_as_it_was(api, errors, cube_scene):
    before = snapshot_of(cube_scene)
    with pytest.raises(errors.SceneError, match="Nobody"):
        api.preview(camera="Nobody", size=(40, 30))
    assert snapshot_of(cube_scene) == before


def test_views_lights_and_lenses_are_used(api, cube_scene):
    result = api.preview(eye=(0, 0, 9), target=(0, 0, 0), light_direction=(0, 0, 3), fov_y_deg=50.0, near=1.0, far=20.0)
    assert np.allclose(result.camera.eye_ws + result.outcome.job.scene.origin_ws, (0, 0, 9))
    assert np.allclose(result.light.direction_ws, (0, 0, 1))
    assert (result.camera.near, result.camera.far) == (1.0, 20.0)
    assert np.isclose(np.degrees(result.camera.half_fov_rad), 25.0)
    assert result.report["gamma_deg"] == pytest.approx(0.0, abs=1e-4)
    seen = np.isfinite(result.passes["depth"])
    assert result.passes["depth"][seen].min() == pytest.approx(7.0, abs=1e-3)


def test_analyse_is_the_report(api, cube_scene):
    report = api.analyse(partition="z-log", partitions=2)
    assert len(report["partitions"]) == 2
    assert report["measured"]["m_max"] > 0.0
    json.dumps(report, allow_nan=False)


def test_theory_takes_the_options_of_the_command_line(api):
    total = api.theory(1.0, 1000.0, warp="uniform", partition="none")["total"]
    assert total["storage_factor"] == pytest.approx(865159, rel=1e-5)


def test_unknown_options_are_refused(api, errors, cube_scene):
    with pytest.raises(errors.SettingsError, match="mapsize"):
        api.preview(mapsize=128)


def test_show_makes_an_image_of_the_picture(api, cube_scene):
    result = api.preview()
    image = result.show()
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    assert np.array_equal(values.reshape(64, 96, 4)[::-1], result.combined)
    again = api.preview(size=(32, 16)).show()
    assert (again.name, tuple(again.size)) == ("CAD Shadow Preview", (32, 16))
    assert result.show("aliasing").name == "CAD Shadow Preview: aliasing"


def test_save_writes_by_suffix(api, errors, cube_scene, tmp_path):
    result = api.preview()
    for name, passes in (
        ("a.npz", api.ALL_PASSES),
        ("a.json", ()),
        ("c.png", ("combined",)),
        ("c.exr", ("combined",)),
        ("d.png", ("depth",)),
    ):
        result.save(tmp_path / name, passes)
        assert (tmp_path / name).stat().st_size > 200
    with pytest.raises(errors.OutputError, match="name one pass"):
        result.save(tmp_path / "all.png")
    assert np.array_equal(np.load(tmp_path / "a.npz")["combined"], result.combined)
