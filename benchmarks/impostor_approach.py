"""A model approached as an impostor: what renewals cost that carry the predictors' edges over, and what that does to the picture."""

from __future__ import annotations

import time
from unittest.mock import patch

import numpy as np

from addon.maths.relief.edges import ReliefEdges
from addon.maths.relief.error import predict_one
from addon.pipeline.device import device_of
from addon.pipeline.impostors import life
from addon.pipeline.impostors.capture import capture
from addon.pipeline.renderer import Renderer
from benchmarks.impostor_films import SIDE, filmed, whole
from benchmarks.impostor_stage import Stage, load

FRAMES, BEGIN, END = 60, 16.0, 3.0
HALF_FOV_DEG = 19.5
ASIDE_DEG = (-10, -5, 5, 10)
REPEATS = 5


def approach(renderer: Renderer, name: str) -> list[dict]:
    """From 16 to 3 radii in 60 frames, the default life cycle; beside it the same with everything gathered anew at each renewal."""
    scene = load(name)
    stage = Stage(None, scene)
    radii = BEGIN * (END / BEGIN) ** np.linspace(0.0, 1.0, FRAMES)
    cameras = [stage.camera(30, 20, float(r), half_fov_deg=HALF_FOV_DEG) for r in radii]
    real = filmed(renderer, scene, cameras, None)
    shown = filmed(renderer, scene, cameras, whole(scene))
    with patch.object(life, "carries", lambda edges, frame: False):
        anew = filmed(renderer, scene, cameras, whole(scene))
    renewed = [(r, i) for i, r in enumerate(shown.reports) if r.stage == "regenerated"]
    carried = [(report.edges, float(radii[i])) for report, i in renewed if report.edges.gathered is not None]
    row = {
        "model": name,
        "frames": FRAMES,
        "captures": len(renewed),
        "carried": len(carried),
        "captures_anew": anew.stages.count("regenerated"),
        "psnr_min": min(shown.quality_db(real)),
        "psnr_min_anew": min(anew.quality_db(real)),
    }
    if carried:
        row |= renderer.worker.call(lambda context: _compared(Stage(device_of(context, renderer.worker), scene), carried))
    return [row]


def _compared(stage: Stage, carried: list[tuple[ReliefEdges, float]]) -> dict:
    """Each capture that carried its edges over made again both ways in turn: ms, and what both predict some degrees aside.

    `opened_pct` (carried, fresh), medians of the share of the pixels covered; `apart_pct` the most that the two differ.
    """
    times, opened = [], []
    for edges, radii in carried:
        cost = np.zeros((REPEATS, 2, 2))
        for round_of in cost:
            for way, known in enumerate((None, edges.gathered)):
                begin = time.perf_counter(), time.process_time()
                textures = capture(stage.device, stage.draw_list, stage.rows, edges.frame, known=known)
                stage.device.context.finish()
                round_of[way] = time.perf_counter() - begin[0], time.process_time() - begin[1]
                if known is None:
                    fresh = textures.edges
                textures.release()
        times.append(1e3 * np.median(cost, axis=0))
        for angle in ASIDE_DEG:
            camera = stage.camera(30 + angle, 20, radii, half_fov_deg=HALF_FOV_DEG)
            seen = [predict_one(one, camera, (2 * SIDE, 2 * SIDE)) for one in (edges, fresh)]
            opened.append([100.0 * found["edge_fast_px"] / found["covered_px"] for found in seen])
    (anew, over), opened = np.mean(times, axis=0), np.array(opened)
    return {
        "anew_ms": float(anew[0]),
        "anew_cpu_ms": float(anew[1]),
        "carried_ms": float(over[0]),
        "carried_cpu_ms": float(over[1]),
        "opened_pct": np.median(opened, axis=0).tolist(),
        "apart_pct": float(np.abs(opened[:, 0] - opened[:, 1]).max()),
    }
