"""Primary and shadow rays through pixel centres: is the visible surface point lit by the hard light?

The ray tracers are float32, about a point near what is seen, and the triangles that are large for that are met in float64: the corners of
a huge ground are rounded by millimetres. Points of surfaces lie in the triangles' planes, in float64.

A surface does not shadow itself: surfaces within `SAME_SURFACE` of the eye's distance are one (the own triangle, its neighbours in the
plane, coincident duplicates, back-to-back doubled faces). Whether the sheet's own back stands between the point and the light is not asked
of rays but of the geometric normal: the side turned to the viewer must face the light.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...maths.domains import require_choice
from ...maths.view import Camera, Light
from ...scene.looks import HIDDEN, NO_SHADOW
from ...scene.records import Scene
from .backends import BACKENDS, Backend, ExactForLarge
from .triangles import FLOAT32_EPSILON, WorldTriangles, world_triangles

MOST_HITS_ON_ITSELF = 16
SAME_SURFACE = 4.0 * FLOAT32_EPSILON
"""Of the distance from the eye, or of the width of a parallel view."""
LEAST_FACING = 1e-6  # below, float32 cannot tell which side of a face the light is on (walls under a light from the zenith)


@dataclass(frozen=True, eq=False)
class Truth:
    """What the rays found; arrays of one shape S: (h, w) row 0 at the top for a picture, (K,) for single points.

    `depth` view depth in metres, inf = nothing; `object` int32, −1 = nothing; `triangle` int64, row of `world_triangles`, −1 = nothing;
    `point_ws`, `normal_ws` (S, 3) float64, exact in the triangle's plane, normal turned to the viewer (zeros where nothing);
    `facing` cosine between that normal and the light's direction; `lit_facing` facing > `LEAST_FACING` and within the light's cone;
    `lit` lit-facing with nothing between the point and the light.
    """

    depth: np.ndarray
    object: np.ndarray
    triangle: np.ndarray
    point_ws: np.ndarray
    normal_ws: np.ndarray
    facing: np.ndarray
    lit_facing: np.ndarray
    lit: np.ndarray

    def reshaped(self, shape: tuple[int, ...]) -> Truth:
        """The same values in another shape S."""
        lead = self.depth.ndim
        return Truth(**{name: array.reshape(*shape, *array.shape[lead:]) for name, array in vars(self).items()})

    def at(self, where: np.ndarray | tuple[np.ndarray, ...]) -> Truth:
        """The values at an index of S: a mask, or arrays of rows and columns."""
        return Truth(**{name: array[where] for name, array in vars(self).items()})


def pixel_centres(size: tuple[int, int]) -> np.ndarray:
    """(h·w, 2) pixel coordinates x, y of all centres (half integers, y downwards), row by row from the top."""
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    return np.stack([x.ravel(), y.ravel()], axis=-1)


def camera_rays(camera: Camera, size: tuple[int, int], pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays from the near to the far plane through K pixel coordinates: origins (K, 3), unit directions (K, 3), lengths (K,); float64."""
    ndc = np.stack([2.0 * pixels[:, 0] / size[0] - 1.0, 1.0 - 2.0 * pixels[:, 1] / size[1]], axis=-1)
    world_from_clip = np.linalg.inv(camera.clip_from_world)
    middle = ndc @ world_from_clip[:, :2].T + world_from_clip[:, 3]
    near, far = middle - world_from_clip[:, 2], middle + world_from_clip[:, 2]
    origins = near[:, :3] / near[:, 3:]
    span = far[:, :3] / far[:, 3:] - origins
    length = np.sqrt(np.einsum("ij,ij->i", span, span))
    return origins, span / length[:, None], length


