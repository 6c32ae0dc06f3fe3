"""Whether impostors pay: whole pictures with the break-even against the geometry's, in a view that moves and as final renders."""

from __future__ import annotations

import time

import numpy as np

from addon.pipeline.device import device_of
from addon.pipeline.impostors.life import library_of
from addon.pipeline.impostors.records import ImpostorChoice
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.settings.groups import ImpostorSettings
from addon.studies.impostors.asked import choice_for
from addon.studies.run import run
from benchmarks.impostor_films import SETTINGS, whole
from benchmarks.impostor_stage import Stage, ball_scene

SIDE, FRAMES, STEP_DEG = 256, 5, 0.5
RINGS = 50, 250, 500
LIT = SETTINGS.replaced(shading={"samples": 4}, test={"kind": "triangle"})


def pay(renderer: Renderer) -> list[dict]:
    """A row per ball: milliseconds a picture as geometry, in a moving view and in final renders, and how many were impostors."""
    return [_ball(renderer, rings) for rings in RINGS]


def _ball(renderer: Renderer, rings: int) -> dict:
    stage = Stage(None, ball_scene(rings))
    groups = whole(stage.scene).groups
    ways = {"geometry": None, "view": choice_for(groups, ImpostorSettings()), "fresh": choice_for(groups, ImpostorSettings(), fresh=True)}
    for fresh in (False, True):
        renderer.worker.call(lambda context, fresh=fresh: library_of(device_of(context, renderer.worker), fresh).release())
    times, stages = np.zeros((FRAMES, len(ways), 2)), {name: [] for name in ways}
    for frame in range(FRAMES):
        for way, (name, choice) in enumerate(ways.items()):
            times[frame, way] = _timed(renderer, stage, frame, choice, stages[name])
    row = {"triangles": stage.scene.triangle_count, "frames": FRAMES}
    for way, name in enumerate(ways):
        wall, cpu = 1e3 * times[2:, way].mean(axis=0)
        row |= {f"{name}_ms": float(wall), f"{name}_cpu_ms": float(cpu), f"{name}_impostors": sum(s != "geometry" for s in stages[name])}
    return row


def _timed(renderer: Renderer, stage: Stage, frame: int, choice: ImpostorChoice | None, stages: list[str]) -> tuple[float, float]:
    """Wall and processor seconds of one picture."""
    camera = stage.camera(30 + STEP_DEG * frame, 20, 4.0)
    asked = Job(stage.scene, camera, stage.sun(), LIT, (SIDE, SIDE), ("combined",), measure=False, impostors=choice)
    begin = time.perf_counter(), time.process_time()
    reports = run(asked, on=renderer).frame.impostors
    stages += [report.stage for report in reports]
    return time.perf_counter() - begin[0], time.process_time() - begin[1]
