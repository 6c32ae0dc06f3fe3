"""The tables of docs/quality.md, each made by one command:

    python -m benchmarks.quality first-light      uniform against generalised LiSPSM on the deck; samples against scene fit from outside
    python -m benchmarks.quality methods          every warp and partition × every model at 4 Mi texels (hours; --models, --only narrow)
    python -m benchmarks.quality texels           the size of their texels in the picture, without truth (minutes)
    python -m benchmarks.quality bias             bias strategies over 20 light elevations
    python -m benchmarks.quality exact            triangle-exact test against the depth test
    python -m benchmarks.quality lamps            spots and point lights: uniform, warped, four maps at equal texels (minutes)
    python -m benchmarks.quality write            docs/quality.md anew from what was measured

Needs bpy and embreex. Rows go to benchmarks/results/*.jsonl as they come; `write` is run at the end of each. With `--resume` what is
there already is not measured again; without it, the chosen rows are measured anew and the others stay. With `--check` nothing is
written: the chosen rows are measured again and compared with those that are there.
"""

from __future__ import annotations

import argparse
import platform
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from importlib.metadata import version
from pathlib import Path
from statistics import fmean

import bpy
import numpy as np

from addon.settings.groups import Settings
from benchmarks import tables, texels
from benchmarks.measure import Row, kept, measure, read
from benchmarks.methods import BIAS_METHODS, ELEVATIONS, EXACT_METHODS, FIRST_LIGHT_FIT, FIRST_LIGHT_WARP, LAMP_METHODS, METHODS
from benchmarks.models import available

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).resolve().parent / "results"
OUTSIDE = ("huldra_utilities.glb", "tower_crane.glb")


@dataclass(frozen=True)
class Choice:
    """What of a table is measured: models (None: the table's own), methods by patterns, every n-th light, and whether rows that are
    there stay."""

    models: list[str] | None
    only: list[str]
    every: int
    resume: bool
    check: bool

    def names(self, fallback: tuple[str, ...]) -> tuple[str, ...]:
        """The models asked for, else those of `fallback` that are here."""
        return tuple(self.models) if self.models else tuple(name for name in fallback if name in available())


def run(choice: Choice, table: str, models: tuple[str, ...], methods: Mapping[str, Settings], **how: object) -> None:
    """The chosen rows of one table, measured and put in the place of earlier ones. Earlier rows of other models and methods stay."""
    models = choice.names(models)
    methods = {name: value for name, value in methods.items() if any(fnmatch(name, pattern) for pattern in choice.only)}
    path = RESULTS / f"{table}.jsonl"
    there = read(path) if path.is_file() else []
    if choice.check:
        print(difference(there, measure(models, methods, every=choice.every, **how)))
        return
    stay = [row for row in there if choice.resume or row.model not in models or row.method not in methods]
    kept(path, measure(models, methods, known={row.key for row in stay}, every=choice.every, **how), stay)


def difference(there: Iterable[Row], again: Iterable[Row]) -> str:
    """How far rows measured again are from those that are there, by the state of the renderer that made them."""
    known, lines = {row.key: row for row in there}, {}
    for row in again:
        if before := known.get(row.key):
            lines.setdefault(before.code, []).append(abs((row.misclassified_pct or 0.0) - (before.misclassified_pct or 0.0)))
    return "\n".join(
        f"{code or 'unmarked'}: {len(off)} rows again, {sum(d < 5e-4 for d in off)} the same; misclassified % differs "
        f"by {fmean(off):.4f} on average, {max(off):.4f} at most"
        for code, off in lines.items()
    )


def run_first_light(choice: Choice) -> None:
    """The warps on the deck, and the fits on models that are looked at from outside."""
    run(choice, "first-light-warp", ("deck",), FIRST_LIGHT_WARP)
    run(choice, "first-light-fit", OUTSIDE, FIRST_LIGHT_FIT)


def run_methods(choice: Choice) -> None:
    """Every warp and partition over the models."""
    run(choice, "methods", available(), METHODS)


def run_texels(choice: Choice) -> None:
    """The same methods and models by the size of their texels. Always whole: it takes minutes."""
    texels.write(RESULTS / "texels.jsonl", texels.measure(choice.names(available()), METHODS))


def run_bias(choice: Choice) -> None:
    """Strategies of bias: one view per model, 20 elevations."""
    run(choice, "bias", available(), BIAS_METHODS, elevations=ELEVATIONS, only_first_view=True, size=(320, 180))


def run_exact(choice: Choice) -> None:
    """The triangle-exact test: one view per model, five lights."""
    run(choice, "exact", available(), EXACT_METHODS, only_first_view=True)


def run_lamps(choice: Choice) -> None:
    """Spots and point lights: one view per model, six lamps."""
    run(choice, "lamps", available(), LAMP_METHODS, only_first_view=True, lamps=True)


RUNS: dict[str, Callable[[Choice], None]] = {
    "first-light": run_first_light,
    "methods": run_methods,
    "texels": run_texels,
    "bias": run_bias,
    "exact": run_exact,
    "lamps": run_lamps,
}


def machine() -> str:
    """One line on what made the numbers."""
    return (
        f"Blender {bpy.app.version_string} (bpy), Python {platform.python_version()}, numpy {np.__version__}, "
        f"Embree through embreex {version('embreex')}, {platform.system()} {platform.machine()}"
    )


def main() -> None:
    """Run one table and write the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.quality", description=__doc__.split("\n")[0])
    parser.add_argument("table", choices=(*RUNS, "write"))
    parser.add_argument("--models", nargs="+", metavar="NAME", help="only these (deck, or file names of ../shared/cad/dev)")
    parser.add_argument(
        "--only", nargs="+", default=["*"], metavar="PATTERN", help="only methods whose name matches one of these, such as '*one map*'"
    )
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only every N-th light of a view (--resume fills in the rest)")
    parser.add_argument("--resume", action="store_true", help="keep the rows that are there, measure what is missing")
    parser.add_argument("--check", action="store_true", help="write nothing: measure the chosen rows again, say how far they differ")
    args = parser.parse_args()
    if args.table != "write":
        RUNS[args.table](Choice(args.models, args.only, args.every, args.resume, args.check))
    if not args.check:
        tables.write(ROOT / "docs" / "quality.md", RESULTS, machine())


if __name__ == "__main__":
    main()
