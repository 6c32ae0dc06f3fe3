"""What pictures cost: the tables of docs/performance.md.

    python -m benchmarks.performance engines [--only 300k-1,1M-4]   beside the bare passes and Blender's engines (`bench`, a process a row)
    python -m benchmarks.performance updates                        what a change costs, 2,000 and 10,000 parts
    python -m benchmarks.performance curves                         cost over triangles, pixels, texels, partitions, parts, with slopes
    python -m benchmarks.performance start                          one picture as a whole process
    python -m benchmarks.performance --write                        the page, from what was measured

Processor time of all threads, medians; each table's run is kept in benchmarks/results/performance-*.json.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.performance_work import ROOT, curves, slope, start, updates

RESULTS, PAGE = ROOT / "benchmarks" / "results", ROOT / "docs" / "performance.md"
ENGINES = "workbench,cycles"


@dataclass(frozen=True)
class Case:
    """One `bench` run."""

    triangles: int
    samples: int
    size: str = "1280x720"
    frames: int = 3
    rivals: str = ENGINES


CASES = {
    "71k-1": Case(71_000, 1, frames=2),
    "71k-4": Case(71_000, 4, frames=2),
    "300k-1": Case(300_000, 1, frames=1, rivals="cycles"),
    "300k-4": Case(300_000, 4, frames=1, rivals="cycles"),
    "300k-1-workbench": Case(300_000, 1, frames=1, rivals="workbench"),
    "300k-1-eevee": Case(300_000, 1, frames=1, rivals="eevee"),
    "1M-1": Case(1_000_000, 1, frames=1, rivals="cycles"),
    "1M-4": Case(1_000_000, 4, frames=1, rivals="cycles"),
    "1M-1-workbench": Case(1_000_000, 1, frames=1, rivals="workbench"),
    "10M-1": Case(10_000_000, 1, frames=1, rivals="cycles"),
}


def engines(names: list[str]) -> Iterator[tuple[str, dict[str, object]]]:
    """The result of `bench` for each case."""
    for name in names:
        case = CASES[name]
        with tempfile.TemporaryDirectory() as folder:
            report = Path(folder) / "report.json"
            command = [sys.executable, "-m", "addon", "bench", "--example", str(case.triangles), "--samples", str(case.samples)]
            command += ["--size", case.size, "--frames", str(case.frames), "--report", str(report), "--rivals", case.rivals]
            subprocess.run(command, cwd=ROOT, check=True)
            yield name, found(json.loads(report.read_text()), "bench")


def found(tree: object, key: str) -> dict[str, object]:
    """The first value of that name in a tree of JSON."""
    if isinstance(tree, dict):
        if key in tree and isinstance(tree[key], dict):
            return tree[key]
        tree = list(tree.values())
    for branch in tree if isinstance(tree, list) else ():
        value = found(branch, key)
        if value:
            return value
    return {}


def kept(kind: str) -> dict[str, dict[str, object]]:
    """What was measured last."""
    path = RESULTS / f"performance-{kind}.json"
    return json.loads(path.read_text()) if path.is_file() else {}


def keep(kind: str, rows: dict[str, dict[str, object]]) -> None:
    """Note results beside those of other rows."""
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"performance-{kind}.json").write_text(json.dumps(kept(kind) | rows, indent=1) + "\n")


def table(rows: dict[str, dict[str, object]], head: str, shown: Callable[[object], str]) -> str:
    """A row a line, columns in the order of the first."""
    columns = list(dict.fromkeys(name for row in rows.values() for name in row))
    lines = [f"| {head} | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    lines += [f"| {name} | " + " | ".join(shown(row[c]) if c in row else "" for c in columns) + " |" for name, row in rows.items()]
    return "\n".join(lines) + "\n"


def engine_table(rows: dict[str, dict[str, object]]) -> str:
    """Processor milliseconds of every engine, and how often ours goes into each."""
    cells = {}
    for name in (n for n in CASES if n in rows):
        medians, ratios = rows[name]["median_cpu_ms"], rows[name]["ours_over_cpu"]
        label = (
            f"{rows[name]['triangles']:,} in {rows[name]['instances']:,}, {rows[name]['samples']} sample{'s' * (rows[name]['samples'] > 1)}"
        )
        cells[label] = {who: f"{ms:.0f}" + (f" ({ratios[who]:.2f})" if who in ratios else "") for who, ms in medians.items()}
    return table(cells, "triangles in instances", str)


def curve_table(rows: dict[str, dict[str, float]]) -> str:
    """Each curve a line, with the slope of its last step."""
    lines = ["| over | milliseconds at | slope |", "|---|---|---|"]
    for name, row in rows.items():
        lines.append(f"| {name} | " + ", ".join(f"{at}: {ms:.0f}" for at, ms in row.items()) + f" | {slope(row):.2f} |")
    return "\n".join(lines) + "\n"


def page() -> str:
    """docs/performance.md: a section for each table that was measured."""
    tables = {
        "engines": engine_table,
        "updates": lambda rows: table(rows, "parts", lambda ms: f"{ms:.0f}"),
        "curves": curve_table,
        "start": lambda rows: table(rows, "file", lambda s: f"{s:.2f}"),
    }
    there = {kind: kept(kind) for kind in tables if kept(kind)}
    loads = {kind: kept(f"{kind}-machine").get("machine", {}).get("load") for kind in there}
    told = ", ".join(f"{kind} {load}" for kind, load in loads.items() if load is not None)
    sections = "\n".join(f"{SECTIONS[kind]}\n{tables[kind](rows)}" for kind, rows in there.items())
    return f"{HEAD.format(loads=told)}\n{sections}\n{HOW}"


HEAD = """# Performance

