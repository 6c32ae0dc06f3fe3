"""Surfaces close behind one another, and which of them float64 rays meet first. numpy only; metres.

Two plates are *apart* where their depths along a ray differ by more than `APART` of the distance: there the nearer one must show.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from addon.maths import spaces
from addon.maths.view import Camera
from addon.scene.records import Instances, Mesh, Scene

SIZE = (320, 180)
ASPECT = SIZE[0] / SIZE[1]
APART = 1e-6
SENSOR_MM = 36.0

Placed = tuple[np.ndarray, np.ndarray]  # corners (4, 3) of a quad in object space, world_from_object (4, 4)


@dataclass(frozen=True)
class PlateCase:
    """A scene of quads, an object each, and a camera, relative to a local origin near the scene's middle as a snapshot has it."""

    name: str
    scene: Scene
    camera: Camera

    @cached_property
    def hits(self) -> np.ndarray:
        """(objects, h, w) float64 view depth at which the ray through a pixel's centre meets each object; inf where it does not, or where
        the camera's clip leaves it out."""
        start, along = (a.reshape(-1, 3) for a in view_rays(self.camera, SIZE))
        depth = [_met(start, along, corners) for corners in self._corners_vs()]
        shown = [np.where((d >= self.camera.near) & (d <= self.camera.far), d, np.inf) for d in depth]
        return np.stack(shown).reshape(-1, SIZE[1], SIZE[0])

    @property
    def nearest(self) -> np.ndarray:
        """(h, w) the object that shows; −1 where none does."""
        return np.where(np.isfinite(self.hits).any(axis=0), self.hits.argmin(axis=0), -1)

    @property
    def are_apart(self) -> np.ndarray:
        """(h, w) bool: where the nearest is known: what lies behind it, if anything, lies more than `APART` behind it."""
        first, second = np.sort(self.hits, axis=0)[:2]
        first = np.where(np.isfinite(first), first, 0.0)
        return ~(second - first <= APART * np.abs(first))

    def wrong_share(self, objects: np.ndarray) -> float:
        """Of the pixels that show something in either, the share that show another object than they must; `objects` (h, w), −1 nothing."""
        seen = ((objects >= 0) | (self.nearest >= 0)) & self.are_apart
        return float((objects != self.nearest)[seen].mean()) if seen.any() else 0.0

    def _corners_vs(self) -> list[np.ndarray]:
        """Per object the corners (T, 3, 3) of its triangles in view space, float64."""
        placed = zip(self.scene.instances.mesh_index, self.scene.instances.world_from_object, strict=True)
        return [
            spaces.transform(self.camera.view_from_world @ m, self.scene.meshes[i].positions[self.scene.meshes[i].triangles])[..., :3]
            for i, m in placed
        ]


def view_rays(camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 3) view-space points at view depth 0, and (h, w, 3) the rays per metre of view depth, through the pixel centres."""
    p = camera.clip_from_view
    x, y = np.meshgrid((np.arange(size[0]) + 0.5) * 2.0 / size[0] - 1.0, 1.0 - (np.arange(size[1]) + 0.5) * 2.0 / size[1])
    if camera.is_orthographic:
        start = np.stack([(x - p[0, 3]) / p[0, 0], (y - p[1, 3]) / p[1, 1], np.zeros_like(x)], axis=-1)
        return start, np.broadcast_to([0.0, 0.0, -1.0], start.shape)
    along = np.stack([(x + p[0, 2]) / p[0, 0], (y + p[1, 2]) / p[1, 1], -np.ones_like(x)], axis=-1)
    return np.zeros_like(along), along


def _met(start: np.ndarray, along: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(R,) the smallest s at which start + s·along meets one of the triangles (T, 3, 3); inf where none."""
    best = np.full(len(start), np.inf)
    for a, b, c in triangles:
        normal = np.cross(b - a, c - a)
        slope = along @ normal
        steep = np.abs(slope) > 1e-13 * np.linalg.norm(normal)
        s = np.where(steep, (a - start) @ normal / np.where(steep, slope, 1.0), np.inf)
        point = start + np.where(steep, s, 0.0)[:, None] * along
        inside = steep & np.all([np.cross(q - p, point - p) @ normal >= 0.0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
        best = np.where(inside & (s < best), s, best)
    return best


def square(half: float) -> np.ndarray:
    """(4, 3) corners of a square about the origin, facing up."""
    return half * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])


def case_of(name: str, placed: list[Placed], camera: Camera) -> PlateCase:
    """The quads, an object each, seen by a camera; all given in one world, whose origin may lie anywhere."""
    matrices = np.stack([matrix for _, matrix in placed])
    corners = np.concatenate([spaces.transform(m, quad)[:, :3] for quad, m in placed])
    side = 2.0 ** np.ceil(np.log2(np.ptp(corners, axis=0).max()))
    origin = np.round((corners.min(axis=0) + corners.max(axis=0)) / 2.0 / side) * side
    matrices[:, :3, 3] -= origin
    meshes = [
        Mesh((name, i, quad.tobytes()), quad, np.tile([0.0, 0.0, 1.0], (4, 1)), [[0, 1, 2], [0, 2, 3]])
        for i, (quad, _) in enumerate(placed)
    ]
    count = np.arange(len(placed))
    instances = Instances(count, matrices, count, np.zeros(len(placed)), np.tile([0.6, 0.6, 0.6, 1.0], (len(placed), 1)))
    view = camera.view_from_world @ spaces.translation(origin)
    moved = Camera(view, camera.clip_from_view, camera.near, camera.far)
    return PlateCase(name, Scene(tuple(meshes), instances, tuple(f"plate {i}" for i in count), origin), moved)


