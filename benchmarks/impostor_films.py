"""Films of one model as an impostor: orbits under the life cycle, and the shadows that impostors cast, against the geometry's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from addon.maths.relief.beta import betas
from addon.maths.relief.frame import capture_frame
from addon.maths.relief.life import LifeModel
from addon.maths.relief.picture import psnr_db
from addon.maths.relief.settings import CASTERS, USUAL, ImpostorSettings
from addon.maths.view import Camera
from addon.pipeline.device import device_of
from addon.pipeline.frame import ImpostorReport
from addon.pipeline.impostors.life import library_of
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.scene.records import Instances, Mesh, Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from benchmarks.impostor_stage import Stage, load

SIDE, MAP = 192, 1024
RESTED = ("depth", "id-depth", "triangle")
REST_EYES = (30, 20, 8.0), (120, 40, 5.0), (200, 50, 4.0), (290, 10, 12.0)
"""Azimuth and elevation in degrees, distance in radii."""
SPRITE_ONLY = ImpostorSettings(limit=1e-6, sprite_px=1.0, ahead=0.0), LifeModel(waiting=1e9)
LIVES = {
    "sprite only": SPRITE_ONLY,
    "edge_fast_px": (USUAL,),
    "edge_fast_px, captured from the eye": (ImpostorSettings(ahead=0.0),),
    "edge_fast_px, sprites up to a pixel (RI)": (ImpostorSettings(sprite_px=1.0),),
} | {p: (ImpostorSettings(predictor=p),) for p in ("critical", "regions_sum", "regions_max_px")}
SETTINGS = Settings().replaced(fit={"kind": "scene", "size": MAP}, partition={"kind": "none"}, shading={"samples": 1})


@dataclass(frozen=True)
class Film:
    """Pictures (side, side, 3) float32 and silhouettes (side, side) of a path's frames, and each frame's report (none for geometry)."""

    frames: list[tuple[np.ndarray, np.ndarray]]
    reports: list[ImpostorReport]

    @property
    def stages(self) -> list[str]:
        """What was done in each frame."""
        return [report.stage for report in self.reports]

    def quality_db(self, real: Film) -> list[float]:
        """PSNR of every frame against another film's, over both silhouettes; equal ones 99."""
        return [min(psnr_db(a, b, u), 99.0) for (a, u), (b, _) in zip(self.frames, real.frames, strict=True)]

    def differences(self) -> np.ndarray:
        """Mean absolute difference of every frame from the one before."""
        return np.array([np.abs(a[0] - b[0]).mean() for a, b in zip(self.frames[1:], self.frames[:-1], strict=True)])


@dataclass(frozen=True)
class Orbit:
    """A path round a model, a frame a degree."""

    frames: int
    elevation_deg: float = 20.0
    radii: float = 8.0

    def camera(self, stage: Stage, angle_deg: float) -> Camera:
        """The camera at an angle of it."""
        return stage.camera(angle_deg, self.elevation_deg, self.radii)

    def cameras(self, stage: Stage) -> list[Camera]:
        """All of them."""
        return [self.camera(stage, angle) for angle in range(self.frames)]


def filmed(
    renderer: Renderer, scene: Scene, cameras: Sequence[Camera], choice: ImpostorChoice | None, settings: Settings = SETTINGS
) -> Film:
    """A path with shadows, `SIDE`² pixels of 2 × 2 samples."""
    renderer.worker.call(lambda context: library_of(device_of(context, renderer.worker)).release())
    stage, frames, reports = Stage(None, scene), [], []
    blocks = (SIDE, 2, SIDE, 2)
    for camera in cameras:
        frame = run(
            Job(scene, camera, stage.sun(), settings, (2 * SIDE, 2 * SIDE), ("combined", "object"), measure=False, impostors=choice),
            on=renderer,
        ).frame
        picture = np.clip(frame.passes["combined"][..., :3], 0, 1).reshape(*blocks, 3).mean(axis=(1, 3)).astype(np.float32)
        frames.append((picture, (frame.passes["object"] >= 0).reshape(blocks).any(axis=(1, 3))))
        reports += frame.impostors
    return Film(frames, reports)


@lru_cache(maxsize=1)
def truth(renderer: Renderer, name: str, path: Orbit) -> Film:
    """The geometry's own film, made once for all tables that compare with it."""
    return filmed(renderer, load(name), path.cameras(Stage(None, load(name))), None)


def whole(scene: Scene, settings: ImpostorSettings = USUAL, model: LifeModel | None = None) -> ImpostorChoice:
    """All of a model as one impostor, however cheap its geometry is; two texels a pixel, as a pixel has 2 × 2 samples."""
    group = ImpostorGroup("model", tuple(range(len(scene.object_names))))
    return ImpostorChoice((group,), replace(settings, break_even=False, texels_per_pixel=1.0), model or LifeModel())


