"""The Python examples of the documentation run as they stand; its panels are those that Blender shows."""

import re

import pytest

from tests.conftest import ROOT

DOCS = ROOT / "docs"
PANEL_PAGE = DOCS / "panels.md"


def python_blocks(path):
    """The page's Python blocks with the line they begin at."""
    text = path.read_text(encoding="utf-8")
    return [(text.count("\n", 0, m.start(1)), m[1]) for m in re.finditer(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)]


@pytest.mark.parametrize("page", [ROOT / "README.md", DOCS / "scripting.md"], ids=lambda page: page.name)
def test_examples_run(page, cube_scene, capsys):
    blocks = python_blocks(page)
    assert blocks
    names = {}
    for line, code in blocks:
        exec(compile("\n" * line + code, str(page), "exec"), names)
    assert capsys.readouterr().out


def test_every_panel_has_its_chapter(blend):
    panels = [cls for cls in blend.types.Panel.__subclasses__() if getattr(cls, "bl_category", "") == "CAD Shadow"]
    assert panels
    chapters = set(re.findall(r"^##+ (.+)$", PANEL_PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    missing = {cls.bl_label for cls in panels if hasattr(cls, "bl_rna")} - chapters
    assert not missing, f"docs/panels.md has no chapter for {sorted(missing)}"
