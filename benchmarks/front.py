"""docs/front.md: error against time, of the presets beside every test, number of samples and plain uniform maps.

    python -m benchmarks.front measure [--models NAME …]   minutes a model; the others' numbers stay
    python -m benchmarks.front write                       the page and the plot anew from what was measured

Needs bpy, embreex and matplotlib. Numbers go to benchmarks/results/front.json. Time is processor time of a whole picture whose view has
moved: fit, maps, surfaces, shading, reading back; the least of a few, since other programs only ever add to it.
"""

from __future__ import annotations

import argparse
import ast
import time
from pathlib import Path
from statistics import fmean, geometric_mean

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from addon.maths.view import Camera, Light
from addon.pipeline.job import Job
from addon.pipeline.passes.samples import moved, regular_grid
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.settings.options import with_options
from addon.studies.run import run
from addon.studies.truth import TruthTracer
from addon.studies.truth.tracer import pixel_centres
from benchmarks import models, views
from benchmarks.measure import kept_by_model
from benchmarks.quality import machine
from benchmarks.tables import table

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).resolve().parent / "results" / "front.json"
PLOT = ROOT / "docs" / "img" / "front.png"
PRESETS = ROOT / "addon" / "blender" / "presets" / "cad_shadow_preview"
SIZE, RAYS, TIMED = (320, 180), 8, 2
MODELS = ("deck", "duplex_house.obj", "hand_wheel_valve.ply", "industrial_ladder.obj")
TESTS = {
    "depth": {"kind": "depth"},
    "id-depth": {"kind": "id-depth"},
    "exact": {"kind": "triangle"},
    "outlines": {"kind": "triangle", "outlines": True},
}
SAMPLES = {
    "one map": {"depth": (1, 4, 9), "id-depth": (4,), "exact": (4, 9, 16), "outlines": (4,)},
    "four maps": {"exact": (9,), "outlines": (4,)},
}
INTRO = """# Error against time

Made by `python -m benchmarks.front` (see its help); do not edit. *Error*: mean |light − light of 64 rays a pixel| over the pixels that show
a surface, %. *Wrong*: pixels at whose centre light and truth differ by more than half. *Time*: processor milliseconds of a whole picture of
a view that has moved, 320×180, over that of *Balanced* on the same model. The first view of each model, the sun from the side. *On the
front*: nothing measured is quicker by more than 2 % and as exact by both measures.

Models are seen from outside, where one map with the exact test does: there samples are what makes a picture more exact. Four maps and more
are for views along a scene ([Quality](quality.md)).

![Error against time](img/front.png)
"""


def preset(path: Path) -> Settings:
    """A shipped preset as settings."""
    found = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
            value = ast.literal_eval(node.value)
            found[node.targets[0].attr] = int(value) if isinstance(value, str) and value.isdigit() else value
    return with_options(Settings(), found)


def contenders() -> dict[str, Settings]:
    """Presets; one warped map with every test and number of samples; plain uniform maps of growing size."""
    out = {path.stem.replace("_", " "): preset(path) for path in sorted(PRESETS.glob("*.py"))}
    one_map = Settings().replaced(partition={"kind": "none"}, fit={"size": 1024})
    for name, test in TESTS.items():
        for maps, chosen in (("one map", one_map), ("four maps", Settings())):
            out |= {f"{maps}, {name}, {n}": chosen.replaced(test=test, shading={"samples": n}) for n in SAMPLES[maps].get(name, ())}
    plain = one_map.replaced(warp={"kind": "uniform"}, test={"kind": "depth"})
    for size in (1024, 2048, 4096):
        for n in (1, 4):
            out[f"uniform {size}², depth, {n}"] = plain.replaced(fit={"size": size, "kind": "scene"}, shading={"samples": n})
    return out


def measured(name: str) -> dict[str, list[float]]:
    """By contender: [error %, wrong %, milliseconds]."""
    scene = models.load(name)
    tracer, camera = TruthTracer(scene, "embree"), views.views(name, scene)[0].camera
    rows: dict[str, list[tuple[float, float, float]]] = {}
    for light in list(views.lights(camera).values())[1:2]:
        truth, centre, counted = traced(tracer, camera, light)
        centres: dict[Settings, np.ndarray] = {}
        for method, settings in contenders().items():
            chosen = settings.replaced(shading={"display": "shadow"})
            image = picture(scene, camera, light, chosen, ("combined",))[..., 0]
            single = chosen.replaced(shading={"samples": 1})
            if single not in centres:
                centres[single] = picture(scene, camera, light, single, ("shadow",))
            error = 100.0 * float(np.abs(image - truth)[counted].mean())
            wrong = 100.0 * float((np.abs(centres[single] - centre) > 0.5)[counted].mean())
            rows.setdefault(method, []).append((error, wrong, milliseconds(scene, camera, light, settings)))
    return {method: [fmean(column) for column in zip(*found, strict=True)] for method, found in rows.items()}


def picture(scene: Scene, camera: Camera, light: Light, settings: Settings, passes: tuple[str, ...]) -> np.ndarray:
    """One pass of one picture."""
    return run(Job(scene, camera, light, settings, SIZE, passes, measure=False)).frame.passes[passes[0]]


