"""docs/stairs.md: how far the edges of shadows are from smooth ones, against time.

    python -m benchmarks.stairs measure   root mean square error of the shadow against 256 rays a pixel, and processor time (minutes)
    python -m benchmarks.stairs write     the page anew from what was measured

Needs bpy and embreex. Numbers go to benchmarks/results/stairs.json; `--models` narrows (the others' numbers stay).
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from statistics import fmean

import numpy as np

from addon.maths.spaces import translation
from addon.maths.view import Camera, Light
from addon.pipeline.job import Job
from addon.scene.records import Scene
from addon.settings.groups import SAMPLE_COUNTS, SMOOTHINGS, Settings
from addon.studies.run import run
from addon.studies.truth import TruthTracer
from addon.studies.truth.tracer import pixel_centres
from benchmarks import models, views
from benchmarks.measure import kept_by_model
from benchmarks.quality import machine
from benchmarks.tables import table

RESULTS = Path(__file__).resolve().parent / "results" / "stairs.json"
PAGE = Path(__file__).resolve().parents[1] / "docs" / "stairs.md"
MODELS = ("deck", "huldra_utilities.glb", "duplex_house.obj", "amazing_hand.glb")
SIZE = (320, 180)
RAYS = 16  # a side of the pixel
RUNS = 4
STEP_M = 1e-5  # by which the eye moves between two runs that are timed: nothing is kept
METHODS = {f"{n} × {k}": {"shading": {"samples": n}, "test": {"smoothing": k}} for n in SAMPLE_COUNTS[:3] for k in SMOOTHINGS[:3]}
DEFAULT, BEFORE = "4 × 5", "4 × 1"
INTRO = f"""# Stairs of shadow edges, measured

Made by `python -m benchmarks.stairs` (see its help); do not edit. The light shown against that of {RAYS * RAYS} rays a pixel, root mean
square over the pixels that the edge of a shadow crosses and no edge of a surface (its rays meet one plane, facing the light), at
{SIZE[0]}×{SIZE[1]} and the default settings, one view of each model, two suns. *n × k*: n camera samples (`--samples`), k tests where an
edge passes (`--smoothing`). Times are processor time of a whole picture. The default is {DEFAULT}; without smoothing it is {BEFORE}.
"""


def truth_of(tracer: TruthTracer, camera: Camera, light: Light) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) light of many rays a pixel, and the pixels of one plane, facing the light, that an edge of a shadow crosses."""
    (width, height), rows = SIZE, []
    grid = (np.stack(np.meshgrid(np.arange(RAYS), np.arange(RAYS)), axis=-1).reshape(-1, 2) + 0.5) / RAYS - 0.5
    places = (pixel_centres(SIZE)[:, None] + grid).reshape(height, -1, 2)
    for band in np.array_split(np.arange(height), 18):
        found = tracer.sample(camera, light, SIZE, places[band].reshape(-1, 2)).reshaped((len(band), width, -1))
        normal, point = found.normal_ws[..., :1, :], found.point_ws[..., :1, :]
        off = np.abs(((found.point_ws - point) * normal).sum(axis=-1)).max(axis=2)
        turned = 1.0 - (found.normal_ws * normal).sum(axis=-1).min(axis=2)
        one = (found.object >= 0).all(axis=2) & (turned < 1e-4) & (off < 1e-5 * found.depth[..., 0])
        rows.append((found.lit.mean(axis=2), one & found.lit_facing.all(axis=2)))
    lit, seen = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    return lit, seen & (lit > 0.0) & (lit < 1.0)


def moved(camera: Camera, step: int) -> Camera:
    """The camera a little aside."""
    return replace(camera, view_from_world=translation([step * STEP_M, 0.0, 0.0]) @ camera.view_from_world)


def timed(scene: Scene, camera: Camera, light: Light, chosen: Settings) -> float:
    """Milliseconds of processor time of one picture: the least of some."""
    least = np.inf
    for step in range(RUNS):
        begin = time.process_time()
        run(Job(scene, moved(camera, step), light, chosen, SIZE, ("combined",), measure=False))
        least = min(least, 1e3 * (time.process_time() - begin))
    return least


def measure(name: str) -> dict[str, list[float]]:
    """By method: [pixels, sum of squared errors, milliseconds, pictures] over the suns."""
    scene, out = models.load(name), {}
    camera = views.views(name, scene)[0].camera
    tracer = TruthTracer(scene, "embree")
    for light in list(views.lights(camera).values())[1:3]:
        truth, edge = truth_of(tracer, camera, light)
        for method, chosen in METHODS.items():
            wanted = Settings().replaced(**{**chosen, "shading": chosen["shading"] | {"display": "shadow"}})
            image = run(Job(scene, camera, light, wanted, SIZE, ("combined",), measure=False)).frame.passes["combined"][..., 0]
            error = float(((image - truth)[edge] ** 2).sum())
            numbers = float(edge.sum()), error, timed(scene, camera, light, Settings().replaced(**chosen)), 1.0
            out[method] = [a + b for a, b in zip(out.get(method, [0.0] * 4), numbers, strict=True)]
            print(name, light.name, method, f"{(error / edge.sum()) ** 0.5:.4f} {numbers[2]:.0f} ms", flush=True)
    return out


def page(by_model: dict[str, dict[str, list[float]]]) -> str:
    """The table: every method, the error of each model, and the mean time."""
    lines = []
    for method in METHODS:
        rows = [numbers[method] for numbers in by_model.values()]
        errors = [(row[1] / row[0]) ** 0.5 for row in rows]
        lines.append((method, *(f"{e:.4f}" for e in errors), f"{fmean(errors):.4f}", f"{fmean(row[2] / row[3] for row in rows):.0f}"))
    names = [Path(name).stem.replace("_", " ") for name in by_model]
    return table(("samples × smoothing", *names, "mean", "ms"), lines)


def main() -> None:
    """Measure, write the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stairs", description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("measure", "write"))
    parser.add_argument("--models", nargs="+", metavar="NAME", help="only these (deck, or file names of ../shared/cad/dev)")
    args = parser.parse_args()
    names = args.models or [name for name in MODELS if name in models.available()]
    kept = kept_by_model(RESULTS, names if args.what == "measure" else (), measure)
    ending = f"---\nMeasured with {machine()}; OpenGL on the CPU (Mesa llvmpipe).\n"
    PAGE.write_text(f"{INTRO}\n{page(kept)}\n\n{ending}", encoding="utf-8")


if __name__ == "__main__":
    main()
