"""One frame as the advice sees it: its visible points that face the light, from a small picture, and their errors under any combination.

m is computed from exact Jacobians (`maths.error.measure`, the oracle of the shader) at the points, in pixels of the full picture: the same
numbers as the `aliasing` pass gives there, without drawing the maps. Surfaces turned from the light are dark whatever the map holds, so
they do not count.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...errors import SceneError
from ...maths.error.aliasing import aliasing_statistics
from ...maths.error.measure import aliasing
from ...maths.shadow.fit import plan_shadows
from ...maths.shadow.lookup import towards_light
from ...maths.shadow.projection import ShadowPlan
from ...pipeline.job import Job
from ...settings.groups import Settings
from ..run import run

PICTURE_PIXELS = 16_000
POINTS = 6_000
FACING = 0.02  # least cosine between surface and light


@dataclass(frozen=True, eq=False)
class SampledFrame:
    """A frame to be advised for: its `job` (full size, current settings) and its `number` in the animation."""

    job: Job
    number: int = 0

    @property
    def _small(self) -> tuple[int, int]:
        """The size of the picture that is read."""
        return small_size(self.job.size)

    @cached_property
    def _surface(self) -> tuple[np.ndarray, np.ndarray]:
        """(P, 3) points and (P, 3) normals of all pixels of a small picture that show a surface."""
        from ...pipeline.passes.gbuffer import seen_surface  # loads OpenGL

        job = self.job
        passes = run(
            replace(job, size=self._small, light=None, settings=quick(job.settings), passes=("depth", "normal"), measure=False)
        ).frame.passes
        seen, points = seen_surface(passes["depth"], job.camera)
        return points, passes["normal"][::-1][seen]

    @cached_property
    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """(Q, 3) points and normals, float64, Q ≤ `POINTS`, of the surface that faces the light, evenly picked."""
        points, normals = (a.astype(np.float64) for a in self._surface)
        facing = np.flatnonzero((normals * towards_light(self.job.light, points)).sum(axis=1) > FACING)
        if not len(facing):
            raise SceneError(f"The light reaches nothing that is in view{self._where}: turn the light or the camera.")
        picked = facing[:: -(-len(facing) // POINTS)]
        return points[picked], normals[picked]

    @property
    def _where(self) -> str:
        return f" in frame {self.number}" if self.number else ""

    def plan(self, settings: Settings) -> ShadowPlan:
        """The shadow maps of these settings for this frame, as fitted to the full picture: half a pixel is that of the picture read."""
        job = self.job
        return plan_shadows(
            job.camera,
            job.light,
            settings.warp,
            settings.partition,
            settings.fit,
            receivers_ws=self._surface[0],
            scene_bounds_ws=job.scene.bounds_ws(),
            caster_bounds_ws=job.scene.caster_bounds_ws(),
            image_size=self._small,
            facets=(self._surface[0].astype(np.float64), self._surface[1].astype(np.float64)),
        )

    def errors(self, settings: Settings) -> np.ndarray:
        """(Q, 3) total m, m_x, m_z of the points under these settings."""
        job = self.job
        return aliasing(job.camera, job.light, self.plan(settings), *self.points, job.size, settings.fit.size)

    @cached_property
    def view(self) -> tuple[float, float, float, float]:
        """(near, far, φ, γ) of what is really seen: what the theory is asked about."""
        camera = self.job.camera
        depth = (self.points[0] - camera.eye_ws) @ camera.direction_ws
        near = max(float(np.quantile(depth, 0.01)), camera.near)
        far = max(float(np.quantile(depth, 0.99)), 1.01 * near)
        return near, far, camera.half_fov_rad, self.plan(self.job.settings).gamma_rad

    def rendered(self, settings: Settings) -> dict[str, object]:
        """Statistics of a real picture under these settings at full size, of the same kind of pixels, and its time in milliseconds.

        Drawn twice: the first time may compile shaders and upload, which says nothing about the time of the next picture.
        """
        from ...pipeline.passes.gbuffer import seen_surface  # loads OpenGL

        job = replace(self.job, settings=quick(settings), passes=("depth", "normal", "aliasing"), measure=False)
        run(job)
        frame = run(job).frame
        seen, points = seen_surface(frame.passes["depth"], job.camera)
        facing = (frame.passes["normal"][::-1][seen] * towards_light(job.light, points)).sum(axis=1) > FACING
        return {**statistics(frame.passes["aliasing"][::-1][seen][facing]), "frame": self.number, "total_ms": frame.timing_ms["total"]}


def small_size(size: tuple[int, int]) -> tuple[int, int]:
    """The size of about `PICTURE_PIXELS` pixels with the shape of `size`; never larger."""
    scale = max(1.0, (size[0] * size[1] / PICTURE_PIXELS) ** 0.5)
    return max(round(size[0] / scale), 1), max(round(size[1] / scale), 1)


def quick(settings: Settings) -> Settings:
    """One camera sample per pixel: the data passes have no more."""
    return settings.replaced(shading={"samples": 1})


def statistics(errors: np.ndarray) -> dict[str, object]:
    """The report's `measured` keys of (Q, 3) errors."""
    return aliasing_statistics(errors[:, 0], errors[:, 1], errors[:, 2])
