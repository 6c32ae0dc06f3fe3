"""docs/filters.md: what filters and camera samples do to the surfaces that are lit, and how near they come to many rays a pixel.

    python -m benchmarks.filters rims      dark rims, acne and leaks of every test with k taps and n depths (minutes)
    python -m benchmarks.filters samples   error against 64 rays a pixel with 1 … 16 camera samples, and of filters over a pixel
    python -m benchmarks.filters write     the page anew from what was measured

Needs bpy and embreex. Numbers go to benchmarks/results/filters-*.json; `--models` narrows (the others' numbers stay).
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from statistics import fmean

import numpy as np

from addon.maths.view import Camera, Light
from addon.pipeline.job import Job
from addon.pipeline.passes.samples import regular_grid
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from addon.studies.truth import TruthTracer
from addon.studies.truth.tracer import pixel_centres
from benchmarks import models, views
from benchmarks.measure import kept_by_model
from benchmarks.methods import settings
from benchmarks.quality import machine
from benchmarks.tables import table

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).resolve().parent / "results"
SIZE = (320, 180)
RAYS = 8  # a side of the pixel
DARKENED = 0.9
TESTS = {"depth": {"kind": "depth"}, "id-depth": {"kind": "id-depth"}, "exact": {"kind": "triangle"}}
FILTERS = {
    "one tap": {},
    **{f"k = {k}": {"pcf": k} for k in (4, 9, 16, 25)},
    "k = 16, 1 px": {"pcf": 16, "filter_unit": "pixel", "filter_width": 1.0},
    "k = 9, 3 px": {"pcf": 9, "filter_unit": "pixel", "filter_width": 3.0},
    **{f"n = {n}": {"depths": n} for n in (2, 3, 4, 8)},
    "k = 9, n = 3": {"pcf": 9, "depths": 3},
}
RIMS = {
    f"{test}, {name}": settings("lispsm-general", texels=2048**2, **TESTS[test], **chosen)
    for test in TESTS
    for name, chosen in FILTERS.items()
    if test != "exact" or "depths" not in chosen
}
SAMPLED = {
    **{f"{test}, {n} samples": (n, {}, kind) for test, kind in TESTS.items() if test != "id-depth" for n in (1, 4, 9, 16)},
    **{
        f"{test}, {name}": (1, chosen, TESTS[test])
        for test in ("depth", "exact")
        for name, chosen in FILTERS.items()
        if name.startswith("k = ") and "n" not in name
    },
}
INTRO = """# Filters and samples, measured

Made by `python -m benchmarks.filters` (see its help); do not edit. One view of each model, three suns, 320×180, one 2048² map, generalised
LiSPSM, `samples` fit.

A filter's taps lie on the receiver's plane, which at the foot of a wall, a step or a flush panel runs on inside a solid. A tap at a place
that the camera does not see, because something stands before it, counts as the receiver's own place does; likewise one that is hidden from
the eye by what shades it, such as a bar that passes between the centres of pixels. So do an n-SM's depths, as most of the others do. Limits
given by hand (`--bias`, `--epsilon`) are the texts' own, without this.
"""


def rotated_grid(samples: int) -> np.ndarray:
    """(samples, 2) offsets likewise, s × s cells with one each and no two in a row or a column: an upright edge meets s² levels, not s."""
    side = round(samples**0.5)
    a, b = np.divmod(np.arange(samples), side)
    return (np.stack([side * a + b, side * b + side - 1 - a], axis=-1) + 0.5) / samples - 0.5


def places(name: str) -> list[tuple[Scene, Camera, str, Light]]:
    """The first view of a model under three suns."""
    scene = models.load(name)
    camera = views.views(name, scene)[0].camera
    return [(scene, camera, light_name, light) for light_name, light in list(views.lights(camera).items())[::2]]


def spread_px(mask: np.ndarray, radius: int) -> np.ndarray:
    """`mask` grown by a square of `radius` pixels."""
    out = mask.copy()
    for axis in (0, 1):
        grown = out.copy()
        for step in range(1, radius + 1):
            for sign in (-step, step):
                moved = np.roll(out, sign, axis=axis)
                index = [slice(None), slice(None)]
                index[axis] = slice(0, sign) if sign > 0 else slice(sign, None)
                moved[tuple(index)] = False
                grown |= moved
        out = grown
    return out


def lit_and_dark(tracer: TruthTracer, camera: Camera, light: Light) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 16) of 4 × 4 rays a pixel: whether they meet a surface that faces the light and is lit, and one that is dark."""
    width, height = SIZE
    grid = (np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1).reshape(-1, 2) + 0.5) / 4 - 0.5
    found = tracer.sample(camera, light, SIZE, (pixel_centres(SIZE)[:, None] + grid).reshape(-1, 2)).reshaped((height, width, 16))
    return found.lit, found.lit_facing & ~found.lit


def rims(name: str) -> dict[str, list[float]]:
    """By method: [pixels, rims, acne, leaks] over the suns. A rim is darkened by more than a tenth though all its 16 rays are lit and no
    dark surface that faces the light lies within the reach of the filter; acne is a rim that is more dark than lit; a leak the reverse."""
    out = {method: [0.0, 0.0, 0.0, 0.0] for method in RIMS}
    tracer = None
    for scene, camera, _, light in places(name):
        tracer = tracer or TruthTracer(scene, "embree")
        lit, dark = lit_and_dark(tracer, camera, light)
        fully_lit, fully_dark, any_dark, any_lit = lit.all(axis=2), dark.all(axis=2), dark.any(axis=2), lit.any(axis=2)
        for method, chosen in RIMS.items():
            frame = run(Job(scene, camera, light, chosen, SIZE, ("shadow", "aliasing"))).frame
            shadow, reach = frame.passes["shadow"], reach_px(chosen, frame.passes["aliasing"][..., 0])
            away = np.zeros_like(fully_lit), np.zeros_like(fully_lit)
            for radius in np.unique(reach):
                for k, mask in enumerate((any_dark, any_lit)):
                    away[k][reach == radius] = ~spread_px(mask, int(radius))[reach == radius]
            clear, shaded = fully_lit & away[0], fully_dark & away[1]
            counts = clear.sum(), (clear & (shadow < DARKENED)).sum(), (clear & (shadow < 0.5)).sum(), (shaded & (shadow > 0.5)).sum()
            out[method] = [a + float(b) for a, b in zip(out[method], counts, strict=True)]
    return out