def lived(renderer: Renderer, name: str, path: Orbit, *life: ImpostorSettings | LifeModel) -> dict:
    """One orbit under one life cycle: captures, quality, jumps at renewals."""
    scene, real = load(name), truth(renderer, name, path)
    stage = Stage(None, scene)
    shown = filmed(renderer, scene, path.cameras(stage), whole(scene, *life))
    quality = shown.quality_db(real)
    jumps, true_jumps = shown.differences(), real.differences()
    renewed = np.array([s == "regenerated" for s in shown.stages[1:]])
    return {
        "model": name,
        "frames": path.frames,
        "captures": sum(r.captures for r in shown.reports),
        "renewals": shown.stages.count("regenerated"),
        "geometry": shown.stages.count("geometry"),
        "sprite_deg": sprite_degrees(stage, path),
        "psnr_min": min(quality),
        "psnr_median": float(np.median(quality)),
        "below_26": sum(q < 26.0 for q in quality),
        "jump": float(jumps[renewed].max() / np.median(jumps)) if renewed.any() else None,
        "true_jump": float(true_jumps.max() / np.median(true_jumps)),
        "jump_beside": float((jumps / np.maximum(true_jumps, 1e-9))[renewed].max()) if renewed.any() else None,
    }


def orbit(renderer: Renderer, name: str, degrees: int) -> list[dict]:
    """The default life cycle round one model."""
    return [lived(renderer, name, Orbit(degrees))]


def elsewhere(renderer: Renderer, name: str, degrees: int) -> list[dict]:
    """The same on the first quarter of a path that no constant was chosen by: nearer and from higher up."""
    return [lived(renderer, name, Orbit(degrees // 4, 50.0, 5.0))]


def life(renderer: Renderer, name: str, degrees: int) -> list[dict]:
    """The first third of an orbit per life cycle."""
    return [lived(renderer, name, Orbit(degrees // 3), *rules) | {"way": way} for way, rules in LIVES.items()]


def rest(renderer: Renderer, name: str) -> list[dict]:
    """Pictures at the capture's own eye, with shadows, by test: also of a model finer than its texels, which would be geometry."""
    scene, rows = load(name), []
    stage, always = Stage(None, scene), whole(scene, model=LifeModel(finest=float("inf")))
    for test in RESTED:
        settings = SETTINGS.replaced(test={"kind": test})
        for azimuth, elevation, radii in REST_EYES:
            camera = [stage.camera(azimuth, elevation, radii)]
            (quality,) = filmed(renderer, scene, camera, always, settings).quality_db(filmed(renderer, scene, camera, None, settings))
            rows.append({"model": name, "test": test, "eye": [azimuth, elevation, radii], "psnr_db": quality})
    return rows


def sprite_degrees(stage: Stage, path: Orbit) -> float:
    """How far the orbit goes on before Schaufler's β exceeds a pixel of a picture of `SIDE`²: the life of a sprite, in degrees."""
    size = (SIDE, SIDE)
    frame = capture_frame(stage.hull, path.camera(stage, 0.0), size)
    low, high = 0.0, 45.0
    for _ in range(30):
        middle = (low + high) / 2.0
        found = betas(frame, stage.hull, path.camera(stage, middle), size)
        low, high = (middle, high) if found.total <= found.screen else (low, middle)
    return low


def on_a_floor(scene: Scene) -> Scene:
    """The scene with a square under it, four times as wide: its last object."""
    box = scene.bounds_ws()
    middle, half = box.mean(axis=0), 2.0 * float((box[1] - box[0])[:2].max())
    corners = np.array([[x, y, 0.0] for y in (-half, half) for x in (-half, half)]) + [middle[0], middle[1], box[0, 2]]
    floor = Mesh(("floor", scene.object_names), corners, corners, np.array([[0, 1, 3], [0, 3, 2]]))
    own = scene.instances
    placing = Instances(
        np.append(own.mesh_index, len(scene.meshes)),
        np.concatenate([own.world_from_object, np.eye(4)[None]]),
        np.append(own.object_id, len(scene.object_names)),
        np.append(own.material_slot, 0),
        np.concatenate([own.base_color, np.full((1, 4), 0.7)]),
    )
    return Scene((*scene.meshes, floor), placing, (*scene.object_names, "floor"), scene.origin_ws)


def shadows(renderer: Renderer, name: str) -> list[dict]:
    """Shadows on a floor from casters captured from the sun against those of the triangles, from four sides."""
    bare = load(name)
    scene, stage, rows = on_a_floor(bare), Stage(None, bare), []
    for angle in (30, 120, 210, 300):
        camera, seen = stage.camera(angle, 40, 5.0), {}
        for casters in CASTERS:
            frame = run(
                Job(
                    scene,
                    camera,
                    stage.sun(),
                    SETTINGS,
                    (2 * SIDE, 2 * SIDE),
                    ("shadow", "object"),
                    measure=False,
                    impostors=whole(bare, ImpostorSettings(casters=casters)),
                ),
                on=renderer,
            ).frame
            seen[casters] = frame.passes
        floor = (seen["geometry"]["object"] == len(bare.object_names)) & (seen["impostor"]["object"] == len(bare.object_names))
        there, real = (seen[casters]["shadow"][floor] for casters in ("impostor", "geometry"))
        wrong = int((np.abs(there - real) > 0.5).sum())
        rows.append({"model": name, "floor": int(floor.sum()), "dark": int((real < 0.5).sum()), "wrong": wrong})
    return rows
