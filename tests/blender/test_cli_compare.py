"""`compare` on the command line: the numbers of the contract and a picture of the differences."""

import importlib
import json

import pytest

TRUTH_KEYS = {"pixels", "misclassified_pct", "acne_pct", "leak_pct", "edge_px_median", "edge_px_p95"}


@pytest.mark.parametrize("map_size", [32, 1024])
def test_compare_counts_and_shows_the_differences(extension, cube_scene, blend, tmp_path, map_size):
    main = importlib.import_module(extension.__name__ + ".cli").main
    file, folder = tmp_path / "cube.blend", tmp_path / "out"
    blend.ops.wm.save_as_mainfile(filepath=str(file))
    options = ["--size", "96x64", "--map-size", str(map_size), "--partition", "none", "--quiet"]
    assert main(["compare", str(file), *options, "-o", str(folder)]) == 0
    truth = json.loads((folder / "cube_report.json").read_text())["truth"]
    assert set(truth) >= TRUTH_KEYS
    assert truth["pixels"] > 500
    assert truth["misclassified_pct"] < (5.0 if map_size == 32 else 0.5)
    assert (folder / "cube_difference.png").read_bytes().startswith(b"\x89PNG")
