"""Shadows on grounds of any size: the table of docs/scale.md.

    python -m benchmarks.scale                   every case × every method, then the table (about ten minutes)
    python -m benchmarks.scale --cases 40        the first cases only; --first N begins later; --only 'uniform,triangle' some methods
    python -m benchmarks.scale --label before    rows under another name, for a program to compare with

Truth is exact (`scale_scenes.py`). Rows go to benchmarks/results/scale-LABEL.jsonl.
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
from addon.pipeline.local_origin import based_near
from addon.pipeline.renderer import Renderer
from addon.pipeline.settings import Settings
from addon.truth.compare import COMPARED_PASSES, compare
from addon.truth.tracer import Truth
from benchmarks.scale_scenes import SIZE, ScaleScene, scale_scene

RESULTS = Path(__file__).resolve().parent / "results"
CASES = 300
DEFAULTS = Settings()
METHODS = {
    "defaults": DEFAULTS,
    "triangle": DEFAULTS.replaced(test={"kind": "triangle"}),
    "fit scene": DEFAULTS.replaced(fit={"kind": "scene"}),
    **{warp: DEFAULTS.replaced(warp={"kind": warp}) for warp in ("uniform", "psm", "lispsm", "lloyd", "tsm", "log", "logpsm")},
}


def based(truth: Truth, offset: np.ndarray) -> Truth:
    """The truth in a world whose origin lies at `offset`."""
    return replace(truth, point_ws=truth.point_ws - offset)


def rows_of(case: ScaleScene, methods: dict[str, Settings], renderer: Renderer) -> Iterator[dict[str, object]]:
    """One row a method: the contract's `truth`, and the case in words."""
    truth = case.heap.truth(case.camera, case.light, SIZE)
    scene, camera, light = based_near(case.scene, case.camera, case.light)
    for name, settings in methods.items():
        begin = time.perf_counter()
        frame = renderer.render(scene, camera, light, settings, SIZE, ("combined", *COMPARED_PASSES))
        took = time.perf_counter() - begin
        try:
            metrics, _ = compare(frame, based(truth, scene.origin_ws - case.scene.origin_ws), camera, light, settings.fit.size)
        except SceneError:
            metrics = {"misclassified_pct": None, "acne_pct": None, "leak_pct": None, "pixels": 0}
        shown = np.mean((frame.passes["object"] != truth.object) & (truth.object >= 0))
        numbers = {key: metrics[key] for key in ("pixels", "misclassified_pct", "acne_pct", "leak_pct")}
        precision = (frame.measured or {}).get("precision")
        yield {"case": case.number, "method": name, **numbers, "other_surface_pct": 100.0 * shown, "ms": 1e3 * took,
               "precision": precision and precision["worst_ratio"], **case.words}


def summary(rows: list[dict[str, object]]) -> str:
    """The table: one line a method."""
    lines = ["| method | pictures | wrong %, mean | worst | above 1 % | acne %, mean | worst | leak %, mean |", "|---" * 8 + "|"]
    for name in dict.fromkeys(row["method"] for row in rows):
        own = [row for row in rows if row["method"] == name and row["misclassified_pct"] is not None]
        wrong, acne, leak = (np.array([row[key] for row in own]) for key in ("misclassified_pct", "acne_pct", "leak_pct"))
        lines.append(f"| {name} | {len(own)} | {wrong.mean():.3f} | {wrong.max():.2f} | {(wrong > 1.0).sum()} | {acne.mean():.4f} | "
                     f"{acne.max():.2f} | {leak.mean():.4f} |")
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", default=",".join(METHODS))
    parser.add_argument("--label", default="now")
    parser.add_argument("--worst", type=int, default=0, help="print so many worst rows")
    choice = parser.parse_args()
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
