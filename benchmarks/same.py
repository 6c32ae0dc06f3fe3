"""Whether two checkouts do the same: pictures bit for bit, help texts, options and report keys, by the command line of each.

    python -m benchmarks.same ../other [--size 320x180]

Draws the dev models and the deck with five settings, all passes, in both; prints what differs and ends with 1 if anything does.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from addon.cli.commands import COMMANDS

ROOT = Path(__file__).resolve().parents[1]
CAD_DEV = ROOT.parent / "shared" / "cad" / "dev"
PASSES = "combined,shadow,depth,normal,object,partition,aliasing"
SETTINGS = (
    (),
    ("--test", "triangle", "--outlines", "--samples", "1"),
    ("--warp", "logpsm", "--partition", "none", "--pcf", "9"),
    ("--partition", "faces", "--fit", "scene", "--test", "id-depth"),
    ("--warp", "psm", "--cut", "view", "--depths", "4", "--samples", "1"),
)
TIMES = {"timing_ms", "version"}


def command(checkout: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """The command line of a checkout."""
    environment = {**os.environ, "COLUMNS": "120", "PYTHONPATH": str(checkout)}
    return subprocess.run([sys.executable, "-m", "addon", *words], cwd=checkout, env=environment, capture_output=True, text=True)


def pictures(checkout: Path, folder: Path, size: str, models: list[str]) -> None:
    """All settings of all models as npz files with their reports."""
    for number, settings in enumerate(SETTINGS):
        output = folder / str(number)
        words = ("preview", *models, "--deck", "100000", "--size", size, "--passes", PASSES, "--format", "npz", "-o", str(output))
        done = command(checkout, *words, "--report", str(output / "report.json"), "--quiet", *settings)
        if done.returncode:
            print(f"{checkout}, settings {number}: exit code {done.returncode}\n{done.stderr[-500:]}")


def keys(value: object) -> object:
    """The shape of a report: keys, and the kinds of values."""
    if isinstance(value, dict):
        return {key: keys(one) for key, one in sorted(value.items()) if key not in TIMES}
    return [keys(value[0])] if isinstance(value, list) and value else type(value).__name__


def differences(a: Path, b: Path) -> list[str]:
    """What differs between the files of two folders."""
    out, names = [], sorted(path.relative_to(a) for path in a.rglob("*.npz"))
    if names != sorted(path.relative_to(b) for path in b.rglob("*.npz")):
        out.append("the folders hold different files")
    for name in names:
        with np.load(a / name) as old, np.load(b / name) as new:
            out += [f"{name}: {key}" for key in old.files if key not in new.files or not np.array_equal(old[key], new[key], equal_nan=True)]
    for path in a.rglob("report.json"):
        pair = [json.loads((folder / path.relative_to(a)).read_text(encoding="utf-8")) for folder in (a, b)]
        out += [f"{path.parent.name}: report keys"] if keys(pair[0]) != keys(pair[1]) else []
    print(f"{len(names)} npz files compared")
    return out


def main() -> None:
    """Compare and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path)
    parser.add_argument("--size", default="320x180")
    choice = parser.parse_args()
    checkouts = [choice.other.resolve(), ROOT]
    models = [str(path) for path in sorted(CAD_DEV.glob("*")) if path.suffix in {".glb", ".obj", ".stl", ".ply", ".step"}]
    out = [f"--help of {name or 'the program'}" for name in ("", *COMMANDS) if len({_help(one, name) for one in checkouts}) > 1]
    with tempfile.TemporaryDirectory() as folder:
        for number, checkout in enumerate(checkouts):
            pictures(checkout, Path(folder) / str(number), choice.size, models)
        out += differences(Path(folder) / "0", Path(folder) / "1")
    print("\n".join(out) if out else "the same")
    sys.exit(bool(out))


def _help(checkout: Path, name: str) -> str:
    return command(checkout, *([name] if name else []), "--help").stdout


if __name__ == "__main__":
    main()
