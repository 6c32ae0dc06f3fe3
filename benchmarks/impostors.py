"""Relief impostors, measured: `python -m benchmarks.impostors TABLE [--models NAME…]` → docs/impostors.md.

    predictors   every predictor against the pixels that a capture has really never seen
    pictures     sprite, forward warp, one layer, two layers, two captures against the geometry, 0…60°, 3…16 radii
    life         an orbit at 1° steps: frames lived, worst picture, jumps; for sprites alone and with several predictors
    orbit        360° at 1° steps round each model, automatic, as the program does it by default: worst frame, jumps at renewals
    speed        an impostor against its geometry, and 200 predictions

Results go to benchmarks/results/impostors-*.json model by model; `--resume` leaves out those already there. `write` (done at the end of
each) makes docs/impostors.md from what is there.
Needs the dev models beside the checkout; no bpy.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace

import numpy as np

from addon.maths.relief_beta import betas
from addon.maths.relief_error import predict, predict_one, relief_set
from addon.maths.relief_frame import capture_frame
from addon.maths.relief_life import LifeSettings
from addon.maths.relief_picture import picture_errors, psnr_db
from addon.pipeline.context import GpuWorker
from addon.pipeline.device import device_of
from addon.pipeline.impostor_life import ImpostorChoice, ImpostorGroup, library_of
from addon.pipeline.renderer import Renderer
from addon.pipeline.settings import Settings
from benchmarks import impostor_tables
from benchmarks.impostor_stage import MODELS, Stage, ball_scene, load

SIZE, ORBIT_SIZE = 240, 192
ANGLES, RADII = (0, 5, 10, 20, 30, 45, 60), (3.0, 8.0, 16.0)
SPRITE_ONLY = LifeSettings(limit=1e-9, waiting=1e9)


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
    """Every way of drawing, at every angle and distance, 4 × 4 supersampled, two texels a pixel."""
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
            ):
                errors = picture_errors(*_pair(stage.picture(camera, SIZE, textures, method), truth))
                rows.append({"model": name, "way": way, "angle": angle, "radii": radii, **asdict(errors)})
            second.release()
        for impostor in (both, front, flat):
            impostor.release()
    return rows


def _pair(picture: tuple[np.ndarray, np.ndarray], truth: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, ...]:
    return picture[0], truth[0], picture[1], truth[1]


def life(renderer: Renderer, name: str, degrees: int) -> list[dict]:
    """One orbit at 8 radii per life cycle: stages, quality, jumps."""
    scene = load(name)
    rows = []
    ways = {
        "sprite only": SPRITE_ONLY,
        **{p: LifeSettings(predictor=p) for p in ("edge_fast_px", "critical", "regions_sum", "regions_max_px")},
    }
    truths = _film(renderer, scene, range(degrees), None)[0]
    for way, rules in ways.items():
        group = ImpostorGroup("model", tuple(range(len(scene.object_names))))
        choice = ImpostorChoice((group,), life=rules, never_dearer=False)
        choice = replace(choice, capture=replace(choice.capture, texels_per_pixel=1.0))
        frames, stages = _film(renderer, scene, range(degrees), choice)
        quality = [psnr_db(a, b, u) for (a, u), (b, _) in zip(frames, truths, strict=True)]
        jumps = np.array([np.abs(a[0] - b[0]).mean() for a, b in zip(frames[1:], frames[:-1], strict=True)])
        renewed = np.array([s == "regenerated" for s in stages[1:]])
        rows.append(
            {
                "model": name,
                "way": way,
                "frames": len(stages),
                "captures": stages.count("regenerated"),
                "geometry": stages.count("geometry"),
                "sprite_deg": _sprite_degrees(Stage(None, scene)),
                "psnr_min": min(quality),
                "psnr_median": float(np.median(quality)),
                "jump": float(jumps[renewed].max() / np.median(jumps)) if renewed.any() else None,
            }
        )
    return rows


def orbit(renderer: Renderer, name: str, degrees: int) -> list[dict]:
    """The default life cycle round one model: the worst frame, the captures, the frame differences at renewals."""
    scene = load(name)
    group = ImpostorGroup("model", tuple(range(len(scene.object_names))))
    choice = ImpostorChoice((group,), never_dearer=False)
    choice = replace(choice, capture=replace(choice.capture, texels_per_pixel=1.0))
    frames, stages = _film(renderer, scene, range(degrees), choice, ORBIT_SIZE)
    shown = [i for i, stage in enumerate(stages) if stage != "geometry"]
    truths = list(frames)  # a frame of geometry is its own truth
    for i, truth in zip(shown, _film(renderer, scene, shown, None, ORBIT_SIZE)[0], strict=True):
        truths[i] = truth
    quality = [psnr_db(a, b, u) for (a, u), (b, _) in zip(frames, truths, strict=True)]
    jumps = np.array([np.abs(a[0] - b[0]).mean() for a, b in zip(frames[1:], frames[:-1], strict=True)])
    true_jumps = np.array([np.abs(a[0] - b[0]).mean() for a, b in zip(truths[1:], truths[:-1], strict=True)])
    renewed = np.array([s == "regenerated" for s in stages[1:]])
    finite = [min(q, 99.0) for q in quality]
    return [
        {
            "model": name,
            "frames": len(stages),
            "captures": stages.count("regenerated"),
            "geometry": stages.count("geometry"),
            "sprite_deg": _sprite_degrees(Stage(None, scene)),
            "psnr_min": min(finite),
            "psnr_median": float(np.median(finite)),
            "below_26": sum(q < 26.0 for q in quality),
            "jump": float(jumps[renewed].max() / np.median(jumps)) if renewed.any() else None,
            "true_jump": float(true_jumps.max() / np.median(true_jumps)),
        }
    ]


def _sprite_degrees(stage: Stage) -> float:
    """How far the orbit goes on before Schaufler's β exceeds a pixel: the life of a sprite, in degrees."""
    frame = capture_frame(stage.hull, stage.camera(0, 20, 8.0), (SIZE, SIZE))
    low, high = 0.0, 45.0
    for _ in range(30):
        middle = (low + high) / 2.0
        found = betas(frame, stage.hull, stage.camera(middle, 20, 8.0), (SIZE, SIZE))
        low, high = (middle, high) if found.total <= found.screen else (low, middle)
    return low


