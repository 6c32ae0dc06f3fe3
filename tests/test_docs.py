"""The documentation says what the program says: made parts are current, links lead somewhere, commands shown are understood."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest

from addon.cli.commands import COMMANDS
from addon.cli.parser import build_parser, joined
from addon.cli.settings_file import chosen_settings, overlaid
from addon.settings.groups import Settings
from addon.settings.options import OPTIONS
from tests.conftest import ROOT
from tools import docs_tables

DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)")
COMMAND = re.compile(rf"(?:blender --command cad_shadow|cad|python -m addon|\./dev(?= (?:{'|'.join(COMMANDS)}) )) (.*?)(?: +#.*)?$")


def blocks(text: str, language: str = "") -> list[str]:
    """The fenced blocks of a page in that language."""
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def shown_commands() -> list[tuple[str, str]]:
    """(page, arguments) of every command line of the program that the pages show in a block."""
    found = []
    for page in PAGES:
        for block in blocks(page.read_text(encoding="utf-8")):
            for line in block.splitlines():
                if match := COMMAND.match(line):
                    found.append((page.name, match[1]))
    return found


@pytest.mark.parametrize("page", docs_tables.pages(), ids=lambda page: page.name)
def test_made_parts_are_current(page):
    assert page.read_text(encoding="utf-8") == docs_tables.pages()[page], "run: python -m tools.docs_tables"


def test_every_option_is_explained_once():
    named = docs_tables.named_options((DOCS / "panels.md").read_text(encoding="utf-8"))
    assert sorted(named) == sorted(option.name for option in OPTIONS)


def test_every_choice_is_explained():
    text = (DOCS / "panels.md").read_text(encoding="utf-8")
    explained = {name for m in docs_tables.MARKED.finditer(text) if m[2] == "choices" for name in m[3].split()}
    assert explained == {option.name for option in OPTIONS if option.kind == "choice"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    targets = [target for target in LINK.findall(text) if "://" not in target]
    missing = [target for target in targets if target.partition("#")[0] and not (page.parent / target.partition("#")[0]).is_file()]
    assert not missing


def test_every_page_is_in_the_navigation():
    listed = set(re.findall(r": (\w+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE))
    assert listed == {page.name for page in DOCS.glob("*.md")}, "mkdocs.yml's nav and the files of docs/ differ"


@pytest.mark.parametrize(("page", "line"), shown_commands())
def test_commands_shown_are_understood(page, line):
    args = build_parser().parse_args(joined(shlex.split(line.replace("*.step", "a.step b.step"))))
    args.from_file = {}
    chosen_settings(Settings(), args)


def test_settings_file_shown_is_understood():
    shown = blocks((DOCS / "cookbook.md").read_text(encoding="utf-8"), "toml")
    assert shown
    for text in shown:
        overlaid(Settings(), tomllib.loads(text))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_developer_commands_shown_exist(page):
    shown = set(re.findall(r"\./dev ([a-z-]+)", page.read_text(encoding="utf-8")))
    script = (ROOT / "dev").read_text(encoding="utf-8")
    offered = {name for names in re.findall(r"^  ([a-z|-]+)\)", script, re.MULTILINE) for name in names.split("|")}
    offered |= set(COMMANDS)
    assert shown <= offered, f"./dev has no {sorted(shown - offered)}"


def test_modules_shown_exist():
    for page in PAGES:
        for name in re.findall(r"python -m ((?:tools|benchmarks)\.\w+)", page.read_text(encoding="utf-8")):
            assert (ROOT / (name.replace(".", "/") + ".py")).is_file(), f"{page.name}: {name}"


def test_what_is_cited_is_in_the_repository():
    sources = [path for room in ("addon", "benchmarks", "tests", "tools") for path in (ROOT / room).rglob("*.py") if path != Path(__file__)]
    for path in [*sources, *PAGES, ROOT / "CONVENTIONS.md", ROOT / "CONTRIBUTING.md"]:
        text = path.read_text(encoding="utf-8")
        missing = [name for name in re.findall(r"docs/\w+\.md", text) if not (ROOT / name).is_file()]
        elsewhere = re.findall(r"\b[Ii]ssue (?:\d+|\")|\bthe contract's\b", text)
        assert not missing and not elsewhere, f"{path}: {missing + elsewhere}"