def reach_px(chosen: Settings, m: np.ndarray) -> np.ndarray:
    """(h, w) whole pixels that a filter reaches, at most 12: its width in texels of √m pixels, or in pixels; two more at least."""
    side = chosen.test.pcf**0.5
    if chosen.test.filter_unit == "pixel":
        return np.full(m.shape, 2 + int(np.ceil(chosen.test.filter_width)))
    texels = side + 2.0 * (chosen.test.depths > 1)
    return np.minimum(2.0 + np.ceil(texels * np.sqrt(np.clip(np.nan_to_num(m), 0.0, 1e4))), 12.0).astype(int)


def samples(name: str) -> dict[str, list[float]]:
    """By method: [pixels, sum of |light − that of 64 rays|] over the suns; also of as many rays, well placed."""
    out: dict[str, list[float]] = {}
    tracer, (width, height) = None, SIZE
    for scene, camera, _, light in places(name):
        tracer = tracer or TruthTracer(scene, "embree")
        grid = (np.stack(np.meshgrid(np.arange(RAYS), np.arange(RAYS)), axis=-1).reshape(-1, 2) + 0.5) / RAYS - 0.5
        many = tracer.sample(camera, light, SIZE, (pixel_centres(SIZE)[:, None] + grid).reshape(-1, 2)).reshaped((height, width, -1))
        truth, counted = many.lit.mean(axis=2), (many.object >= 0).all(axis=2)

        def add(method: str, image: np.ndarray, truth: np.ndarray = truth, counted: np.ndarray = counted) -> None:
            pixels, error = out.get(method, [0.0, 0.0])
            out[method] = [pixels + float(counted.sum()), error + float(np.abs(image - truth)[counted].sum())]

        for n, pattern in (
            (n, pattern) for n in (1, 4, 9, 16) for pattern in (regular_grid, rotated_grid) if n > 1 or pattern is regular_grid
        ):
            few = tracer.sample(camera, light, SIZE, (pixel_centres(SIZE)[:, None] + pattern(n)).reshape(-1, 2))
            add(f"rays, {n}, {pattern.__name__.replace('_', ' ')}", few.lit.reshape(height, width, n).mean(axis=2))
        for method, (n, chosen, kind) in SAMPLED.items():
            wanted = settings("lispsm-general", texels=2048**2, **kind, **chosen).replaced(shading={"display": "shadow", "samples": n})
            add(method, run(Job(scene, camera, light, wanted, SIZE, ("combined",))).frame.passes["combined"][..., 0])
    return out


def rims_page(by_model: dict[str, dict[str, list[float]]]) -> str:
    """The table of rims."""
    lines = []
    for method in RIMS:
        rows = [numbers[method] for numbers in by_model.values()]
        pixels = max(sum(row[0] for row in rows), 1.0)
        worst = max(100.0 * row[1] / max(row[0], 1.0) for row in rows)
        lines.append((method, *(f"{100.0 * sum(row[i] for row in rows) / pixels:.4f}" for i in (1, 2, 3)), f"{worst:.4f}"))
    return (
        f"## Rims\n\n{len(by_model)} models. *Rim*: pixels darkened by more than 0.1, in % of those whose 16 rays are all lit, farther "
        "from any shadow than the filter reaches (wanted ≤ 0.01). *Acne*: those of them more dark than lit. *Leak*: lit though all is dark "
        "as far.\n\n" + table(("test", "rim %", "acne %", "leak %", "rim %, worst model"), lines)
    )


def samples_page(by_model: dict[str, dict[str, list[float]]]) -> str:
    """The table of samples."""
    methods = list(next(iter(by_model.values())))
    mean = {m: fmean(100.0 * numbers[m][1] / numbers[m][0] for numbers in by_model.values()) for m in methods}
    return (
        f"## Against 64 rays a pixel\n\n{len(by_model)} models; mean |light − light of 64 rays|, %. *Rays*: as many at these places.\n\n"
        + table(("method", "error %"), [(m, f"{mean[m]:.3f}") for m in methods])
    )


RUNS = {"rims": (rims, rims_page), "samples": (samples, samples_page)}


def main() -> None:
    """Measure one table and write the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.filters", description=__doc__.split("\n")[0])
    parser.add_argument("table", choices=(*RUNS, "write"))
    parser.add_argument("--models", nargs="+", metavar="NAME", help="only these (deck, or file names of ../shared/cad/dev)")
    args = parser.parse_args()
    if args.table in RUNS:
        kept_by_model(RESULTS / f"filters-{args.table}.json", args.models or models.available(), RUNS[args.table][0])
    pages = [INTRO]
    for name, (_, page) in RUNS.items():
        path = RESULTS / f"filters-{name}.json"
        if path.is_file():
            pages.append(page(json.loads(path.read_text(encoding="utf-8"))))
    pages.append(f"---\nMeasured with {machine()}; OpenGL on the CPU (Mesa llvmpipe).\n")
    (ROOT / "docs" / "filters.md").write_text("\n\n".join(pages), encoding="utf-8")


if __name__ == "__main__":
    main()
