"""The tables of kinds: a module is a row, and a row says what the rest of the program needs."""

import re
import sys
from math import inf
from pathlib import Path

import numpy as np
import pytest

from addon.images import passes as data_pictures
from addon.maths.partitioning import row as partitioning_row
from addon.maths.tables import rows_of
from addon.maths.warping import formulas
from addon.maths.warping import row as warping_row
from addon.pipeline.gl.programs import SHADER_DIR, source
from addon.pipeline.render_passes import row as pass_row
from addon.settings.options import OPTIONS
from addon.settings.shadowing import SHADOW_TESTS
from addon.settings.shadowing import row as test_row


def package(folder, name, monkeypatch, **modules):
    """A package of its own with these modules' texts; gives what `rows_of` wants."""
    (folder / name).mkdir()
    for module, text in {"__init__": "", **modules}.items():
        (folder / name / f"{module}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(folder))
    return name, [str(folder / name)]


ROW = "from types import SimpleNamespace\nROW = SimpleNamespace(name={!r}, place={})\n"


def test_a_module_with_a_row_is_in_the_table_and_the_places_make_the_order(tmp_path, monkeypatch):
    where = package(tmp_path, "kinds_in_order", monkeypatch, a=ROW.format("late", 7), b=ROW.format("early", 2.5), row="class Row: pass\n")
    assert list(rows_of(*where)) == ["early", "late"]
    assert not [name for name in sys.modules if name.endswith("kinds_in_order.c")]


@pytest.mark.parametrize("second", [("same", 2), ("other", 1)])
def test_two_rows_of_one_name_or_place_are_refused(tmp_path, monkeypatch, second):
    where = package(tmp_path, f"kinds_{second[0]}", monkeypatch, a=ROW.format("same", 1), b=ROW.format(*second))
    with pytest.raises(ValueError, match="one name or one place"):
        rows_of(*where)


def test_every_shadow_test_has_a_shader_and_names_options_that_there_are():
    of_test = {option.name for option in OPTIONS if option.targets[0][0] == "test"}
    for test in SHADOW_TESTS.values():
        assert test.options <= of_test, test.name
        text = (SHADER_DIR / test.glsl).read_text(encoding="utf-8")
        assert "Limits limits_of(inout Receiver r)" in text, test.name


def test_a_shader_includes_the_file_that_a_define_names():
    defines = (("IDS", 0), ("SHADOW_TEST", "common_id_test.glsl"))
    text = source("common_filter.glsl", defines)
    assert "uniform float u_epsilon, u_epsilon_far;" in text
    assert "#include" not in text and "#define SHADOW_TEST" not in text and "#define IDS 0" in text


def example(kind, *modules):
    """The row that docs/architecture.md shows as an example, with the names of these modules at hand."""
    text = (Path(__file__).resolve().parents[2] / "docs" / "architecture.md").read_text(encoding="utf-8")
    code = re.search(rf"## To add {kind}\n.*?```python\n(.*?)```", text, re.DOTALL)[1]
    names = {"np": np} | {name: value for module in modules for name, value in vars(module).items() if not name.startswith("__")}
    exec(code, names)
    return names["ROW"]


def test_the_examples_of_the_documentation_are_rows():
    warp = example("a warp", formulas, warping_row)
    parameters = [warp.parameter(warping_row.WarpedView(1.0, 100.0, 0.4, g, 1.0, 100.0, "sine")) for g in np.geomspace(1e-9, 1.57, 50)]
    assert min(parameters) > 0.0 and parameters[0] > 1e6 and max(parameters) <= inf
    scheme = example("a partition scheme", partitioning_row)
    splits = scheme.splits(partitioning_row.DividedView(1.0, 100.0, 4, 0.5, 0.5, None, None))
    assert (np.diff(splits) > 0.0).all() and np.allclose(splits[[0, -1]], (1.0, 100.0))
    assert isinstance(example("a shadow test", test_row), test_row.ShadowTest)
    slope = example("a pass", pass_row, data_pictures)
    normals, ids = np.array([[[0.0, 0.0, 1.0, 2.0], [0.0, -1.0, 0.0, 2.0], [0.0] * 4]]), np.array([[[0, 0, 0, 0], [0, 0, 0, 0], [-1] * 4]])
    image = slope.make(pass_row.ShadedImages(None, None, None, normals, ids, None))
    assert np.allclose(image, [[0.0, 90.0, 0.0]]) and slope.picture({"slope": image}).tolist() == [[0, 128, 0]]
