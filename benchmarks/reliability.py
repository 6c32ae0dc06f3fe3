"""docs/reliability.md, from the rows that `benchmarks.attack`, `benchmarks.faults` and `benchmarks.soak` have written:

python -m benchmarks.reliability
"""

from __future__ import annotations

import json
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"
PAGE = Path(__file__).resolve().parents[1] / "docs" / "reliability.md"


def rows(name: str) -> list[dict]:
    """The rows of a benchmark; none before it has run."""
    path = RESULTS / f"{name}.json"
    return json.loads(path.read_text()) if path.is_file() else []


def page() -> str:
    """The whole page."""
    from benchmarks import attack, faults, soak

    text = TEXT.replace("ATTACKED", attack.table(rows("attack"))).replace("FAULTS", faults.table(rows("faults")))
    return text.replace("SOAK\n", soak.section(rows("soak")))


def write_page() -> None:
    """Write it."""
    PAGE.write_text(page(), encoding="utf-8")


TEXT = """# Reliability

Files come from strangers. Each is read in a process of its own, within limits of time and memory
([preferences](panels.md#preferences)); what goes wrong there is one line in Blender, and the other files of a batch are drawn.

## Damaged files
Small valid files of each format, damaged at random: bytes and numbers changed, ends cut off, lines and pieces moved
(`python -m benchmarks.attack`; limits 20 s and 2,048 MiB). A damaged file may still be a valid one: it is *read*, and the model is
sound (finite, every corner a vertex, every part in its place); or it is *refused* in one line. *Contained* is what crashed, hung or
filled the memory of the reading process, and came out as one line too. A model that is not sound, a message of several lines, a
traceback: none may come.

ATTACKED

A subset of these files is a test.

## Faults put in
Where the driver, the disk, a process or the user can stop the work, each place in turn is made to
(`python -m benchmarks.faults`). The places are found by running: every object that OpenGL is asked for, every file that Python opens
for writing, every message between processes, every stage. Afterwards must hold: one line says what went wrong, with the right exit
code; the same picture and the one of before are right to the last bit; every file is the old one or a whole new one; no object of
OpenGL's, no thread, no process and no temporary file is left. Where there are fewer faults than places, every second place of the
driver's (each in one of the ways, in turn) and every fourth write was tried (`--step`).

FAULTS

A fault of the driver costs its context: the next picture is made in a new one. A part of these faults is in the tests.
SOAK
"""

if __name__ == "__main__":
    write_page()