Processor milliseconds of all threads (user and system), medians, on two cores without a GPU (Mesa's llvmpipe). Ratios are what counts:
the machine was busy with other work, its average load was {loads}, and a busy core makes every figure larger.
"""
SECTIONS = {
    "engines": """## Beside Blender's engines
`python -m benchmarks.performance engines`: 1280×720, maps of 4 × 1024², the camera turned by a degree each frame. All draw the same sun
with sharp shadows and as many samples; Cycles no bounces. In brackets: ours over it, the pipeline over the *bare passes* (all triangles,
one plain G-buffer draw and one depth draw a map, without shading), F12 over F12. *Blender alone* is an engine that draws nothing.
""",
    "updates": """## What a change costs
`python -m benchmarks.performance updates`: the frame after it, blocks of 108 triangles, 1280×720, one sample.
""",
    "curves": """## Curves
`python -m benchmarks.performance curves`: a frame with the camera moved, 640×360, one sample; the slope is that of the last step on
logarithmic scales, 1 in proportion.
""",
    "start": """## One picture as a whole process
`python -m benchmarks.performance start`: processor seconds from the shell to the file, 1280×720, 4 samples.
""",
}
HOW = """## How
- **Samples are one picture.** The camera's samples on a grid are the pixel centres of one picture of as many times the side: one G-buffer,
  one shading, averaged on the GPU. Pictures too large for that are drawn sample by sample.
- **The background is left out by the depth test**, before a shader runs; display, logarithm and test are compiled in.
- **Back faces of closed meshes are not drawn**, by the camera and by the maps: a mesh is closed when its boundary is zero and every shell
  of it encloses a positive volume or is a sheet with two sides (`addon/pipeline/geometry/closed.py`). What the near plane cuts, or what
  holds the eye, is drawn whole.
- **Small products stay small.** The fit's samples are multiplied by numpy's own loops; a linear-algebra library's threads cost many times
  the product.
- **Only what changed is drawn**: surfaces, projections, maps and the shaded picture are kept while what they depend on is; a moved part is
  placed anew alone; a colour changes the table of instances.
- **Many small meshes go together** to the GPU; a free range costs a search; what was hidden is drawn along as nothing instead of splitting
  draw calls.
- **Meshes are made drawable in blocks** that stay in the processor's cache.
"""
KINDS: dict[str, Callable[[list[str]], Iterator[tuple[str, dict[str, object]]]]] = {
    "engines": engines,
    "updates": lambda _: updates(),
    "curves": lambda _: curves(),
    "start": lambda _: start(),
}


def main() -> None:
    """Measure, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", nargs="?", choices=KINDS)
    parser.add_argument("--only", default=",".join(CASES))
    parser.add_argument("--write", action="store_true")
    choice = parser.parse_args()
    for name, row in KINDS[choice.kind](choice.only.split(",")) if choice.kind else ():
        keep(choice.kind, {name: row})
    if choice.kind:
        keep(f"{choice.kind}-machine", {"machine": {"load": round(os.getloadavg()[2], 1)}})
        print(json.dumps(kept(choice.kind), indent=1))
    if choice.write:
        PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
