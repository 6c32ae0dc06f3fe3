"""Relief impostors, measured: `python -m benchmarks.impostors TABLE… [--models NAME…]` → docs/impostors.md; `all` makes it wholly.

    predictors   every predictor against the pixels that a capture has really never seen
    rest         the capture's own eye, with shadows, by every test
    pictures     sprite, forward warp, one layer, two layers, two captures against the geometry, 0…60°, 3…16 radii
    orbit        360° at 1° steps round each model, automatic, as the program does it by default: worst frame, jumps at renewals
    elsewhere    a quarter of an orbit that the error's weights were not fitted on: 5 radii, 50° above
    life         the first third of it with sprites alone, without captures ahead, with other predictors, for the models drawn as impostors
    shadows      shadows on a floor cast by impostors against those of the triangles
    limits       an orbit, an approach, a retreat and a spiral, 16 frames each: whether the limit of the predicted error holds
    approach     three of the models approached from 16 to 3 radii: renewals that carry the predictors' edges over, against all anew
    pay          whole pictures with the break-even against the geometry's: a moving view, final renders
    speed        an impostor against its geometry, drawn in turn, and 200 predictions

Results go to benchmarks/results/impostors-*.json model by model; `--resume` leaves out those already there. `write` (done at the end of
each) makes docs/impostors.md from what is there.
Needs the dev models beside the checkout; no bpy.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import asdict

import numpy as np

from addon.maths.relief.error import predict, predict_one, relief_set
from addon.maths.relief.picture import picture_errors
from addon.pipeline.device import device_of
from addon.pipeline.gl.context import GpuWorker
from addon.pipeline.renderer import Renderer
from benchmarks import impostor_approach, impostor_films, impostor_limits, impostor_pay, impostor_tables
from benchmarks.impostor_stage import MODELS, Stage, ball_scene, load

SIZE = 240
ANGLES, RADII = (0, 5, 10, 20, 30, 45, 60), (3.0, 8.0, 16.0)
APPROACHED = ("featuretype.step", "hand_wheel_valve.ply", "cycloidal_drive_mm.glb")
ONLY = {"life": (*APPROACHED, "robile_housing.obj", "amazing_hand.glb", "duplex_house.obj", "tray_bottom_mm.stl"), "approach": APPROACHED}
"""The models of tables that are not made of all: the four others are drawn as geometry at the films' size, finer than their texels."""
ORBITS = {"orbit": impostor_films.orbit, "elsewhere": impostor_films.elsewhere, "life": impostor_films.life}
FILMS = {
    "rest": impostor_films.rest,
    "shadows": impostor_films.shadows,
    "limits": impostor_limits.limits,
    "approach": impostor_approach.approach,
}
TABLES = ("predictors", "rest", "pictures", "orbit", "elsewhere", "life", "shadows", "limits", "approach", "pay", "speed")
OF_BALLS = "pay", "speed"


def predictors(stage: Stage, name: str) -> list[dict]:
    """60 cameras, 0…35° and 3…14 radii from captures at 8: predictions and truth (pixels never seen, fixed focal length)."""
    rng = np.random.default_rng(sum(name.encode()))
    rows, size = [], (640, 640)
    for _ in range(3):
        base = rng.uniform(-180, 180), rng.uniform(0, 50)
        impostor = stage.capture(stage.camera(*base, 8.0, half_fov_deg=20.0), size, texels=1.0)
        for _ in range(20):
            tilt, turn = rng.uniform(0, 35), rng.uniform(0, 2 * np.pi)
            camera = stage.camera(base[0] + tilt * np.cos(turn), base[1] + tilt * np.sin(turn), rng.uniform(3, 14), half_fov_deg=20.0)
            rows.append({"model": name, "truth": stage.unseen(impostor, camera, size), **predict_one(impostor.edges, camera, size)})
        impostor.release()
    return rows


def pictures(stage: Stage, name: str, distances: list[float]) -> list[dict]:
    """Every way of drawing, at every angle and distance, with shadows, 4 × 4 supersampled, two texels a pixel."""
    rows = []
    for radii in distances:
        first = stage.camera(30, 20, radii)
        both, front = stage.capture(first, (SIZE, SIZE)), stage.capture(first, (SIZE, SIZE), with_back=False)
        flat = stage.capture(first, (SIZE, SIZE), perspective=False)
        for angle in ANGLES:
            camera = stage.camera(30 + angle, 20, radii)
            second = stage.capture(stage.camera(30 + 2 * angle, 20, radii), (SIZE, SIZE))
            truth = stage.picture(camera, SIZE)
            for way, textures, method in (
                ("sprite", [both], "sprite"),
                ("forward", [front], "forward"),
                ("one layer", [front], "inverse"),
                ("two layers", [both], "inverse"),
                ("two layers, orthographic", [flat], "inverse"),
                ("two captures", [both, second], "inverse"),
                ("two captures, dithered", [both, second], "dithered"),
            ):
                errors = picture_errors(*_pair(stage.picture(camera, SIZE, textures, method), truth))
                rows.append({"model": name, "way": way, "angle": angle, "radii": radii, **asdict(errors)})
            second.release()
        for impostor in (both, front, flat):
            impostor.release()
    return rows


