"""The table of commands: a module each, named after its command; their words are there without Blender."""

import subprocess
import sys
from dataclasses import replace

import pytest

from addon.cli import shared_arguments
from addon.cli.commands import COMMANDS
from addon.cli.parser import build_parser
from addon.settings.options import OPTIONS
from tests.conftest import ROOT

MODULES = sorted(path.stem for path in (ROOT / "addon" / "cli" / "commands").glob("*.py") if path.stem != "__init__")
LEAST = {
    "theory": ["--near", "1", "--far", "9"],
    "sun-study": ["--latitude", "1", "--longitude", "1", "--date", "2026-06-21"],
    "sun-hours": ["--latitude", "1", "--longitude", "1", "--date", "2026-06-21"],
    "advise": ["--texels", "9"],
}
WITHOUT_BLENDER = """
import sys
from dataclasses import replace
for name in ("bpy", "mathutils", "gpu", "bmesh"):
    sys.modules[name] = None
from addon.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


def test_each_module_is_the_command_it_is_named_after():
    assert sorted(name.replace("-", "_") for name in COMMANDS) == MODULES


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_has_one_way_to_work_and_says_what_it_is(name):
    row = COMMANDS[name]
    assert (row.work is None) != (row.alone is None)
    assert row.help and row.description.endswith(".")
    args = build_parser().parse_args([name, *LEAST.get(name, [])])
    assert args.command == name and args.jobs == 1 and not args.worker, "what every run asks for"
    assert row.alone or {"inputs", "deck", "units", "settings", "report", "camera", "light_direction", "preset"} <= vars(args).keys()


@pytest.mark.parametrize(("argv", "code"), [(["--help"], 0), (["theory", *LEAST["theory"]], 0), (["preview"], 2), (["preveiw"], 2)])
def test_words_and_mistakes_need_no_blender(argv, code):
    done = subprocess.run([sys.executable, "-c", WITHOUT_BLENDER, *argv], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == code and "Traceback" not in done.stderr, done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a script for bash")
def test_the_developers_script_refuses_what_is_no_command():
    done = subprocess.run(["bash", "dev", "sun_studies"], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and "no command 'sun_studies'" in done.stderr


def test_a_command_without_options_of_the_method_has_no_preset_and_no_batch(monkeypatch):
    def few(parser):
        shared_arguments.add_inputs(parser)
        shared_arguments.add_view(parser)

    row = replace(COMMANDS["analyse"], name="count", add_arguments=few)
    monkeypatch.setitem(COMMANDS, "count", row)
    args = build_parser().parse_args(["count", "a.obj"])
    assert args.preset is None and args.jobs == 1 and not args.worker and not args.contact_sheet


def test_every_option_is_on_the_command_line_once():
    assert sorted(name for names in shared_arguments.SECTIONS.values() for name in names) == sorted(option.name for option in OPTIONS)
