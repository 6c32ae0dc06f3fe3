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
or equality has none. `./dev sweep tests/maths/shadow/test_warps.py` or `./dev sweep -k seam` sweeps a part and leaves the
other lines as they are.
"""
COLUMNS = ("claim", "examples", "compared", "asked", "worst seen", "margin")


def pytest_addoption(parser):
    parser.addoption("--examples", type=int, default=2000, metavar="N", help="examples of each property test")


class Sweep:
    """Runs property tests only, each with more examples; writes down those that passed."""

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
                used, max_examples=config.getoption("examples"), phases=(Phase.explicit, Phase.generate)
            )  # a failure is told, not shrunk

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
            self.failed.add(report.nodeid.split("[")[0])

    def pytest_terminal_summary(self, terminalreporter, config):
        is_whole = not config.option.keyword and not any("::" in word for word in config.args)
        passed: dict[str, dict[str, list[str]]] = {}
        for name in self.drawn:
            file, test = name.split("::")
            if name not in self.failed:
                passed.setdefault(file, {})[test.removeprefix("test_").replace("_", " ")] = self.lines(name)
        write_page(PAGE, passed, is_whole)
        written = sum(map(len, passed.values()))
        terminalreporter.write_line(f"{PAGE.relative_to(ROOT)}: {written} claims written, {len(self.failed)} failed")

    def lines(self, name):
        """The ends of a test's lines in the table: all but its claim."""
        found = [(compared, margin) for (test, compared), margin in notes.found.items() if test == name]
        first = f"{self.drawn[name]:,}"
        if not found:
            return [row(first, "", "", "", "")]
        times = [f"{1.0 / margin.share:.2g}" if margin.share > 0.0 else "unused" for _, margin in found]
        counts = [first] + [""] * (len(found) - 1)
        return [row(n, f"`{text}`", m.asked, m.worst, x) for n, (text, m), x in zip(counts, found, times, strict=True)]


def row(*cells: str) -> str:
    """A line of a table."""
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def read_page(path: Path) -> dict[str, dict[str, list[str]]]:
    """By file and claim, the ends of the lines."""
    found: dict[str, dict[str, list[str]]] = {}
    for section in path.read_text(encoding="utf-8").split("\n## ")[1:] if path.is_file() else []:
        file, *lines = section.splitlines()
        claims, name = found.setdefault(file, {}), ""
        for line in (line for line in lines if line.startswith("| ") and not line.startswith(("| claim", "| ---"))):
            claim, end = line[2:].split(" |", 1)
            name = claim or name  # a claim's further lines do not name it
            claims.setdefault(name, []).append("|" + end)
    return found


def write_page(path: Path, passed: dict[str, dict[str, list[str]]], is_whole: bool) -> None:
    """The page with these claims anew; of files that ran whole no others are kept."""
    found = read_page(path)
    for file, claims in passed.items():
        found[file] = claims if is_whole else found.get(file, {}) | claims
    text = HEAD
    for file in sorted(found):
        text += f"\n## {file}\n\n{row(*COLUMNS)}\n{row(*['---'] * len(COLUMNS))}\n"
        for claim, ends in found[file].items():
            text += "".join(f"| {claim if i == 0 else ''} {end}\n" for i, end in enumerate(ends))
    path.write_text(text, encoding="utf-8")


def pytest_configure(config):
    config.pluginmanager.register(Sweep())
