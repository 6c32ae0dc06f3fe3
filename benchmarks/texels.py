"""How large the texels of every method are in the picture: all models, views and lights in two minutes, without truth.

A view is drawn once for its visible points and normals; every method is then fitted to them in numpy, and the error m of each point is
exact (`addon/maths/error/measure.py`). The edge of a shadow is as wrong as texels are long across it, so what is compared is the mean of a
texel's two extents in the picture, in pixels: m alone, their product, would not tell long thin texels from square ones.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from addon.maths.error.aliasing import error_statistics
from addon.maths.error.measure import aliasing, pixel_gradients, texel_gradients
from addon.maths.shadow.fit import plan_shadows
from addon.maths.shadow.lookup import partition_index, towards_light
from addon.maths.shadow.projection import ShadowPlan
from addon.maths.view import Camera, Light
from addon.pipeline.job import Job
from addon.pipeline.passes.gbuffer import surface_points_ws
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from benchmarks import models, views
from benchmarks.views import View, depth_ratio

MOST_FITTED, MOST_MEASURED = 60_000, 4_000
FACING = 0.05  # cosine from which a surface counts as facing the light
LARGEST_SIDE = 20  # pixels: a surface along the ray has no bound


@dataclass(frozen=True)
class TexelRow:
    """One view, light and method: the mean extent of a texel in pixels and m over the points that face the light."""

    model: str
    view: str
    light: str
    method: str
    depth_ratio: float
    side_mean: float
    m_p95: float


@dataclass(frozen=True, eq=False)
class Seen:
    """What a view shows: (P, 3) points and normals, thinned out, and the scene's boxes."""

    view: View
    ratio: float
    points: np.ndarray
    normals: np.ndarray
    bounds: np.ndarray
    casters: np.ndarray

    def row(self, model: str, light: Light, name: str, settings: Settings) -> TexelRow | None:
        """The method's texels; None where nothing faces the light."""
        camera, s = self.view.camera, settings
        step = -(-len(self.points) // MOST_MEASURED)
        points, normals = self.points[::step].astype(np.float64), self.normals[::step].astype(np.float64)
        facing = (normals * towards_light(light, points)).sum(axis=-1) > FACING
        if not facing.any():
            return None
        plan = plan_shadows(
            camera,
            light,
            s.warp,
            s.partition,
            s.fit,
            receivers_ws=self.points,
            scene_bounds_ws=self.bounds,
            caster_bounds_ws=self.casters,
            image_size=views.SIZE,
            facets=(points, normals),
        )
        m = aliasing(camera, light, plan, points[facing], normals[facing], views.SIZE, s.fit.size)[:, 0]
        sides = np.minimum(extents(camera, plan, points[facing], normals[facing], s.fit.size), LARGEST_SIDE)
        return TexelRow(model, self.view.name, light.name, name, self.ratio, float(np.nanmean(sides)), error_statistics(m)["m_p95"])


def extents(camera: Camera, plan: ShadowPlan, points: np.ndarray, normals: np.ndarray, size: int) -> np.ndarray:
    """(P,) half the sum of a texel's two extents in the picture, as it lies on the surface; NaN where no map serves the point."""
    index, out = partition_index(plan, camera, points), np.full(len(points), np.nan)
    for i, projection in enumerate(plan.projections):
        own = np.flatnonzero(index == i)
        grad_s, grad_t = texel_gradients(projection, points[own], size)
        pixels = pixel_gradients(camera, points[own], views.SIZE)
        total = np.zeros(len(own))
        for across, along in ((grad_t, grad_s), (grad_s, grad_t)):  # a step along one axis of the map keeps the other coordinate
            step = np.cross(across, normals[own])
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                step /= (along * step).sum(axis=-1, keepdims=True)
                total += np.hypot(*((gradient * step).sum(axis=-1) for gradient in pixels))
        out[own] = 0.5 * np.where(np.isfinite(total), total, 2.0 * LARGEST_SIDE)
    return out


def seen(scene: Scene, view: View) -> Seen:
    """The visible points of one view."""
    settings = Settings().replaced(fit={"size": 64}, shading={"samples": 1})
    passes = run(Job(scene, view.camera, None, settings, size=views.SIZE, passes=("depth", "normal"))).frame.passes
    depth = np.where(np.isfinite(passes["depth"]), passes["depth"], 0.0)[::-1]
    points, normals = surface_points_ws(depth, view.camera), passes["normal"][::-1][depth > 0.0]
    step = -(-len(points) // MOST_FITTED)
    return Seen(view, depth_ratio(passes["depth"]), points[::step], normals[::step], scene.bounds_ws(), scene.instance_bounds_ws())


def measure(names: Iterable[str], methods: Mapping[str, Settings]) -> Iterator[TexelRow]:
    """Rows of every model × view × light × method, in that order."""
    for model in names:
        scene = models.load(model)
        for view in views.views(model, scene):
            here = seen(scene, view)
            for light in views.lights(view.camera).values():
                rows = (here.row(model, light, name, settings) for name, settings in methods.items())
                yield from (row for row in rows if row is not None)


def write(path: Path, rows: Iterable[TexelRow]) -> None:
    """One JSON object a line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(json.dumps(asdict(row)) + "\n" for row in rows), encoding="utf-8")


def read(path: Path) -> list[TexelRow]:
    """Rows that `write` wrote."""
    return [TexelRow(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]
