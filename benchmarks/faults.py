"""Faults put in wherever the work can stop; for docs/reliability.md:

python -m benchmarks.faults [--only driver|Esc|disk|processes] [--step 1]      rows to benchmarks/results/faults.json; half an hour
python -m benchmarks.reliability                                              docs/reliability.md anew from the rows that are there
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from benchmarks.fault_jobs import CASES, Fault, Reference, driver_faults, escapes
from benchmarks.gl_faults import KINDS
from benchmarks.reliability import RESULTS, rows

PATH = RESULTS / "faults.json"
HEADS = ("what fails", "in", "places", "faults", "did not hold")


def driver(step: int) -> Iterator[dict[str, object]]:
    """The driver, at every object that it is asked for."""
    for name, job in CASES.items():
        reference = Reference(job)
        first = 0 if name == "a picture" else reference.first
        yield _row(f"the driver: {', '.join(KINDS)}", name, len(reference.points) - first, driver_faults(reference, first, step))


def esc(_step: int) -> Iterator[dict[str, object]]:
    """Esc, at every stage."""
    for name, job in CASES.items():
        found = list(escapes(Reference(job)))
        yield _row("Esc", name, len(found), found)


def disk(step: int) -> Iterator[dict[str, object]]:
    """The disk, at every write of every command."""
    from addon.__main__ import attached
    from addon.cli.main import main
    from benchmarks.disk_faults import COMMANDS, Command

    with attached(), tempfile.TemporaryDirectory() as folder:
        for name in COMMANDS:
            command = Command(main, name, Path(folder))
            yield _row("the disk: full, broken, full after some bytes", f"`{name}`", len(command.points), command.faults(step))


def processes(_step: int) -> Iterator[dict[str, object]]:
    """Processes of our own, at every message."""
    from benchmarks.child_faults import reading_faults, rendering_faults

    for name, faults in (("rendering in a process of its own", rendering_faults), ("reading a CAD file", reading_faults)):
        found = list(faults())
        yield _row("the other process: killed", name, len(found), found)


PARTS = {"driver": driver, "Esc": esc, "disk": disk, "processes": processes}


def _row(what: str, place: str, places: int, faults: Iterable[Fault]) -> dict[str, object]:
    count, wrong = 0, []
    for fault in faults:
        count += 1
        if fault.wrong:
            wrong.append(fault)
            print(fault, flush=True)
    return dict(zip(HEADS, (what, place, places, count, len(wrong)), strict=True))


def table(found: list[dict[str, object]]) -> str:
    """The rows as docs/reliability.md has them."""
    lines = ["| " + " | ".join(HEADS) + " |", "|" + "---|" * len(HEADS)]
    total = dict.fromkeys(HEADS[:2], "") | {HEADS[0]: "all"} | {head: sum(row[head] for row in found) for head in HEADS[2:]}
    return "\n".join([*lines, *("| " + " | ".join(f"{row[head]}" for head in HEADS) + " |" for row in (*found, total))])


def main() -> None:
    """Put the faults in; rows of before for the same place are replaced."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=PARTS)
    parser.add_argument("--step", type=int, default=1, help="every so many-th place only, each in one way")
    choice = parser.parse_args()
    for name in [choice.only] if choice.only else PARTS:
        for row in PARTS[name](choice.step):
            print(json.dumps(row), flush=True)
            kept = [one for one in rows("faults") if [one[head] for head in HEADS[:2]] != [row[head] for head in HEADS[:2]]]
            PATH.write_text(json.dumps([*kept, row], indent=1) + "\n")


if __name__ == "__main__":
    main()
