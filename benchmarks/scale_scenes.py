"""Random scenes of a small part on a ground of any size, and their exact truth: float64 rays against a plane and boxes, no meshes.

The part is a heap of boxes; the ground is a plane, level or tilted (one quad, a grid or tiles). Everything is drawn from the scene's number
alone. What Blender would round (an object's place to float32) is rounded here too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, tan

import numpy as np

from addon.maths import spaces
from addon.maths.view import Camera, Light
from addon.scene.records import Instances, Mesh, Scene
from addon.studies.truth.tracer import LEAST_FACING, Truth, camera_rays, directions_to_light, pixel_centres

GROUNDS = ("quad", "grid", "tiles")
VIEWS = ("perspective", "low", "orthographic", "long")
LIGHTS = ("sun", "sun", "sun", "spot", "point")
UTM = np.array([448_262.0, 5_411_932.0, 112.0])
BOXES, GRID, TILES = 25, 32, 16
SIZE = (320, 180)


@dataclass(frozen=True, eq=False)
class Heap:
    """The exact scene: a square of half side `reach` in the plane z = 0 of `ground` (4, 4), a rigid placing, and B boxes ±1 as `placed`
    (B, 4, 4) puts them into the world."""

    ground: np.ndarray
    reach: float
    placed: np.ndarray

    def nearest(self, origins: np.ndarray, directions: np.ndarray, limits: np.ndarray, skip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The first surface along K rays: 0 the ground, 1 + b a box, −1 none; `skip` (K,) is not hit. Distances (K,)."""
        best, found = np.asarray(limits, np.float64).copy(), np.full(len(origins), -1)
        with np.errstate(divide="ignore", invalid="ignore"):
            o, d = (origins - self.ground[:3, 3]) @ self.ground[:3, :3], directions @ self.ground[:3, :3]
            t = -o[:, 2] / d[:, 2]
            hit = (t > 0.0) & (t < best) & (np.abs(o[:, :2] + d[:, :2] * t[:, None]) <= self.reach).all(axis=1) & (skip != 0)
            best[hit], found[hit] = t[hit], 0
            for b, inverse in enumerate(np.linalg.inv(self.placed)):
                o, d = origins @ inverse[:3, :3].T + inverse[:3, 3], directions @ inverse[:3, :3].T
                lower, upper = (-1.0 - o) / d, (1.0 - o) / d
                enter, leave = np.minimum(lower, upper).max(axis=1), np.maximum(lower, upper).min(axis=1)
                hit = (enter < leave) & (leave > 0.0) & (np.maximum(enter, 0.0) < best) & (skip != b + 1)
                best[hit], found[hit] = np.maximum(enter, 0.0)[hit], b + 1
        return found, best

    def normals(self, found: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(K, 3) outward unit normals of the surfaces hit."""
        out = np.tile(self.ground[:3, 2], (len(points), 1))
        for b, matrix in enumerate(self.placed):
            rows = found == b + 1
            inverse = np.linalg.inv(matrix)
            local = points[rows] @ inverse[:3, :3].T + inverse[:3, 3]
            axis = np.abs(local).argmax(axis=1)
            normal = np.sign(np.take_along_axis(local, axis[:, None], axis=1)) * inverse[axis, :3]
            out[rows] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        return out

    def truth(self, camera: Camera, light: Light, size: tuple[int, int]) -> Truth:
        """What every pixel centre sees, and whether the light reaches it."""
        origins, directions, lengths = camera_rays(camera, size, pixel_centres(size))
        found, distance = self.nearest(origins, directions, lengths, np.full(len(origins), -1))
        seen = found >= 0
        points = np.where(seen[:, None], origins + directions * np.where(seen, distance, 0.0)[:, None], 0.0)
        up = self.ground[:3, 2]
        points[found == 0] -= np.outer((points[found == 0] - self.ground[:3, 3]) @ up, up)
        normal = np.where(seen[:, None], self.normals(found, points), 0.0)
        normal = np.where((np.einsum("ij,ij->i", normal, directions) > 0.0)[:, None], -normal, normal)
        to_light, away, in_cone = directions_to_light(light, points)
        facing = np.einsum("ij,ij->i", normal, to_light)
        lit_facing = seen & in_cone & (facing > LEAST_FACING)
        lit = lit_facing.copy()
        reach = np.minimum(away[lit_facing], 1e9)
        lit[lit_facing] = self.nearest(points[lit_facing], to_light[lit_facing], reach, found[lit_facing])[0] < 0
        depth = np.where(seen, (points - camera.eye_ws) @ camera.direction_ws, np.inf)
        rows = Truth(depth, found.astype(np.int32), found.astype(np.int64), points, normal, facing, lit_facing, lit)
        return rows.reshaped((size[1], size[0]))


@dataclass(frozen=True, eq=False)
class ScaleScene:
    """One random case: what is drawn, what is true, and the words for the table."""

    number: int
    words: dict[str, object]
    scene: Scene
    heap: Heap
    camera: Camera
    light: Light


def scale_scene(number: int) -> ScaleScene:
    """The case of that number. Kinds of ground, light and view take turns; the ratio of ground to part covers 1 … 100,000 evenly."""
    rng = np.random.default_rng([number, 2026])
    ground, view, light_kind = GROUNDS[number % 3], VIEWS[number // 3 % 4], LIGHTS[number // 12 % 5]
    ratio = 10.0 ** (5.0 * ((number * 0.6180339887) % 1.0))
    part = 10.0 ** rng.uniform(-1.0, 1.0)
    side = part * ratio
    is_off, is_utm = number // 2 % 2 == 1, number % 5 == 0
    place = rng.uniform(-0.4, 0.4, 2) * side if is_off else np.zeros(2)
    world = UTM if is_utm else np.zeros(3)
    at = (world + [*place, 0.0]).astype(np.float32).astype(np.float64)
    middle = world.astype(np.float32).astype(np.float64)
    origin = np.round(middle)
    tilt = radians(rng.uniform(0.0, 25.0)) if number % 2 else 0.0
    around = rng.uniform(0.0, 2.0 * pi)
    turned = spaces.rotation((cos(around), sin(around), 0.0), tilt, at - origin)  # the whole world
    scene, heap = _scene(rng, ground, part, side, at - origin, middle - origin, origin, turned)
    camera = _camera(rng, view, part, side, at - origin)
    camera = replace(camera, view_from_world=camera.view_from_world @ np.linalg.inv(turned))
    light = _light(rng, light_kind, part, at - origin, turned)
    words = {"ground": ground, "view": view, "light": light_kind, "ratio": ratio, "part": part, "off": is_off, "utm": is_utm, "tilt": tilt}
    return ScaleScene(number, words, scene, heap, camera, light)


def _scene(
    rng: np.random.Generator,
    ground: str,
    part: float,
    side: float,
    at: np.ndarray,
    middle: np.ndarray,
    origin: np.ndarray,
    turned: np.ndarray,
) -> tuple[Scene, Heap]:
    boxes = np.stack([turned @ _box(rng, part, at) for _ in range(BOXES)])
    placed = turned @ spaces.translation(middle)
    count = TILES if ground == "tiles" else 1
    step = (np.arange(count) - 0.5 * (count - 1)) * side / count
    tiles = np.tile(np.diag([0.5 * side / count] * 2 + [1.0, 1.0]), (count * count, 1, 1))
    tiles[:, :2, 3] = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
    meshes = _plane(GRID if ground == "grid" else 1), _cube()
    matrices = np.concatenate([placed @ tiles, boxes])
    index = np.repeat([0, 1], [len(tiles), BOXES])
    ids = np.concatenate([np.zeros(len(tiles)), np.arange(1, BOXES + 1)])
    instances = Instances(index, matrices, ids, np.zeros(len(index)), np.full((len(index), 4), 0.8))
    names = ("ground", *(f"box {b}" for b in range(BOXES)))
    return Scene(meshes, instances, names, origin), Heap(placed, 0.5 * side, boxes)


def _box(rng: np.random.Generator, part: float, at: np.ndarray) -> np.ndarray:
    """(4, 4) of the unit cube ±1: a block of 0.1 to 0.4 of half the part's size, turned."""
    turned = (
        spaces.rotation((0, 0, 1), rng.uniform(0, pi))
        @ spaces.rotation((0, 1, 0), rng.uniform(0, 0.6))
        @ spaces.rotation((1, 0, 0), rng.uniform(0, 0.6))
    )
    out = turned @ np.diag([*(0.5 * part * rng.uniform(0.04, 0.2, 3)), 1.0])
    out[:3, 3] = at + 0.5 * part * rng.uniform((-1.0, -1.0, 0.05), (1.0, 1.0, 0.8))
    return out


def _camera(rng: np.random.Generator, view: str, part: float, side: float, at: np.ndarray) -> Camera:
    azimuth, elevation = rng.uniform(0.0, 2.0 * pi), radians(rng.uniform(2.0, 8.0) if view == "low" else rng.uniform(12.0, 75.0))
    distance = part * {"long": 120.0, "low": 1.2}.get(view, rng.uniform(1.2, 3.0))
    eye = at + distance * np.array([cos(azimuth) * cos(elevation), sin(azimuth) * cos(elevation), sin(elevation)])
    aspect, far = SIZE[0] / SIZE[1], 4.0 * distance + (side if view == "low" else 60.0 * part)
    near = 0.02 * distance
    looking = spaces.look_at(eye, at + [0.0, 0.0, 0.15 * part])
    if view == "orthographic":
        return Camera(looking, spaces.orthographic(0.6 * part, aspect, near, far), near, far)
    half = 0.55 * part / distance if view == "long" else tan(radians(rng.uniform(15.0, 27.0)))
    return Camera(looking, spaces.perspective(np.arctan(half), aspect, near, far), near, far)


def _light(rng: np.random.Generator, kind: str, part: float, at: np.ndarray, turned: np.ndarray) -> Light:
    azimuth, elevation = rng.uniform(0.0, 2.0 * pi), radians(rng.uniform(2.0, 88.0) if kind == "sun" else rng.uniform(20.0, 80.0))
    towards = turned[:3, :3] @ [cos(azimuth) * cos(elevation), sin(azimuth) * cos(elevation), sin(elevation)]
    if kind == "sun":
        return Light("sun", towards)
    position = at + towards * part * rng.uniform(1.5, 8.0)
    return Light(kind, towards if kind == "spot" else None, position, cone_rad=radians(rng.uniform(20.0, 50.0)))


def _plane(count: int) -> Mesh:
    """The square ±1 in count × count quads, facing up."""
    line = np.linspace(-1.0, 1.0, count + 1)
    x, y = np.meshgrid(line, line)
    positions = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=-1)
    i = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    a, b, c, d = i, i + 1, i + count + 2, i + count + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])
    return Mesh(("plane", count), positions, np.tile([0.0, 0.0, 1.0], (len(positions), 1)), triangles)


def _cube() -> Mesh:
    """The cube ±1, flat shaded, wound outwards."""
    positions, normals, triangles = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = np.eye(3)[axis] * sign
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3] * sign
            first = len(positions)
            positions += [normal - u - v, normal + u - v, normal + u + v, normal - u + v]
            normals += [normal] * 4
            triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return Mesh("cube", np.array(positions), np.array(normals), np.array(triangles))
