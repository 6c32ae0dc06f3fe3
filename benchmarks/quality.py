"""The tables of docs/quality.md, each made by one command:

    python -m benchmarks.quality first-light      uniform against generalised LiSPSM on the deck; samples against scene fit from outside
    python -m benchmarks.quality methods          every warp and partition × every model at 4 Mi texels (hours; --models narrows)
    python -m benchmarks.quality bias             bias strategies over 20 light elevations
    python -m benchmarks.quality exact            triangle-exact test against the depth test
    python -m benchmarks.quality write            docs/quality.md anew from what was measured

Needs bpy and embreex. Rows go to benchmarks/results/*.jsonl as they come; `write` is run at the end of each.
"""

from __future__ import annotations

import argparse
import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import bpy
import numpy as np

from benchmarks import tables
from benchmarks.measure import kept, measure
from benchmarks.methods import BIAS_METHODS, ELEVATIONS, EXACT_METHODS, FIRST_LIGHT_FIT, FIRST_LIGHT_WARP, METHODS
from benchmarks.models import available

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).resolve().parent / "results"
OUTSIDE = ("huldra_utilities.glb", "tower_crane.glb")


def chosen(names: list[str] | None, fallback: tuple[str, ...]) -> tuple[str, ...]:
    """The models asked for, else those of `fallback` that are here."""
    return tuple(names) if names else tuple(name for name in fallback if name in available())


def run_first_light(names: list[str] | None) -> None:
    """Issue "First light", second point."""
    kept(RESULTS / "first-light-warp.jsonl", measure(chosen(names, ("deck",)), FIRST_LIGHT_WARP))
    kept(RESULTS / "first-light-fit.jsonl", measure(chosen(names, OUTSIDE), FIRST_LIGHT_FIT))


def run_methods(names: list[str] | None) -> None:
    """Issue "Every parameterisation", the table of methods × models."""
    kept(RESULTS / "methods.jsonl", measure(chosen(names, available()), METHODS))


def run_bias(names: list[str] | None) -> None:
    """Issue "Shadow tests", bias: one view per model, 20 elevations."""
    rows = measure(chosen(names, available()), BIAS_METHODS, elevations=ELEVATIONS, only_first_view=True, size=(320, 180))
    kept(RESULTS / "bias.jsonl", rows)


def run_exact(names: list[str] | None) -> None:
    """Issue "Shadow tests", triangle-exact."""
    kept(RESULTS / "exact.jsonl", measure(chosen(names, available()), EXACT_METHODS))


RUNS: dict[str, Callable[[list[str] | None], None]] = {
    "first-light": run_first_light, "methods": run_methods, "bias": run_bias, "exact": run_exact}


def machine() -> str:
    """One line on what made the numbers."""
    return (f"Blender {bpy.app.version_string} (bpy), Python {platform.python_version()}, numpy {np.__version__}, "
            f"Embree through embreex {version('embreex')}, {platform.system()} {platform.machine()}")


def main() -> None:
    """Run one table and write the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.quality", description=__doc__.split("\n")[0])
    parser.add_argument("table", choices=(*RUNS, "write"))
    parser.add_argument("--models", nargs="+", metavar="NAME", help="only these (deck, or file names of ../shared/cad/dev)")
    args = parser.parse_args()
    if args.table != "write":
        RUNS[args.table](args.models)
    tables.write(ROOT / "docs" / "quality.md", RESULTS, machine())


if __name__ == "__main__":
    main()
