"""Copy Diagnostics: what it tells, what it leaves out, and that nothing is printed on its account."""

import logging

import pytest

from addon.errors import SceneError
from addon.settings.groups import Settings
from addon.studies import diagnostics as module


@pytest.fixture
def kept():
    """Lines are kept as while the extension is enabled."""
    module.register()
    yield module
    module.unregister()


def told(**more):
    return module.diagnostics({"version": "5.2.3"}, more.pop("settings", Settings()), more.pop("report", None), **more)


def test_it_names_versions_libraries_preferences_and_the_settings_that_were_changed(kept):
    text = told(settings=Settings().replaced(fit={"size": 512}))
    for line in ("version: 5.2.3", "moderngl: ", "cascadio: ", "backend: auto", "import_seconds: 300", "fit.size: 512"):
        assert f"  {line}" in text
    assert "warp.kind" not in text and text.isascii()


@pytest.mark.parametrize(
    "path", ["/home/ada/secret project/plant.step", r"C:\Users\ada\plant.step", "//server/share/plant.blend", "~/plant.blend"]
)
def test_paths_are_told_only_when_asked_for(kept, path):
    module.LOGGER.info("reading %s failed", path)
    assert "ada" not in told() and "server" not in told() and "~" not in told() and "<path>" in told()
    assert path in told(with_paths=True)


def test_the_last_errors_are_kept_with_their_traceback_and_no_more_than_some(kept):
    for number in range(module.KEPT + 5):
        module.LOGGER.info("error %d.", number)
    try:
        raise SceneError("nothing to draw")
    except SceneError:
        logging.getLogger(module.LOGGER.name + ".blender.viewport").info("live view", exc_info=True)
    text = told()
    assert "error 4." not in text and f"error {module.KEPT + 4}." in text
    assert "Traceback" in text and "nothing to draw" in text


def test_a_message_moves_no_terminal(kept):
    module.LOGGER.info("part \x1b[31mred")
    assert "\x1b" not in told()


def test_nothing_is_printed_on_its_account(kept, capfd):
    module.LOGGER.info("quiet")
    assert capfd.readouterr() == ("", "")


def test_the_report_s_names_stay_out(kept):
    report = {
        "size": [8, 8],
        "objects": {"secret": 1},
        "input": "secret.step",
        "measured": {"m": 1.0},
        "warnings": ["secret"],
        "errors": [],
    }
    text = told(report=report)
    assert "secret" not in text and "measured: {'m': 1.0}" in text and "warnings: 1" in text


def test_the_operator_tells_of_blender_and_of_the_last_error(blend, room, tmp_path):
    with pytest.raises(RuntimeError):
        blend.ops.cad_shadow.import_cad(filepath=str(tmp_path / "missing.stl"))
    assert blend.ops.cad_shadow.copy_diagnostics() == {"FINISHED"}  # in the background Blender has no clipboard to look at
    text = room("studies.diagnostics").diagnostics(room("operators.copy_diagnostics").host(), Settings())
    assert blend.app.version_string in text and "does not exist" in text and str(tmp_path) not in text
