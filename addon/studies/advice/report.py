"""Advice as the report's JSON and as a table to read. Unknown is None; numbers are those of the search."""

from __future__ import annotations

from math import exp, inf

from ...maths.partitioning import PARTITION_SCHEMES
from .search import Advice, Row

COLUMNS = ("warp", "partition", "fit", "maps", "size", "Mi texels", "m median", "p95", "p99", "above 1", "theory")


def advice_report(advice: Advice) -> dict[str, object]:
    """`goal`, `proposal` (None when the goal is out of reach), `current`, `table` (best first), `tried`, `frames`, `notes`."""
    proposal = None
    if advice.best is not None:
        proposal = {
            **row_of(advice.best),
            "options": _listed(advice.best.candidate.options | {"map_size": advice.best.size}),
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
        "notes": list(advice.notes),
    }


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
    return "\n".join([*lines, *advice.notes])
