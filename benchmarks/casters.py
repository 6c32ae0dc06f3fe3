"""Coarser casters against full ones: what a map pass takes, and how many pixels are lit wrongly.

    python -m benchmarks.casters [--models NAME …] [--errors 0.25 0.5 1] [--frames 7] [--write]

The dev models of more than a hundred thousand triangles, three views each, sun from the side, 4 maps of 1024², default settings.
Milliseconds are processor time of all threads, median of frames drawn in turns while the camera turns; misclassified pixels are counted
at 640×360 against ray-traced truth. `--write` puts the table into docs/performance.md. Needs bpy and embreex.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, median
from textwrap import fill

import moderngl
import numpy as np

from addon.pipeline import renderer
from addon.pipeline.gl.gl_raw import finish
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.settings.groups import Settings
from addon.studies.run import run
from addon.studies.truth import TruthTracer, compare
from addon.studies.truth.compare import COMPARED_PASSES
from benchmarks.models import available, load
from benchmarks.views import SIZE, View, lights, views

LEAST = 100_000
PAGE = Path(__file__).resolve().parents[1] / "docs" / "performance.md"
HEAD, END = "## Coarser casters\n", "## How\n"
STEP_RAD = np.radians(1.0)


@dataclass(frozen=True)
class Measured:
    """One way to cast in one view: milliseconds of the map pass, triangles sent, largest error in texels,
    misclassified %."""

    map_ms: float
    triangles: int
    error_texels: float
    wrong_pct: float


def settings(error: float | None) -> Settings:
    """Full casters, or coarse ones with an error of so many texels."""
    test = {"casters": "full"} if error is None else {"casters": "coarse", "caster_error": error}
    return Settings().replaced(test=test, shading={"samples": 1})


def map_pass_ms(drawer: Renderer, job: Job) -> float:
    """Processor milliseconds of the map pass, the GPU's work included."""
    spent, draw = [0.0], renderer.draw_shadow_maps

    def measured(context: moderngl.Context, *arguments: object) -> int:
        finish(context)
        begin = time.process_time()
        sent = draw(context, *arguments)
        finish(context)
        spent[0] += time.process_time() - begin
        return sent

    renderer.draw_shadow_maps = measured
    try:
        run(job, on=drawer)
    finally:
        renderer.draw_shadow_maps = draw
    return spent[0] * 1e3


def measure(name: str, view: View, errors: list[float | None], frames: int) -> dict[float | None, Measured]:
    """Every way in one view."""
    scene, light, drawer = load(name), lights(view.camera)["side"], Renderer()
    truth = TruthTracer(scene, "embree").trace(view.camera, light, SIZE)
    jobs = {error: Job(scene, view.camera, light, settings(error), SIZE, COMPARED_PASSES) for error in errors}
    frames_of = {error: run(job, on=drawer).frame for error, job in jobs.items()}
    wrong = {e: compare(f, truth, view.camera, light, jobs[e].settings.fit.size)[0]["misclassified_pct"] for e, f in frames_of.items()}
    middle, times = scene.bounds_ws().mean(axis=0), {error: [] for error in errors}
    for number in range(frames + 1):
        camera = view.camera.carried(middle, number * STEP_RAD)
        for error in errors:
            job = Job(scene, camera, light, settings(error), (1280, 720), ("combined",), measure=False)
            times[error].append(map_pass_ms(drawer, job))
    return {
        error: Measured(
            median(times[error][1:]),
            int(frames_of[error].geometry.get("caster_triangles", 0)),
            frames_of[error].geometry.get("caster_error_texels", 0.0),
            wrong[error],
        )
        for error in errors
    }


def table(names: list[str], errors: list[float | None], frames: int) -> Iterator[str]:
    """The rows, as they come."""
    yield "| model | view | error allowed, texels | map pass, ms | full / it | wrong % | against full |"
    yield "|---|---|---|---|---|---|---|"
    for name in names:
        gains: dict[float, list[float]] = {error: [] for error in errors if error is not None}
        for view in views(name, load(name)):
            rows = measure(name, view, errors, frames)
            full = rows[None]
            for error, row in rows.items():
                gain = full.map_ms / row.map_ms
                allowed = "full" if error is None else f"{error:g}"
                yield (
                    f"| {name} | {view.name} | {allowed} | {row.map_ms:.0f} | {gain:.2f} | {row.wrong_pct:.3f} | "
                    f"{row.wrong_pct - full.wrong_pct:+.3f} |"
                )
                if error is not None:
                    gains[error].append(gain)
        for error, values in gains.items():
            yield f"| **{name}** | mean | {error:g} |  | **{fmean(values):.2f}** |  |  |"


def main() -> None:
    """Measure and print, or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", nargs="+")
    parser.add_argument("--errors", nargs="+", type=float, default=[1.0])
    parser.add_argument("--frames", type=int, default=7)
    parser.add_argument("--write", action="store_true")
    choice = parser.parse_args()
    names = choice.models or [name for name in available() if name != "deck" and load(name).triangle_count > LEAST]
    lines = []
    for line in table(names, [None, *choice.errors], choice.frames):
        print(line, flush=True)
        lines.append(line)
    if choice.write:
        text = PAGE.read_text(encoding="utf-8")
        before, after = text.split(HEAD)[0] if HEAD in text else text.split(END)[0], text[text.index(END) :]
        words = fill(__doc__.split("\n\n")[2].replace("\n", " ").split(" `--write`")[0].replace("The dev", "the dev"), 140)
        PAGE.write_text(f"{before}{HEAD}`python -m benchmarks.casters`:\n{words}\n\n" + "\n".join(lines) + f"\n\n{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
