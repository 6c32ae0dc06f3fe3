"""Shadows on grounds of any size: the table of docs/scale.md.

    python -m benchmarks.scale                   every case × every method, then the table (about ten minutes)
    python -m benchmarks.scale --cases 40        the first cases only; --first N begins later; --only 'uniform,triangle' some methods
    python -m benchmarks.scale --label before    rows under another name, for a program to compare with
    python -m benchmarks.scale --write           docs/scale.md anew from the rows that are there ('now' and 'before')

Truth is exact (`scale_scenes.py`). Rows go to benchmarks/results/scale-LABEL.jsonl. Those of 'before' are of 91b023b, drawn by this file
and `scale_scenes.py` as they were in 8462102.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from addon.errors import SceneError
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.scene.local_origin import based_near
from addon.settings.groups import Settings
from addon.studies.run import run
from addon.studies.truth.compare import COMPARED_PASSES, compare
from addon.studies.truth.tracer import Truth
from benchmarks.scale_scenes import SIZE, ScaleScene, scale_scene

RESULTS = Path(__file__).resolve().parent / "results"
CASES = 300
DEFAULTS = Settings()
METHODS = {
    "defaults": DEFAULTS,
    "triangle": DEFAULTS.replaced(test={"kind": "triangle"}),
    **{warp: DEFAULTS.replaced(warp={"kind": warp}) for warp in ("uniform", "psm", "lispsm", "lloyd", "tsm", "log", "logpsm")},
}


def based(truth: Truth, offset: np.ndarray) -> Truth:
    """The truth in a world whose origin lies at `offset`."""
    return replace(truth, point_ws=truth.point_ws - offset)


def rows_of(case: ScaleScene, methods: dict[str, Settings], renderer: Renderer) -> Iterator[dict[str, object]]:
    """One row a method: the report's `truth`, and the case in words."""
    truth = case.heap.truth(case.camera, case.light, SIZE)
    scene, camera, light = based_near(case.scene, case.camera, case.light)
    for name, settings in methods.items():
        begin = time.perf_counter()
        frame = run(Job(scene, camera, light, settings, SIZE, ("combined", *COMPARED_PASSES)), on=renderer).frame
        took = time.perf_counter() - begin
        try:
            metrics, _ = compare(frame, based(truth, scene.origin_ws - case.scene.origin_ws), camera, light, settings.fit.size)
        except SceneError:
            metrics = {"misclassified_pct": None, "acne_pct": None, "leak_pct": None, "pixels": 0}
        shown = np.mean((frame.passes["object"] != truth.object) & (truth.object >= 0))
        numbers = {key: metrics[key] for key in ("pixels", "misclassified_pct", "acne_pct", "leak_pct")}
        precision = (frame.measured or {}).get("precision")
        yield {
            "case": case.number,
            "method": name,
            **numbers,
            "other_surface_pct": 100.0 * shown,
            "ms": 1e3 * took,
            "precision": precision and precision["worst_ratio"],
            **case.words,
        }


def summary(rows: list[dict[str, object]]) -> str:
    """The table: one line a method."""
    lines = ["| method | pictures | wrong %, mean | worst | above 1 % | acne %, mean | worst | leak %, mean |", "|---" * 8 + "|"]
    for name in dict.fromkeys(row["method"] for row in rows):
        own = [row for row in rows if row["method"] == name and row["misclassified_pct"] is not None]
        wrong, acne, leak = (np.array([row[key] for row in own]) for key in ("misclassified_pct", "acne_pct", "leak_pct"))
        lines.append(
            f"| {name} | {len(own)} | {wrong.mean():.3f} | {wrong.max():.2f} | {(wrong > 1.0).sum()} | {acne.mean():.4f} | "
            f"{acne.max():.2f} | {leak.mean():.4f} |"
        )
    return "\n".join(lines)


def page() -> str:
    """docs/scale.md: what was measured, for this program and the one before."""
    lines = {name: (RESULTS / f"scale-{name}.jsonl").read_text().splitlines() for name in ("now", "before")}
    rows = {name: [row for row in map(json.loads, own) if row["method"] in METHODS] for name, own in lines.items()}
    known = [row["precision"] for row in rows["now"] if row["precision"] is not None]
    worst = f"The worst `precision.worst_ratio` of all pictures now: {max(known):.3f} texels.\n" if known else ""
    return TEMPLATE.format(
        cases=len({row["case"] for row in rows["now"]}),
        size="×".join(map(str, SIZE)),
        now=summary(rows["now"]),
        before=summary(rows["before"]),
        cases_before=len({row["case"] for row in rows["before"]}),
        grounds=by_ratio(rows),
        worst=worst,
    )


