"""Comparisons that note their worst, and the page made of them."""

import numpy as np
import pytest

from tests import margins, sweep
from tests.margins import agree, at_most


@pytest.fixture
def notes(monkeypatch):
    """Fresh notes that are kept."""
    monkeypatch.setattr(margins, "notes", margins.Notes())
    margins.notes.are_kept = True
    return margins.notes


@pytest.mark.parametrize(
    ("seen", "expected", "limits", "holds"),
    [
        (1.0 + 2e-10, 1.0, {"rel": 1e-9}, True),
        (1.0 + 2e-9, 1.0, {"rel": 1e-9}, False),
        ([0.0, 5.0], [0.1, 5.4], {"rel": 0.1, "abs": 0.2}, True),
        ([0.0, 5.0], [0.3, 5.4], {"rel": 0.1, "abs": 0.2}, False),
        (np.inf, np.inf, {"rel": 1e-9}, True),
        (1.0, np.inf, {"rel": 1e-9}, False),
        (np.nan, 1.0, {"abs": 10.0}, False),
        ([], [], {"abs": 1.0}, True),
    ],
)
def test_numbers_agree_to_the_larger_of_both_tolerances(seen, expected, limits, holds):
    if holds:
        agree(seen, expected, **limits)
    else:
        with pytest.raises(AssertionError):
            agree(seen, expected, **limits)


@pytest.mark.parametrize("seen", [2.0, [1.0, 1.5], np.nan])
def test_what_is_above_its_limit_or_no_number_fails(seen):
    with pytest.raises(AssertionError):
        at_most(seen, 1.0)


def test_the_worst_of_every_comparison_is_noted_by_its_source(notes):
    for error in (1e-4, 3e-3, 2e-3):
        agree(2.0 + 2.0 * error, 2.0, rel=0.01)
        at_most(error, 0.004)
    (_, (first, second)), worst = zip(*notes.found, strict=True), list(notes.found.values())
    assert (first, second) == ("2.0 + 2.0 * error is 2.0", "error ≤ 0.004")
    assert [m.share for m in worst] == pytest.approx([0.3, 0.75])
    assert [(m.asked, m.worst) for m in worst] == [("0.01 relative", "0.003 relative"), ("0.004", "0.003")]


def test_a_page_keeps_what_did_not_run(tmp_path):
    page, line = tmp_path / "margins.md", sweep.row("2,000", "`a | b`", "1", "0.5", "2")
    more = sweep.row("", "`c`", "1", "0", "unused")
    whole = {"tests/b.py": {"it holds": [line, more], "it stays": [line]}, "tests/a.py": {"it holds": [line]}}
    sweep.write_page(page, whole, True)
    assert sweep.read_page(page) == whole
    text = page.read_text(encoding="utf-8")
    assert text.index("## tests/a.py") < text.index("## tests/b.py") and r"| it holds | 2,000 | `a \| b` | 1 | 0.5 | 2 |" in text
    sweep.write_page(page, {"tests/b.py": {"it holds": [line]}}, False)
    assert sweep.read_page(page) == whole | {"tests/b.py": {"it holds": [line], "it stays": [line]}}
    sweep.write_page(page, {"tests/b.py": {"it holds": [line]}}, True)
    assert sweep.read_page(page) == whole | {"tests/b.py": {"it holds": [line]}}