def traced(tracer: TruthTracer, camera: Camera, light: Light) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(h, w) light of 64 rays a pixel, light at its centre, and whether all of them meet a surface."""
    width, height = SIZE
    total, counted = np.zeros((height, width)), np.ones((height, width), bool)
    for offset in regular_grid(RAYS**2):
        found = tracer.sample(camera, light, SIZE, pixel_centres(SIZE) + offset)
        total += found.lit.reshape(height, width)
        counted &= found.object.reshape(height, width) >= 0
    return total / RAYS**2, tracer.trace(camera, light, SIZE).lit.astype(float), counted


def milliseconds(scene: Scene, camera: Camera, light: Light, settings: Settings) -> float:
    """Processor time of a picture; the view has moved by a thousandth of a pixel, so that nothing of the last one is kept."""
    times = []
    for k in range(TIMED):
        job = Job(scene, moved(camera, SIZE, np.array([1e-3 * (k + 1), 0.0])), light, settings, SIZE, ("combined",), measure=False)
        begin = time.process_time()
        run(job)
        times.append(1e3 * (time.process_time() - begin))
    return min(times)


def pooled(by_model: dict[str, dict[str, list[float]]]) -> dict[str, tuple[float, float, float]]:
    """By contender: error %, wrong % (means over the models), and time over that of Balanced (geometric mean)."""
    methods = [m for m in contenders() if all(m in rows for rows in by_model.values())]
    out = {}
    for m in methods:
        ratio = geometric_mean([rows[m][2] / rows["Balanced"][2] for rows in by_model.values()])
        out[m] = (fmean(rows[m][0] for rows in by_model.values()), fmean(rows[m][1] for rows in by_model.values()), ratio)
    return out


def is_on_front(points: dict[str, tuple[float, float, float]], name: str) -> bool:
    """Whether nothing is quicker, by more than 2 %, and as exact by both measures."""
    error, wrong, ms = points[name]
    return not any(e <= error and w <= wrong and t < ms / 1.02 for e, w, t in points.values())


def group_of(method: str) -> str:
    """What a contender is drawn as."""
    return "presets" if "," not in method else "uniform" if method.startswith("uniform") else method.rsplit(", ", 1)[0]


def draw(points: dict[str, tuple[float, float, float]]) -> None:
    """The plot: error, and wrong pixels of one sample, over time; both logarithmic."""
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.6))
    colors = dict(zip(TESTS, ("tab:blue", "tab:cyan", "tab:green", "tab:olive"), strict=True))
    groups = {"presets": ("*", 130, "black")}
    groups |= {
        f"{maps}, {test}": ("o" if maps == "one map" else "s", 28, colors[test]) for maps, tests in SAMPLES.items() for test in tests
    }
    groups["uniform"] = ("x", 34, "tab:red")
    for axis, column, title in zip(axes, (0, 1), ("Mean error against 64 rays a pixel, %", "Wrong at the pixel's centre, %"), strict=True):
        for group, (marker, area, color) in groups.items():
            mine = {m: p for m, p in points.items() if group_of(m) == group}
            axis.scatter([p[2] for p in mine.values()], [max(p[column], 1e-4) for p in mine.values()], area, color, marker, label=group)
            for m, p in mine.items():
                label = m if group == "presets" else m.rsplit(", ", 1)[1] if column == 0 else ""
                axis.annotate(
                    label, (p[2], max(p[column], 1e-4)), (4, 4), textcoords="offset points", fontsize=8 if group == "presets" else 6
                )
        axis.set(xscale="log", yscale="log", xlabel="processor time of a picture, over Balanced's", title=title)
        axis.grid(alpha=0.25, which="both")
    axes[0].legend(fontsize=8)
    PLOT.parent.mkdir(parents=True, exist_ok=True)
    figure.tight_layout()
    figure.savefig(PLOT, dpi=110, metadata={"Software": None})
    plt.close(figure)


def page(by_model: dict[str, dict[str, list[float]]]) -> str:
    """The page's text."""
    points = pooled(by_model)
    lines = [(m, *p, "yes" if is_on_front(points, m) else "") for m, p in sorted(points.items(), key=lambda item: item[1][2])]
    formatted = [(m, f"{e:.3f}", f"{w:.4f}", f"{t:.2f}", front) for m, e, w, t, front in lines]
    names = ", ".join(Path(name).stem for name in by_model)
    head = ("settings, samples a pixel", "error %", "wrong %", "time", "on the front")
    return f"{INTRO}\nModels: {names}.\n\n{table(head, formatted)}\n\n---\nMeasured with {machine()}; OpenGL on the CPU (Mesa llvmpipe).\n"


def main() -> None:
    """Measure models, or write the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.front", description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("measure", "write"))
    parser.add_argument("--models", nargs="+", metavar="NAME", help="only these (deck, or file names of ../shared/cad/dev)")
    args = parser.parse_args()
    names = args.models or [m for m in MODELS if m in models.available()]
    kept = kept_by_model(RESULTS, names if args.what == "measure" else (), measured)
    draw(pooled(kept))
    (ROOT / "docs" / "front.md").write_text(page(kept), encoding="utf-8")


if __name__ == "__main__":
    main()
