"""docs/flicker.md: how much shadows flicker while the sun or the camera moves slowly; `python -m benchmarks.steadiness flicker`.

What moves one way crosses a pixel once. A pixel that grows darker and lighter again, or the reverse, by more than a fifth each way in three
pictures running flickers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import radians
from pathlib import Path
from statistics import fmean

import numpy as np

from addon.maths.spaces import translation
from addon.maths.view import Camera, Light
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.run import run
from benchmarks import models, views
from benchmarks.quality import machine
from benchmarks.tables import table

RESULTS = Path(__file__).resolve().parent / "results" / "flicker.json"
PAGE = Path(__file__).resolve().parents[1] / "docs" / "flicker.md"
MODELS = ("deck", "huldra_utilities.glb", "duplex_house.obj", "amazing_hand.glb")
SIZE, FRAMES, LEAST = (320, 180), 9, 0.2
SUN_STEP_DEG, CAMERA_STEP_PX = 0.05, 0.11
TESTS = {"depth": {"kind": "depth"}, "exact": {"smoothing": 1}, "exact, smooth edges": {}}
FITS = ("scene", "samples")
METHODS = {f"{name}, {fit}": {"test": test, "fit": {"kind": fit}} for name, test in TESTS.items() for fit in FITS}
METHODS |= {
    f"uniform, {name}, scene": {"warp": {"kind": "uniform"}, "test": test, "fit": {"kind": "scene"}} for name, test in TESTS.items()
}
INTRO = f"""# Flicker, measured

Made by `python -m benchmarks.steadiness flicker`; do not edit. {FRAMES} pictures of {SIZE[0]}×{SIZE[1]}, one view of each model: the sun
moves by {SUN_STEP_DEG}° from one to the next, or the camera aside by {CAMERA_STEP_PX} pixels of what it looks at. What moves one way
crosses a pixel once: a pixel flickers that grows darker and lighter again, or the reverse, by more than {LEAST:g} each way. Per cent of the
pixels, in three pictures running. *Scene* and *samples* are the fits; the default is the exact test with smooth edges, samples. Wanted: 0.
"""


def moving_sun(camera: Camera, light: Light) -> Iterator[tuple[Camera, Light]]:
    """The sun goes round the vertical."""
    for i in range(FRAMES):
        c, s = np.cos(radians(i * SUN_STEP_DEG)), np.sin(radians(i * SUN_STEP_DEG))
        yield camera, replace(light, direction_ws=np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ light.direction_ws)


def moving_camera(camera: Camera, light: Light) -> Iterator[tuple[Camera, Light]]:
    """The camera goes aside by parts of a pixel at the middle of its depths."""
    depth = (camera.near * camera.far) ** 0.5
    step = CAMERA_STEP_PX * 2.0 * depth / float(camera.clip_from_view[0, 0]) / SIZE[0]
    for i in range(FRAMES):
        yield replace(camera, view_from_world=translation([i * step, 0.0, 0.0]) @ camera.view_from_world), light


MOTIONS = {"sun": moving_sun, "camera": moving_camera}


def flicker(pictures: Sequence[np.ndarray]) -> float:
    """The share of pixels that go forth and back, of (h, w) pictures one after the other."""
    steps = np.diff(np.stack(pictures), axis=0)
    back = (np.abs(steps) > LEAST)[:-1] & (np.abs(steps) > LEAST)[1:] & (steps[:-1] * steps[1:] < 0.0)
    return float(back.mean())


def measure(name: str) -> dict[str, float]:
    """By motion and method, per cent."""
    scene, out = models.load(name), {}
    camera = views.views(name, scene)[0].camera
    light = views.lights(camera)["side"]
    for motion, moves in MOTIONS.items():
        for method, chosen in METHODS.items():
            wanted = Settings().replaced(**chosen, shading={"display": "shadow"})
            jobs = (Job(scene, c, lit, wanted, SIZE, ("combined",), measure=False) for c, lit in moves(camera, light))
            out[f"{motion}: {method}"] = 100.0 * flicker([run(job).frame.passes["combined"][..., 0] for job in jobs])
            print(name, motion, method, f"{out[f'{motion}: {method}']:.4f}", flush=True)
    return out


def main(names: Sequence[str] | None = None) -> None:
    """Measure the models, those of `names` only where given, and write the page; with the one name 'write' only the page."""
    kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.is_file() else {}
    for name in [] if names == ["write"] else names or [name for name in MODELS if name in models.available()]:
        kept[name] = measure(name)
        RESULTS.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    parts = [INTRO]
    for motion in MOTIONS:
        lines = [
            (
                method,
                *(f"{by[f'{motion}: {method}']:.3f}" for by in kept.values()),
                f"{fmean(by[f'{motion}: {method}'] for by in kept.values()):.3f}",
            )
            for method in METHODS
        ]
        parts.append(f"## A moving {motion}\n\n" + table(("method", *(Path(n).stem.replace("_", " ") for n in kept), "mean"), lines))
    parts.append(f"---\nMeasured with {machine()}; OpenGL on the CPU (Mesa llvmpipe).\n")
    PAGE.write_text("\n\n".join(parts), encoding="utf-8")