def lens(mm: float, near: float, far: float) -> np.ndarray:
    """Clip from view of a lens before a sensor as wide as the picture."""
    return spaces.perspective(float(np.arctan(SENSOR_MM / 2.0 / mm / ASPECT)), ASPECT, near, far)


def pair(
    distance: float,
    gap: float,
    near: float,
    far: float,
    mm: float | None = 50.0,
    half: float = 0.2,
    towards_eye: tuple[float, float, float] = (0.6, -0.6, 0.5),
) -> PlateCase:
    """Two level plates, `gap` apart, seen from above at a distance through a lens, or in parallel (None) half as wide as the distance."""
    camera = Camera(
        spaces.look_at(distance * np.array(towards_eye), (0.0, 0.0, 0.0)),
        lens(mm, near, far) if mm else spaces.orthographic(0.25 * distance / ASPECT, ASPECT, near, far),
        near,
        far,
    )
    quad = square(half * distance)
    name = f"{'lens' if mm else 'parallel'}, {gap * 1e3:g} mm at {distance:g} m, clip {near:g}–{far:g}"
    return case_of(name, [(quad, np.eye(4)), (quad, spaces.translation((0.0, 0.0, gap)))], camera)


def long_lens() -> PlateCase:
    """A cube of 2 m on a ground of 40 m, 640 m away, through 2000 mm; its foot lies in the ground."""
    camera = Camera(spaces.look_at((400.0, -400.0, 300.0), (0.0, 0.0, 1.0)), lens(2000.0, 0.1, 2000.0), 0.1, 2000.0)
    sides = [
        spaces.rotation((0.0, 0.0, 1.0), turn) @ spaces.translation((0.0, -1.0, 1.0)) @ spaces.rotation((1.0, 0.0, 0.0), np.pi / 2)
        for turn in np.arange(4) * np.pi / 2
    ]
    faces = [*sides, spaces.translation((0.0, 0.0, 2.0))]
    placed = [(square(20.0), np.eye(4)), *((square(1.0), m) for m in faces)]
    return case_of("2000 mm lens, a cube 640 m away, clip 0.1–2000", placed, camera)


def named() -> Iterator[PlateCase]:
    """The cases in which the hidden one of two surfaces was seen to show."""
    yield pair(50.0, 0.001, 0.01, 1000.0)
    yield pair(50.0, 0.005, 0.01, 1000.0)
    yield pair(1000.0, 0.1, 0.1, 20000.0)
    yield pair(1000.0, 0.1, 0.001, 1e6)
    yield pair(10.0, 0.001, 0.1, 1e5, None)
    yield pair(10.0, 0.001, 0.1, 1e6, None)
    yield pair(40.0, 0.001, 1e-6, 1000.0)
    yield long_lens()


def drawn(seed: int, *, largest: float = 0.7) -> PlateCase:
    """Two plates and a crumb beside them at random: distance 0.1 m … 10 km, gap from 1.2e-6 of it, tilt to 75°, lens 10 to 2000 mm or
    parallel, far/near 1e2 … 1e8, off the origin by up to three distances; half sides 0.5 … 10^`largest` times the picture's (3.7: a
    plate of 10 m may be 50 km of ground)."""
    rng = np.random.default_rng(seed)
    distance, is_parallel = 10.0 ** rng.uniform(-1.0, 4.0), rng.random() < 0.4
    forward, centre = _unit(rng.normal(size=3)), _unit(rng.normal(size=3)) * 10.0 ** rng.uniform(-2.0, 0.5)
    view = spaces.look_at(distance * (centre - forward), distance * centre, rng.normal(size=3))
    mm = 10.0 ** rng.uniform(1.0, 3.3)
    half = SENSOR_MM / 2.0 / mm / ASPECT * distance
    ratio = 10.0 ** rng.uniform(2.0, 8.0)
    near = distance * 10.0 ** rng.uniform(-np.log10(ratio) + 0.05, -0.05)
    far = max(near * ratio, 1.5 * distance)
    clip = spaces.orthographic(half, ASPECT, near, far) if is_parallel else lens(mm, near, far)
    tilt = np.radians(rng.uniform(0.0, 75.0))
    aside = _unit(np.cross(forward, rng.normal(size=3)))
    normal = np.cross(aside, forward) * np.sin(tilt) - forward * np.cos(tilt)
    gap = distance * 10.0 ** rng.uniform(np.log10(1.2e-6), -3.0)
    placed = []
    for height in (0.0, gap):
        frame = np.eye(4)
        frame[:3, 0] = _unit(np.cross(normal, rng.normal(size=3)))
        frame[:3, 1], frame[:3, 2] = np.cross(normal, frame[:3, 0]), normal
        frame[:3, 3] = distance * centre + height * normal + frame[:3, :2] @ rng.normal(size=2) * 0.3 * half
        placed.append((square(half * 10.0 ** rng.uniform(-0.3, largest)), frame))
    crumb = spaces.translation(3.0 * distance * rng.normal(size=3))
    camera = Camera(view, clip, near, far)
    kind = "parallel" if is_parallel else f"{mm:.0f} mm"
    name = f"{seed}: {kind}, {gap / distance:.0e} of {distance:.3g} m, far/near {far / near:.0e}, tilt {np.degrees(tilt):.0f}°"
    return case_of(name, [*placed, (square(1e-3 * distance), crumb)], camera)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)