def by_ratio(rows: dict[str, list[dict[str, object]]]) -> str:
    """Wrong % of the defaults by the decade of ground over part, now and before."""
    lines = ["| ground / part | wrong %, now | worst | wrong %, before | worst |", "|---" * 5 + "|"]
    for decade in range(5):
        cells = []
        for name in ("now", "before"):
            drawn = [row for row in rows[name] if row["method"] == "defaults" and row["misclassified_pct"] is not None]
            own = [row["misclassified_pct"] for row in drawn if 10**decade <= row["ratio"] < 10 ** (decade + 1)]
            cells += [f"{np.mean(own):.3f}", f"{max(own):.2f}"]
        lines.append(f"| {10**decade:,} – {10 ** (decade + 1):,} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


TEMPLATE = """# Every scale

A part on a ground: how far can the ground reach before the shadows suffer? They do not: choose the test and the warp by what
[Quality](quality.md) says, whatever the size of the site. The report's `measured.precision` tells what float32 loses in the maps, in
texels, and a warning line appears where that could be seen.

{cases} random scenes (`python -m benchmarks.scale`): a heap of blocks on a ground of 1 to 100,000 times its size, as one quad, a grid or
tiles, level or tilted, the heap at its middle or off it, also at UTM coordinates; sun at 2° to 88°, spot, point; perspective, low views
with the horizon, orthographic, a lens of 0.5°. {size} pixels, four maps of 1024², exact float64 truth.

{now}

The program before (91b023b), {cases_before} of the same scenes:

{before}

By the ground's size, with the defaults:

{grounds}

{worst}
## How
- **Huge casters are cut to the map in float64** (`addon/maths`, `cut`): in clip coordinates before the division the borders of a
  map are planes, whatever its warp. A rasteriser clips in float32: a triangle that reaches k footprints beyond the map is off by
  k · 2⁻²³ of it, and by more where it passes the plane w = 0. What is larger than 64 half
  footprints is cut: on ordinary scenes nothing.
- **Places count from near the eye**: vertices from a local origin that follows the eye in a large scene, matrices from a point just before
  it; so no large numbers cancel.
- **The map's depth goes to what is near**: casters more than 16 footprints above the highest receiver (for a lamp: nearer to it than a
  quarter of the nearest receiver's distance) are flattened onto the near plane, where they cover all the same.
- **Planes of huge receivers** are worked out in float64 and looked up: a corner 20 km away leaves millimetres of doubt at the eye's feet.
- **A lamp reaches as far as what it lights**, not as the scene: it does not shadow what is nearer than 10⁻⁴ of that.

## What it costs
Ordinary scenes beside the program before (91b023b), frame by frame in turns, 1280×720, medians of 20 frames
(`python -m benchmarks.stages`):

| scene | G-buffer, ms | map pass, ms |
|---|---|---|
| a deck of 1 million triangles | 159.7 → 172.0 (1.08 ×) | 326.0 → 324.1 (0.99 ×) |
| huldra_utilities.glb | 59.9 → 64.4 (1.08 ×) | 85.5 → 85.6 (1.00 ×) |
| amazing_hand.glb | 156.2 → 165.9 (1.06 ×) | 299.0 → 280.5 (0.94 ×) |

The G-buffer, with float depth and near and far fitted to what is seen, takes 6 to 8 % longer; the maps are as quick as they were.

Two surfaces close behind one another, seen from far: [their own table](scale_plates.md).
"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", default=",".join(METHODS))
    parser.add_argument("--label", default="now")
    parser.add_argument("--worst", type=int, default=0, help="print so many worst rows")
    parser.add_argument("--write", action="store_true")
    choice = parser.parse_args()
    if choice.write:
        (RESULTS.parents[1] / "docs" / "scale.md").write_text(page(), encoding="utf-8")
        return
    methods = {name: METHODS[name] for name in choice.only.split(",")}
    renderer, rows = Renderer(), []
    for number in range(choice.first, choice.first + choice.cases):
        for row in rows_of(scale_scene(number), methods, renderer):
            rows.append(row)
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"scale-{choice.label}.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    print(summary(rows))
    for row in sorted(rows, key=lambda row: -(row["misclassified_pct"] or 0.0))[: choice.worst]:
        print({key: round(value, 4) if isinstance(value, float) else value for key, value in row.items()})


if __name__ == "__main__":
    main()
