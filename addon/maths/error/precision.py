"""What float32 loses in a shadow map, in texels: how far the places that the picture compares may be off where they are looked up.

Four causes, each in metres at a receiver and over the longer side of its texel there: the map's depth format, the coordinates on the GPU
(vertices relative to the local origin), the projection (places relative to the plan's own origin), and the largest caster's triangle, of
which the rasteriser keeps 2⁻²³ of its size. Below a texel the tests' biases cover it; above, it is acne or a shadow out of place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..shadow import cut
from ..shadow.lookup import project, texel_footprint, towards_light
from ..shadow.projection import ShadowPlan, ShadowProjection
from ..view import Camera, Light
from .measure import pixel_gradients

HALF_STEP, STEP = 2.0**-24, 2.0**-23
CAUSES = ("depth", "coordinates", "projection", "triangle")
SEEN_TEXELS, SEEN_PX = 1.0, 0.5
WORDS = {
    "depth": "the map's depth range is too long for its texels",
    "coordinates": "the scene's coordinates are too large for what the camera sees",
    "projection": "the map lies too far from the point its coordinates are counted from",
    "triangle": "a caster is far larger than the map",
}


@dataclass(frozen=True, slots=True)
class Loss:
    """The worst place: `ratio` texels (None where no map was asked), `pixels` of the picture, in map `index`, at `view_depth` metres."""

    ratio: float | None = None
    pixels: float = 0.0
    cause: str = ""
    index: int = -1
    view_depth: float = 0.0

    def as_dict(self) -> dict[str, object]:
        """The report's `measured.precision`."""
        if self.ratio is None:
            return {"worst_ratio": None, "where": None}
        where = {"map": self.index, "view_depth": self.view_depth, "cause": self.cause, "pixels": self.pixels}
        return {"worst_ratio": self.ratio, "where": where}

    @property
    def warning(self) -> str | None:
        """One line where the loss could be seen: more than a texel, and, where biases grow with it, more than half a pixel."""
        is_covered = self.cause in ("depth", "coordinates") and self.pixels <= SEEN_PX
        if self.ratio is None or self.ratio <= SEEN_TEXELS or is_covered:
            return None
        return (
            f"Shadows may be wrong by {self.ratio:.1f} texels {self.view_depth:.3g} m from the camera (map {self.index + 1}): "
            f"{WORDS[self.cause]}. Split what is huge, or bring the parts nearer to each other."
        )


def precision_loss(
    plan: ShadowPlan,
    camera: Camera,
    light: Light,
    points_ws: np.ndarray,
    index: np.ndarray,
    map_size: int,
    image_size: tuple[int, int],
    longest_edge_m: float,
) -> Loss:
    """The worst loss over receivers `points_ws` (P, 3), each asked in map `index` (P,); −1 where none was.

    `longest_edge_m` of all casters, those included that are cut to the map.
    """
    worst = Loss()
    for i, projection in enumerate(plan.projections):
        own = points_ws[index == i]
        if not len(own) or projection.is_empty:
            continue
        loss_m = np.stack(
            [
                depth_step_m(projection, light, own),
                HALF_STEP * np.abs(own).max(axis=1),
                *_projected(projection, light, own, plan.origin_ws, longest_edge_m),
            ]
        )
        footprint = np.linalg.norm(texel_footprint(projection, own, light, map_size), axis=-1).max(axis=-1)
        cause, place = np.unravel_index(np.argmax(loss_m / footprint), loss_m.shape)
        ratio = float(loss_m[cause, place] / footprint[place])
        if worst.ratio is None or ratio > worst.ratio:
            at = own[place : place + 1]
            per_metre = max(float(np.linalg.norm(gradient)) for gradient in pixel_gradients(camera, at, image_size))
            depth = float((at[0] - camera.eye_ws) @ camera.direction_ws)
            worst = Loss(ratio, float(loss_m[cause, place]) * per_metre, CAUSES[cause], i, depth)
    return worst


def depth_step_m(projection: ShadowProjection, light: Light, points_ws: np.ndarray) -> np.ndarray:
    """(P,) metres along the light's ray that a step of the 32-bit depth near 1 stands for at the points: 2⁻²³ / |∂depth/∂m|."""
    ray = towards_light(light, points_ws)
    matrix, (_, _, depth, w) = projection.clip_from_world, project(projection, points_ws)
    along, divisor = (ray * matrix[2, :3]).sum(axis=-1), (ray * matrix[3, :3]).sum(axis=-1)
    rate = along if projection.log is not None else (along - depth * divisor) / w
    return STEP / np.maximum(np.abs(rate), 1e-300)


def _projected(
    projection: ShadowProjection, light: Light, points_ws: np.ndarray, origin_ws: np.ndarray, longest_edge_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """(P,) twice: what the product with the map's matrix, and the rasteriser's clipping of the largest triangle, lose in metres."""
    w = project(projection, points_ws)[3]
    half_map_m = 0.5 * np.linalg.norm(texel_footprint(projection, points_ws, light, 1), axis=-1).max(axis=-1)
    product = HALF_STEP * cut.units_per_metre(projection) * np.linalg.norm(points_ws - origin_ws, axis=1) / w
    return product * half_map_m, STEP * min(cut.reach(projection, longest_edge_m), cut.LARGE) * half_map_m
