"""`compare` on the command line and as an operator: the report's numbers and a picture of the differences."""

import importlib
import json

import pytest

TRUTH_KEYS = {"pixels", "misclassified_pct", "acne_pct", "leak_pct", "edge_px_median", "edge_px_p95"}


@pytest.mark.parametrize("map_size", [32, 1024])
def test_compare_counts_and_shows_the_differences(extension, cube_scene, blend, tmp_path, map_size):
    main = importlib.import_module(extension.__name__ + ".cli.main").main
    file, folder = tmp_path / "cube.blend", tmp_path / "out"
    blend.ops.wm.save_as_mainfile(filepath=str(file))
    options = ["--size", "96x64", "--map-size", str(map_size), "--partition", "none", "--quiet"]
    assert main(["compare", str(file), *options, "-o", str(folder)]) == 0
    truth = json.loads((folder / "cube_report.json").read_text())["truth"]
    assert set(truth) >= TRUTH_KEYS
    assert truth["pixels"] > 500
    assert truth["misclassified_pct"] < (5.0 if map_size == 32 else 0.5)
    assert (folder / "cube_difference.png").read_bytes().startswith(b"\x89PNG")


def test_the_operator_finds_what_the_command_finds(extension, cube_scene, blend, tmp_path):
    room = lambda name: importlib.import_module(f"{extension.__name__}.{name}")  # noqa: E731
    cube_scene.cad_shadow.map_size, cube_scene.cad_shadow.partition, cube_scene.cad_shadow.test = 32, "none", "depth"  # which errs
    file, folder = tmp_path / "cube.blend", tmp_path / "out"
    blend.ops.wm.save_as_mainfile(filepath=str(file))
    assert blend.ops.cad_shadow.compare() == {"FINISHED"}
    truth = room("blender.session").last().report["truth"]
    assert truth["misclassified_pct"] > 0.0
    image = blend.data.images["CAD Shadow Preview: difference from ray-traced truth"]
    assert tuple(image.size) == (96, 64)
    pixels = zip(*[iter(image.pixels[:])] * 4, strict=True)
    wrong = [rgba for rgba in pixels if max(rgba[:3]) - min(rgba[:3]) > 0.1]  # red, blue, yellow
    assert len(wrong) == round(truth["misclassified_pct"] * truth["pixels"] / 100)
    assert room("cli.main").main(["compare", str(file), "--quiet", "-o", str(folder)]) == 0
    assert json.loads((folder / "cube_report.json").read_text())["truth"] == json.loads(json.dumps(truth))


def test_the_quality_panel_lists_the_truth(extension, cube_scene, blend):
    from tests.blender.test_panels import Layout

    quality = importlib.import_module(f"{extension.__name__}.blender.panels.quality")
    shown = []
    for press in (blend.ops.cad_shadow.analyse, blend.ops.cad_shadow.compare):
        press()
        panel = type("Panel", (), {"layout": Layout(blend)})()
        quality.CAD_SHADOW_PT_sidebar_quality.draw(panel, blend.context)
        shown.append(set(panel.layout.texts))
    assert {"Wrong", "Acne", "Leaks", "Edges off, median", "Edges off, 95 %"} <= shown[1] - shown[0]


def test_the_operator_reports_what_stops_the_picture(extension, cube_scene, blend):
    cube_scene.cad_shadow.light_source = "OBJECT"
    with pytest.raises(RuntimeError, match="No light object is chosen"):
        blend.ops.cad_shadow.compare()