def directions_to_light(light: Light, points_ws: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From K points towards the light: unit directions (K, 3), distances (K,) (inf for a sun), and whether the point is in the cone."""
    if light.kind == "sun":
        return np.broadcast_to(light.direction_ws, points_ws.shape), np.full(len(points_ws), np.inf), np.ones(len(points_ws), dtype=bool)
    offset = np.asarray(light.position_ws, dtype=np.float64) - points_ws
    distance = np.maximum(np.linalg.norm(offset, axis=1), np.finfo(np.float64).tiny)
    direction = offset / distance[:, None]
    return direction, distance, light.lights_towards(direction)


class TruthTracer:
    """Traces one frozen scene; built once (seconds per million triangles), asked for any number of views and lights."""

    def __init__(
        self, scene: Scene, backend: str = "blender", go_on: Callable[[], None] = lambda: None, anchor_ws: np.ndarray | None = None
    ) -> None:
        """`go_on` is called again and again while it works; what it raises ends the work. `anchor_ws` (3,): see `world_triangles`."""
        require_choice("Ray tracer", backend, tuple(BACKENDS))
        self.triangles: WorldTriangles = world_triangles(scene, anchor_ws)
        self.is_hidden, self.casts_none = ((self.triangles.flags & flag) != 0 for flag in (HIDDEN, NO_SHADOW))
        large = self.triangles.large() if anchor_ws is not None else np.zeros(0, np.int64)
        self._backend: Backend = ExactForLarge(self.triangles.corners - self.triangles.anchor_ws, large, BACKENDS[backend], go_on)

    def trace(self, camera: Camera, light: Light, size: tuple[int, int]) -> Truth:
        """The truth at every pixel centre of a picture of `size` (width, height)."""
        return self.sample(camera, light, size, pixel_centres(size)).reshaped((size[1], size[0]))

    def sample(self, camera: Camera, light: Light, size: tuple[int, int], pixels: np.ndarray) -> Truth:
        """The truth at K pixel coordinates (K, 2) of that picture, not necessarily centres."""
        origins, directions, lengths = camera_rays(camera, size, pixels)
        triangle, distance = self._seen(camera, origins, directions, lengths)
        seen = triangle >= 0
        point, normal = np.zeros((len(pixels), 3)), np.zeros((len(pixels), 3))
        point[seen], normal[seen] = self._surface(origins[seen], directions[seen], triangle[seen], distance[seen])
        to_light, light_distance, in_cone = directions_to_light(light, point)
        facing = np.einsum("ij,ij->i", normal, to_light)
        lit_facing = seen & in_cone & (facing > LEAST_FACING)
        lit = lit_facing.copy()
        noise = SAME_SURFACE * _scale_m(camera, point)[lit_facing]
        lit[lit_facing] = ~self._blocked(point[lit_facing], normal[lit_facing], noise, to_light[lit_facing], light_distance[lit_facing])
        depth = np.where(seen, (point - camera.eye_ws) @ camera.direction_ws, np.inf)
        object_id = np.full(len(pixels), -1, dtype=np.int32)
        object_id[seen] = self.triangles.object_id[triangle[seen]]
        return Truth(depth, object_id, triangle, point, normal, facing, lit_facing, lit)

    def reached(self, points_ws: np.ndarray, normals_ws: np.ndarray, towards_ws: np.ndarray, noise_m: float) -> np.ndarray:
        """(P,) whether light from the unit direction (3,) reaches places (P, 3) on surfaces, on the side of their unit normals (P, 3);
        `noise_m` metres are no distance."""
        reached = normals_ws @ towards_ws > LEAST_FACING
        count = int(reached.sum())
        light = np.broadcast_to(towards_ws, (count, 3)), np.full(count, np.inf)
        reached[reached] = ~self._blocked(points_ws[reached], normals_ws[reached], np.full(count, noise_m), *light)
        return reached

    def _nearest(self, origins: np.ndarray, directions: np.ndarray, limits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The first triangle on each ray as far as float32 can tell (−1: none), and its distance."""
        return self._backend.nearest(origins - self.triangles.anchor_ws, directions, limits)

    def _seen(self, camera: Camera, origins: np.ndarray, directions: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The first triangle on each ray that the camera may see (−1: none), and its distance."""
        triangle, distance = self._nearest(origins, directions, lengths)
        reached = np.where(triangle >= 0, distance, 0.0)
        noise = SAME_SURFACE * _scale_m(camera, origins + directions * reached[:, None])
        going = np.flatnonzero((triangle >= 0) & self.is_hidden[triangle])
        while len(going):
            start = distance[going] + noise[going]
            left = np.maximum(lengths[going] - start, 0.0)
            triangle[going], further = self._nearest(origins[going] + directions[going] * start[:, None], directions[going], left)
            distance[going] = start + further
            going = going[(triangle[going] >= 0) & self.is_hidden[triangle[going]] & (left > 0.0)]
        seen = triangle >= 0
        distance[seen] = self.triangles.distance_to_plane(triangle[seen], origins[seen], directions[seen], distance[seen])
        return triangle, distance

    def _surface(
        self, origins: np.ndarray, directions: np.ndarray, triangle: np.ndarray, distance: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Points in the planes of the triangles hit, and normals turned to the viewer."""
        normal = self.triangles.normal[triangle]
        slope = np.einsum("ij,ij->i", normal, directions)
        return origins + directions * distance[:, None], np.where(slope[:, None] > 0.0, -normal, normal)

    def _blocked(
        self, point: np.ndarray, normal: np.ndarray, noise: np.ndarray, to_light: np.ndarray, light_distance: np.ndarray
    ) -> np.ndarray:
        """Whether something other than the surface itself lies between the points and the light. `noise` (K,) metres are no distance.

        A hit whose plane passes within the noise of the point is the surface itself, one whose plane lies behind the point is not on the
        ray: rounding has moved it there. The ray goes on behind it.
        """
        limits = np.minimum(np.maximum(light_distance - noise, 0.0), 2.0 * self.triangles.reach)
        blocked, going = np.zeros(len(point), dtype=bool), np.arange(len(point))
        starts, travelled = point + normal * noise[:, None], np.zeros(len(point))
        for _ in range(MOST_HITS_ON_ITSELF):
            origins = starts[going] + to_light[going] * travelled[going, None]
            hit, distance = self._nearest(origins, to_light[going], limits[going] - travelled[going])
            hit_any = hit >= 0
            going, hit, distance = going[hit_any], hit[hit_any], distance[hit_any]
            height = np.einsum("ij,ij->i", point[going] - self.triangles.corners[hit, 0], self.triangles.normal[hit])
            travelled[going] += distance
            exact = self.triangles.distance_to_plane(hit, point[going], to_light[going], travelled[going])
            is_none = (np.abs(height) <= noise[going]) | (exact < 0.0) | self.casts_none[hit]
            blocked[going[~is_none]] = True
            going = going[is_none]
            travelled[going] += noise[going] + SAME_SURFACE * travelled[going]
            going = going[travelled[going] < limits[going]]
            if not len(going):
                break
        return blocked


def _scale_m(camera: Camera, points_ws: np.ndarray) -> np.ndarray:
    """(K,) metres that `SAME_SURFACE` is of: the distance from the eye, of a parallel view the width of the picture."""
    if camera.is_orthographic:
        return np.full(len(points_ws), 2.0 / float(np.abs(np.diag(camera.clip_from_view)[:2]).min()))
    return np.linalg.norm(points_ws - camera.eye_ws, axis=1)
