"""Hours of direct sun against rays: 2,000 random places on the surfaces of each model, every sun of a day. `docs/sky.md` has the table.

A place counts as right where both differ by no more than one step of the day.
"""

from __future__ import annotations

import argparse
from datetime import date
from math import radians
from time import perf_counter

import numpy as np

from addon.maths.light_set import LightSet
from addon.maths.sun import Clock, Place
from addon.pipeline.job import Job
from addon.pipeline.reach_choice import ReachChoice
from addon.pipeline.reach_tasks import sums_at_places
from addon.pipeline.renderer import shared_renderer
from addon.scene.default_view import camera_for_view
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.sun.days import SunSpan, suns
from addon.studies.truth import TruthTracer
from addon.studies.truth.triangles import world_triangles
from benchmarks import models

PLACE, DAY = Place(radians(48.0), radians(11.0)), date(2026, 3, 21)
POINTS, SIZES = 2000, (512, 1024, 2048)


def random_places(scene: Scene, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(count, 3) places and normals, by area, from a fixed seed."""
    rng, triangles = np.random.default_rng(19), world_triangles(scene)
    a, b, c = (triangles.corners[:, i] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = rng.choice(len(area), count, p=area / area.sum())
    weights = rng.random((count, 2))
    weights = np.where(weights.sum(axis=1, keepdims=True) > 1.0, 1.0 - weights, weights)
    points = a[chosen] + weights[:, :1] * (b - a)[chosen] + weights[:, 1:] * (c - a)[chosen]
    return points, triangles.normal[chosen]


def traced_hours(scene: Scene, points: np.ndarray, normals: np.ndarray, lights: LightSet) -> np.ndarray:
    """(P,) hours by rays."""
    tracer, hours = TruthTracer(scene, "embree"), np.zeros(len(points))
    noise = 1e-6 * float(np.linalg.norm(np.ptp(scene.bounds_ws(), axis=0)))
    for direction, weight in zip(lights.directions_ws, lights.weights, strict=True):
        hours += weight * tracer.reached(points, normals, direction, noise)
    return hours


def rows_of(name: str, lights: LightSet, sizes: tuple[int, ...]) -> list[str]:
    """The model's rows of the table."""
    scene = models.load(name)
    points, normals = random_places(scene, POINTS)
    expected, rows = traced_hours(scene, points, normals, lights), []
    job, step = Job(scene, camera_for_view(scene, (64, 64)), None, Settings(), (64, 64)), float(lights.weights.max())
    for size in sizes:
        begin = perf_counter()
        found = shared_renderer().submit(job, sums_at_places, points, normals, lights, ReachChoice(size))[0].result()[:, 0]
        seconds, off = perf_counter() - begin, np.abs(found - expected)
        right = 100.0 * (off <= step * 1.001).mean()
        rows.append(
            f"| `{name}` | {scene.triangle_count:,} | {size} | {right:.2f} | {60 * off.mean():.2f} | {60 * off.max():.0f} | {seconds:.1f} |"
        )
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", default=models.available())
    parser.add_argument("--step", type=float, default=5.0, help="minutes")
    parser.add_argument("--sizes", type=lambda text: tuple(map(int, text.split(","))), default=SIZES)
    args = parser.parse_args()
    lights = suns(SunSpan(Clock(DAY, 1.0), DAY, args.step), PLACE)
    print(f"{len(lights)} suns, {POINTS} places a model\n")
    print(
        "| Model | Triangles | Map | Within a step, % | Mean off, min | Most, min | Seconds |\n| --- | --- | --- | --- | --- | --- | --- |"
    )
    for name in args.models:
        print(*rows_of(name, lights, args.sizes), sep="\n", flush=True)


if __name__ == "__main__":
    main()
