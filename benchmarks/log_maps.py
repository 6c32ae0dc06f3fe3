"""Cost and exactness of LogPSM's maps: `python -m benchmarks.log_maps` writes docs/log_maps.md.

The rival is the linear pass of the same map: same matrix, strip and casters, without the logarithm. Both are drawn in turn, in one process;
times are CPU time of the process and ratios are of medians, so that a busy machine does not count.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np

from addon.maths.shadow.lookup import unproject
from addon.maths.shadow.projection import ShadowPlan, ShadowProjection
from addon.maths.view import Camera, Light
from addon.pipeline.device import device_of
from addon.pipeline.job import Job
from addon.pipeline.passes.log_map import BEND_TEXELS
from addon.pipeline.passes.shadow import draw_shadow_maps
from addon.pipeline.renderer import Renderer
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from addon.studies.truth.backends import EmbreeBackend
from addon.studies.truth.triangles import world_triangles
from benchmarks import models, views
from benchmarks.tables import table

PAGE = Path(__file__).resolve().parents[1] / "docs" / "log_maps.md"
MODELS = ("deck", "tower_crane.glb", "hand_wheel_valve.ply")
SIZES = (1024, 2048)
ROUNDS = 9
DIFFERENT = 1e-3  # of the depth range
INTRO = f"""# Logarithmic maps: cost and exactness

Made by `python -m benchmarks.log_maps`; do not edit. One LogPSM map, `samples` fit, light from the side, CPU rasteriser.

**×**: CPU time of the map pass over that of the linear pass of the same map (same matrix, same casters, without the logarithm), drawn in
turn {ROUNDS} times, medians. **Different**: share of texels whose depth differs from that of a ray through the texel's centre (Embree) by
more than {DIFFERENT:g} of the depth range; the linear map's own share beside it. Texels with a caster before the near plane, clamped to it,
are left out. The edges of the pieces lie within `BEND_TEXELS` = {BEND_TEXELS:g} texels of their curves
(`addon/pipeline/passes/log_map.py`).
"""


def drawn(renderer: Renderer, scene: Scene, size: int, plans: tuple[ShadowPlan, ...]) -> tuple[list[float], list[np.ndarray]]:
    """Median CPU milliseconds and the map (N, N) of each plan, drawn in turn; the first round is not counted."""
    test = Settings().test

    def job(context: object) -> tuple[list[float], list[np.ndarray]]:
        device = device_of(context, renderer.worker)
        draw_list, maps = device.store.sync(scene), device.shadow_maps(size, 1, test)
        times: list[list[float]] = [[] for _ in plans]
        pictures = []
        for turn in range(ROUNDS + 1):
            for plan, spent in zip(plans, times, strict=True):
                context.finish()
                begin = time.process_time()
                draw_shadow_maps(context, device.programs, maps, draw_list, plan, test)
                context.finish()
                spent.append(1e3 * (time.process_time() - begin))
                if turn == 0:
                    pictures.append(maps.read()[0].copy())
        return [median(spent[1:]) for spent in times], pictures

    return renderer.worker.call(job)


def ray_depth(backend: EmbreeBackend, projection: ShadowProjection, size: int) -> np.ndarray:
    """(N, N) depth 0…1 of the first surface met by the ray through each texel's centre, 1 where none."""
    centre = (np.arange(size) + 0.5) * 2.0 / size - 1.0
    s, t = (grid.ravel() for grid in np.meshgrid(centre, centre))
    near, far = (unproject(projection, s, t, np.full_like(s, end)) for end in (-1.0, 1.0))
    length = np.linalg.norm(far - near, axis=1)
    direction = (far - near) / length[:, None]
    triangle, distance = backend.nearest(near, direction, length)
    hit = np.c_[near + direction * np.where(triangle >= 0, distance, 0.0)[:, None], np.ones(len(s))] @ projection.clip_from_world.T
    depth = (hit[:, 2] if projection.log else hit[:, 2] / hit[:, 3]) * 0.5 + 0.5
    return np.where(triangle >= 0, depth, 1.0).reshape(size, size)


def different_pct(picture: np.ndarray, expected: np.ndarray) -> float:
    """Per cent of the texels that are not what the ray met."""
    return float(100.0 * ((np.abs(picture - expected) > DIFFERENT) & (picture > 0.0)).mean())


def line(renderer: Renderer, scene: Scene, backend: EmbreeBackend, camera: Camera, light: Light, size: int) -> tuple[float, ...]:
    """f'/n', milliseconds of both passes, their ratio, and both shares of different texels."""
    chosen = Settings().replaced(warp={"kind": "logpsm"}, partition={"kind": "none"}, fit={"kind": "samples", "size": size})
    plan = run(Job(scene, camera, light, chosen, views.SIZE, ("combined",), measure=False), on=renderer).frame.plan
    log = plan.projections[0]
    linear = replace(plan, projections=(replace(log, log=None),))
    times, pictures = drawn(renderer, scene, size, (plan, linear))
    shares = [
        different_pct(picture, ray_depth(backend, p.projections[0], size)) for picture, p in zip(pictures, (plan, linear), strict=True)
    ]
    return log.log.far / log.log.near, *times, times[0] / times[1], *shares


def main() -> None:
    """Measure every model and view, write the page."""
    renderer, parts = Renderer(), [INTRO]
    for size in SIZES:
        lines = []
        for name in (name for name in MODELS if name in models.available()):
            scene = models.load(name)
            backend = EmbreeBackend(world_triangles(scene).corners)
            for view in views.views(name, scene):
                numbers = line(renderer, scene, backend, view.camera, views.lights(view.camera)["side"], size)
                lines.append((Path(name).stem, view.name, *numbers[:4], *(f"{share:.4f}" for share in numbers[4:])))
                print(*lines[-1], flush=True)
        worst = max(float(row[5]) for row in lines)
        head = ("model", "view", "f'/n'", "logarithmic ms", "linear ms", "×", "different %", "linear: different %")
        parts.append(f"## {size}² texels\n\nAt most {worst:.2f} × the linear pass.\n\n" + table(head, lines))
    PAGE.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
