"""Advice as the report's JSON and as a table to read. Unknown is None; numbers are those of the search."""

from __future__ import annotations

from math import exp, inf

from ...maths.partitioning import PARTITION_SCHEMES
from .search import Advice, Row
from .shadow_tests import TestedRow

COLUMNS = ("warp", "partition", "fit", "maps", "size", "Mi texels", "m median", "p95", "p99", "above 1", "theory")


def advice_report(advice: Advice) -> dict[str, object]:
    """`goal`, `proposal` (None when the goal is out of reach), `current`, `table` (best first), `tried`, `frames`, `notes`."""
    proposal = None
    if advice.best is not None:
        proposal = {
            **row_of(advice.best),
            "options": _listed(proposed_options(advice)),
            "splits": [list(splits) for splits in advice.splits],
            "rendered": advice.confirmed,
        }
    return {
        "goal": {"texels": advice.goal.texels, "error": advice.goal.error},
        "frames": [frame.number for frame in advice.frames],
        "tried": advice.tried,
        "proposal": proposal,
        "current": {**row_of(advice.current), "rendered": advice.confirmed_current},
        "table": [row_of(row) for row in advice.rows],
        "tests": [{**row.options, "differs_pct": row.differs_pct, "total_ms": row.total_ms} for row in advice.tests],
        "notes": list(advice.notes),
    }


def proposed_options(advice: Advice) -> dict[str, object]:
    """The proposal by the names of `options.OPTIONS`: its maps, its test, and what else of the test is not as it was."""
    options = advice.best.candidate.options | {"map_size": advice.best.size}
    if advice.test is None:
        return options
    before, after = advice.frames[0].job.settings.test, advice.test.options
    changed = {name: value for name, value in after.items() if name != "test" and value != getattr(before, name)}
    return options | {"test": after["test"]} | changed


def row_of(row: Row) -> dict[str, object]:
    """One combination as JSON: its options, what it costs, what was measured, and the theory's largest m for the same texels (or None)."""
    c = row.candidate
    return {
        "warp": c.warp,
        "partition": c.partition,
        "partitions": c.count,
        "fit": c.fit,
        "alpha": None if c.alpha is None else list(c.alpha),
        "split_weight": c.split_weight,
        "log_bend": c.log_bend,
        "maps": row.maps,
        "map_size": row.size,
        "texels": row.texels,
        "frames": row.frames,
        "measured": row.measured,
        "theory_rank": None if row.predicted == inf else exp(row.predicted),
    }


def _listed(options: dict[str, object]) -> dict[str, object]:
    return {name: list(value) if isinstance(value, tuple) else value for name, value in options.items()}


def cells_of(row: Row) -> tuple[str, ...]:
    """The row as short words, in the order of `COLUMNS`."""
    c, m = row.candidate, row.measured
    partition = c.partition if not PARTITION_SCHEMES[c.partition].divides_depth else f"{c.partition} × {c.count}"
    theory = "–" if row.predicted == inf else f"{exp(row.predicted):.3g}"
    return (
        c.warp,
        partition,
        c.fit,
        str(row.maps),
        str(row.size),
        f"{row.texels / 2**20:.2f}",
        f"{m['m_median']:.3g}",
        f"{m['m_p95']:.3g}",
        f"{m['m_p99']:.3g}",
        f"{100 * m['share_above_1']:.1f} %",
        theory,
    )


def advice_table(advice: Advice, most: int = 12) -> str:
    """The best `most` rows and the scene's own, one line each, with a heading; then the notes."""
    rows = [("", *COLUMNS)]
    rows += [("→" if row is advice.best else "", *cells_of(row)) for row in advice.rows[:most]]
    rows.append(("now", *cells_of(advice.current)))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [
        " ".join(cell.ljust(w) if i < 4 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths, strict=True))) for row in rows
    ]
    return "\n".join([*lines, *(_test_line(row, row is advice.test) for row in advice.tests), *advice.notes])


def _test_line(row: TestedRow, is_proposed: bool) -> str:
    """A shadow test of the proposal as a line."""
    name = row.choice.kind + (" with outlines" if row.choice.has_outlines else "")
    mark = ": proposed" if is_proposed else ""
    return f"test {name}: {row.differs_pct:.3g} % of the pixels differ from the most exact, {row.total_ms:.0f} ms{mark}"