def _film(
    renderer: Renderer, scene: object, degrees: Sequence[int], choice: ImpostorChoice | None, side: int = SIZE
) -> tuple[list[tuple[np.ndarray, np.ndarray]], list[str]]:
    """[(picture, silhouette)] and the stages of an orbit at these degrees; `side` pixels, 2 × 2 samples each."""
    renderer.worker.call(lambda context: library_of(device_of(context, renderer.worker)).release())
    stage, frames, stages = Stage(None, scene), [], []
    settings = Settings().replaced(fit={"kind": "scene", "size": 1024}, partition={"kind": "none"}, shading={"samples": 1})
    blocks = (side, 2, side, 2)
    for angle in degrees:
        camera = stage.camera(angle, 20, 8.0)
        frame = renderer.render(
            scene, camera, stage.sun(), settings, (2 * side, 2 * side), ("combined", "object"), measure=False, impostors=choice
        )
        picture = np.clip(frame.passes["combined"][..., :3], 0, 1).reshape(*blocks, 3).mean(axis=(1, 3))
        frames.append((picture, (frame.passes["object"] >= 0).reshape(blocks).any(axis=(1, 3))))
        stages += [r.stage for r in frame.impostors]
    return frames, stages


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
            geometry = _milliseconds(lambda: stage.direct(camera, (512, 512)), 5)
            drawn = _milliseconds(lambda: stage.drawn(camera, (512, 512), [impostor]), 9)
            made = _milliseconds(lambda: stage.capture(camera, (512, 512), texels=1.0).release(), 3)
            textures = relief_set([impostor.edges] * 200)
            predicted = _milliseconds(lambda: predict(textures, camera, (512, 512), exact=False), 31)
            impostor.release()
            return {
                "triangles": scene.triangle_count,
                "texture": size,
                "geometry_ms": geometry,
                "impostor_ms": drawn,
                "capture_ms": made,
                "predict_200_ms": predicted,
            }

        rows.append(worker.call(job))
    return rows


def _milliseconds(job: Callable[[], object], repeats: int) -> float:
    """Median time of `job`, which waits for the GPU itself."""
    job()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        job()
        times.append(time.perf_counter() - begin)
    return 1e3 * float(np.median(times))


def main() -> None:
    """Run one table and write docs/impostors.md."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", choices=("predictors", "pictures", "life", "orbit", "speed", "write"))
    parser.add_argument("--models", nargs="+", default=list(MODELS))
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--degrees", type=int, default=360)
    parser.add_argument("--radii", type=float, nargs="+", default=list(RADII))
    chosen = parser.parse_args()
    done = {row.get("model") for row in impostor_tables.kept(chosen.table)} if chosen.resume else set()
    worker = GpuWorker()
    if chosen.table == "speed":
        impostor_tables.keep("speed", speed(worker))
    for name in chosen.models if chosen.table in ("predictors", "pictures", "life", "orbit") else ():
        if name not in done:
            print(name, flush=True)
            impostor_tables.keep(chosen.table, _rows(worker, chosen, name))
    worker.close()
    impostor_tables.write()


def _rows(worker: GpuWorker, chosen: argparse.Namespace, name: str) -> list[dict]:
    """One model's rows of the chosen table."""
    if chosen.table in ("life", "orbit"):
        return {"life": life, "orbit": orbit}[chosen.table](Renderer(worker), name, chosen.degrees)
    measure = {"predictors": predictors, "pictures": lambda stage, n: pictures(stage, n, chosen.radii)}[chosen.table]
    return worker.call(lambda context: measure(Stage(device_of(context, worker), load(name)), name))


if __name__ == "__main__":
    main()
