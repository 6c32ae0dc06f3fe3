"""A pytest plugin (`./dev sweep`): every property test over many more examples than in the suite, and docs/margins.md."""

from collections import Counter
from pathlib import Path

import hypothesis
import pytest
from hypothesis import Phase

from tests.conftest import ROOT
from tests.margins import notes

PAGE = ROOT / "docs" / "margins.md"
HEAD = """# Margins

How near the property tests come to what they ask: `./dev sweep` draws 2,000 examples for each and writes this page. `./dev test` draws
fewer, the same ones everywhere. A margin of 10 means that the worst example took a tenth of what is allowed; a claim about order, counts
or equality has none. Sections are written file by file (`./dev sweep tests/maths/test_warps.py`).
"""
COLUMNS = ("claim", "examples", "compared", "asked", "worst seen", "margin")


def pytest_addoption(parser):
    parser.addoption("--examples", type=int, default=2000, metavar="N", help="examples of each property test")


class Sweep:
    """Runs property tests only, each with more examples; writes the sections of the files that ran whole and passed."""

    def __init__(self):
        self.drawn, self.failed = Counter(), set()
        notes.are_kept = True

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config, items):
        kept = [item for item in items if hypothesis.is_hypothesis_test(getattr(item, "obj", None))]
        config.hook.pytest_deselected(items=[item for item in items if item not in kept])
        items[:] = kept
        for test in {item.obj for item in items}:
            used = getattr(test, "_hypothesis_internal_use_settings", hypothesis.settings.default)
            test._hypothesis_internal_use_settings = hypothesis.settings(
                used, max_examples=config.getoption("examples"), phases=(Phase.explicit, Phase.generate))  # a failure is told, not shrunk

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item):
        name, inner = item.nodeid.split("[")[0], item.obj.hypothesis.inner_test
        self.drawn[name] += 0

        def counted(**drawn):
            self.drawn[name] += 1
            return inner(**drawn)

        item.obj.hypothesis.inner_test = counted
        try:
            return (yield)
        finally:
            item.obj.hypothesis.inner_test = inner

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.failed.add(report.nodeid.split("::")[0])

    def pytest_terminal_summary(self, terminalreporter, config):
        if config.option.keyword or any("::" in word for word in config.args):
            terminalreporter.write_line(f"{PAGE.relative_to(ROOT)}: not written, only a part of a file ran")
            return
        files = {name.split("::")[0] for name in self.drawn} - self.failed
        write_page(PAGE, {file: self.rows(file) for file in files})
        terminalreporter.write_line(f"{PAGE.relative_to(ROOT)}: {len(files)} sections written, {len(self.failed)} files failed")

    def rows(self, file):
        """The table's rows for a file's tests, in the order they ran."""
        for name, count in self.drawn.items():
            if name.split("::")[0] == file:
                claim = name.split("::")[1].removeprefix("test_").replace("_", " "), f"{count:,}"
                found = [(compared, margin) for (test, compared), margin in notes.found.items() if test == name]
                for compared, margin in found:
                    times = f"{1.0 / margin.share:.2g}" if margin.share > 0.0 else "unused"
                    yield *claim, f"`{compared}`", margin.asked, margin.worst, times
                    claim = "", ""
                if not found:
                    yield *claim, "", "", "", ""


def write_page(path: Path, sections: dict[str, list]) -> None:
    """The page with these sections anew and the others as they were."""
    old = path.read_text(encoding="utf-8").split("\n## ")[1:] if path.is_file() else []
    texts = {text.split("\n", 1)[0]: text.split("\n", 1)[1] for text in old}
    for file, rows in sections.items():
        lines = [COLUMNS, ["---"] * len(COLUMNS), *rows]
        texts[file] = "\n" + "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)
    path.write_text(HEAD + "".join(f"\n## {file}\n{texts[file].rstrip()}\n" for file in sorted(texts)), encoding="utf-8")


def pytest_configure(config):
    config.pluginmanager.register(Sweep())