def _pair(picture: tuple[np.ndarray, np.ndarray], truth: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, ...]:
    return picture[0], truth[0], picture[1], truth[1]


def speed(worker: GpuWorker) -> list[dict]:
    """A ball of 10 thousand to a million triangles as geometry and as an impostor of at most 512², and 200 predictions at once."""
    rows = []
    for rings in (50, 250, 500, 710):
        scene = ball_scene(rings)

        def job(context: object, scene: object = scene) -> dict:
            stage = Stage(device_of(context, worker), scene)
            camera = stage.camera(40, 20, 8.0)
            impostor = stage.capture(stage.camera(30, 20, 8.0), (512, 512), texels=1.0)
            size = f"{impostor.frame.width}×{impostor.frame.height}"
            textures = relief_set([impostor.edges] * 200)
            wall, cpu = _milliseconds(
                lambda: stage.direct(camera, (512, 512)),
                lambda: stage.drawn(camera, (512, 512), [impostor]),
                lambda: predict(textures, camera, (512, 512), exact=False),
            )
            (made,), _ = _milliseconds(lambda: stage.capture(camera, (512, 512), texels=1.0).release(), repeats=3)
            impostor.release()
            return {
                "triangles": scene.triangle_count,
                "texture": size,
                **dict(zip(("geometry_ms", "impostor_ms", "predict_200_ms"), wall, strict=True)),
                **dict(zip(("geometry_cpu_ms", "impostor_cpu_ms", "predict_200_cpu_ms"), cpu, strict=True)),
                "capture_ms": made,
            }

        rows.append(worker.call(job))
    return rows


def _milliseconds(*jobs: Callable[[], object], repeats: int = 11) -> tuple[list[float], list[float]]:
    """Median wall and processor times (all threads) of jobs that wait for the GPU themselves, done in turn."""
    times = np.zeros((repeats + 1, 2, len(jobs)))
    for round_of in times:
        for i, job in enumerate(jobs):
            begin = time.perf_counter(), time.process_time()
            job()
            round_of[:, i] = time.perf_counter() - begin[0], time.process_time() - begin[1]
    wall, cpu = 1e3 * np.median(times[1:], axis=0)
    return wall.tolist(), cpu.tolist()


def main() -> None:
    """Run tables model by model and write docs/impostors.md."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="+", choices=(*TABLES, "all", "write"))
    parser.add_argument("--models", nargs="+", default=list(MODELS))
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--degrees", type=int, default=360)
    parser.add_argument("--radii", type=float, nargs="+", default=list(RADII))
    chosen = parser.parse_args()
    tables = TABLES if "all" in chosen.tables else tuple(t for t in chosen.tables if t != "write")
    worker = GpuWorker()
    renderer = Renderer(worker)
    if "speed" in tables:
        impostor_tables.keep("speed", speed(worker))
    if "pay" in tables:
        impostor_tables.keep("pay", impostor_pay.pay(renderer))
    for name in chosen.models:
        for kind in tables:
            done = {row.get("model") for row in impostor_tables.kept(kind)} if chosen.resume else set()
            if kind not in OF_BALLS and name not in done and name in ONLY.get(kind, MODELS):
                print(kind, name, flush=True)
                impostor_tables.keep(kind, _rows(worker, renderer, chosen, kind, name))
    worker.close()
    impostor_tables.write()


def _rows(worker: GpuWorker, renderer: Renderer, chosen: argparse.Namespace, kind: str, name: str) -> list[dict]:
    """One model's rows of a table."""
    if kind in ORBITS:
        return ORBITS[kind](renderer, name, chosen.degrees)
    if kind in FILMS:
        return FILMS[kind](renderer, name)
    measure = {"predictors": predictors, "pictures": lambda stage, n: pictures(stage, n, chosen.radii)}[kind]
    return worker.call(lambda context: measure(Stage(device_of(context, worker), load(name)), name))


if __name__ == "__main__":
    main()
