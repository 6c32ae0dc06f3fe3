"""Whether the limit of the predicted error holds: an orbit, an approach, a retreat and a spiral, as the program draws them by default."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from addon.maths.relief.picture import psnr_db
from addon.maths.relief.settings import USUAL
from addon.maths.view import Camera
from addon.pipeline.device import device_of
from addon.pipeline.frame import Frame
from addon.pipeline.impostors.life import library_of
from addon.pipeline.impostors.records import ImpostorChoice
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.studies.run import run
from benchmarks.impostor_films import SETTINGS, whole
from benchmarks.impostor_stage import Stage, load

SIDE, FRAMES = 96, 16
FARTHEST, NEAREST, HALF_FOV_DEG = 16.0, 2.5, 19.5
WRONG = 0.15
"""A pixel is wrong that differs by more than this in one of its colours (0…1)."""
LIT = SETTINGS.replaced(shading={"samples": 4}, test={"kind": "triangle"})


def paths(stage: Stage) -> dict[str, list[Camera]]:
    """The films: 1.5° a frame; from 16 to 2.5 radii, straight and turning 2° a frame; and back."""
    radii = FARTHEST * (NEAREST / FARTHEST) ** np.linspace(0.0, 1.0, FRAMES)
    there = [stage.camera(30, 20, float(r), half_fov_deg=HALF_FOV_DEG) for r in radii]
    turning = [stage.camera(47 + 2 * i, 35, float(r), half_fov_deg=HALF_FOV_DEG) for i, r in enumerate(radii)]
    orbit = [stage.camera(10 + 1.5 * i, 20, 6.0) for i in range(FRAMES)]
    return {"orbit": orbit, "approach": there, "retreat": there[::-1], "spiral": turning}


def limits(renderer: Renderer, name: str) -> list[dict]:
    """A row for every frame in which the model is drawn as an impostor, and one a path for how often it was not."""
    scene, rows = load(name), []
    stage = Stage(None, scene)
    choice = replace(whole(scene), settings=replace(USUAL, break_even=False))
    for path, cameras in paths(stage).items():
        renderer.worker.call(lambda context: library_of(device_of(context, renderer.worker)).release())
        for index, camera in enumerate(cameras):
            true, shown = (_drawn(renderer, stage, camera, asked) for asked in (None, choice))
            report = shown.impostors[0]
            row = {"model": name, "path": path, "frame": index, "stage": report.stage, "captures": report.captures, "limit": report.limit}
            rows.append(row | ({"predicted": report.error, **_measured(true, shown)} if report.stage != "geometry" else {}))
    return rows


def _drawn(renderer: Renderer, stage: Stage, camera: Camera, choice: ImpostorChoice | None) -> Frame:
    asked = Job(stage.scene, camera, stage.sun(), LIT, (SIDE, SIDE), ("combined", "object"), measure=False, impostors=choice)
    return run(asked, on=renderer).frame


def _measured(true: Frame, shown: Frame) -> dict[str, float]:
    """PSNR over both silhouettes (99 = equal), the share of their pixels that are wrong, and how many they are."""
    pictures = [np.clip(frame.passes["combined"][..., :3], 0.0, 1.0) for frame in (true, shown)]
    seen = (true.passes["object"] >= 0) | (shown.passes["object"] >= 0)
    apart = np.abs(pictures[0] - pictures[1]).max(axis=-1)[seen]
    return {"psnr_db": min(psnr_db(*pictures, seen), 99.0), "wrong": float((apart > WRONG).mean()), "pixels": int(seen.sum())}
