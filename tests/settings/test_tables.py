"""The tables of kinds: a module is a row, and a row says what the rest of the program needs."""

import sys

import pytest

from addon.maths.tables import rows_of
from addon.pipeline.gl.programs import SHADER_DIR, source
from addon.settings.options import OPTIONS
from addon.settings.shadowing import SHADOW_TESTS


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
