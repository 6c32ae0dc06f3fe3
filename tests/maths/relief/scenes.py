"""Synthetic scenes with an exact answer: boxes and balls, cast ray by ray; captures of them; the pixels a capture has never seen."""

from dataclasses import dataclass, replace

import numpy as np

from addon.maths.relief.frame import capture_frame
from addon.maths.relief.settings import ImpostorSettings
from addon.maths.relief.warp import CaptureFrame
from addon.maths.view import Camera
from tests.maths.relief.rigs import chosen, corners, look_at


@dataclass(frozen=True)
class Solids:
    """`boxes` (n, 2, 3) corners, `balls` (m, 4) centre and radius."""

    boxes: np.ndarray
    balls: np.ndarray

    @property
    def hull(self) -> np.ndarray:
        low = np.concatenate([self.boxes[:, 0], self.balls[:, :3] - self.balls[:, 3:]])
        high = np.concatenate([self.boxes[:, 1], self.balls[:, :3] + self.balls[:, 3:]])
        return corners(low.min(axis=0), high.max(axis=0))

    def cast(self, origins: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(entry, exit) parameters (n,) of the nearest solid along `origins + t·rays`, infinite without one; the exit is its own."""
        enter, leave = self._passages(origins, rays)
        nearest, columns = enter.argmin(axis=0), np.arange(len(rays))
        entry = enter[nearest, columns]
        return entry, np.where(np.isfinite(entry), leave[nearest, columns], np.inf)

    def last(self, origins: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """Parameter (n,) at which the ray leaves the last solid, −inf without one."""
        enter, leave = self._passages(origins, rays)
        return np.where(np.isfinite(enter), leave, -np.inf).max(axis=0)

    def _passages(self, origins: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(solids, n) parameters of entry (infinite where a solid is missed) and exit."""
        enter, leave = [], []
        safe = np.where(np.abs(rays) < 1e-12, 1e-12, rays)
        for low, high in self.boxes:
            a, b = (low - origins) / safe, (high - origins) / safe
            enter.append(np.minimum(a, b).max(axis=1))
            leave.append(np.maximum(a, b).min(axis=1))
        for ball in self.balls:
            offset = origins - ball[:3]
            qa, qb, qc = (rays * rays).sum(axis=1), (offset * rays).sum(axis=1), (offset * offset).sum(axis=1) - ball[3] ** 2
            root = np.sqrt(np.maximum(qb * qb - qa * qc, 0.0))
            hit = qb * qb - qa * qc > 0.0
            enter.append(np.where(hit, (-qb - root) / qa, np.inf))
            leave.append(np.where(hit, (-qb + root) / qa, -np.inf))
        enter, leave = np.array(enter), np.array(leave)
        return np.where((enter < leave) & (enter > 0.0), enter, np.inf), np.array(leave)


def machine(rng: np.random.Generator, parts: int = 6) -> Solids:
    """A random assembly within ±1: a base plate, boxes, rods and balls in front of each other."""
    low = rng.uniform(-1, 0.6, (parts, 3))
    boxes = np.stack([low, low + rng.uniform(0.05, 0.9, (parts, 3))], axis=1)
    rod = rng.uniform(-0.9, 0.9, (parts // 2, 3))
    rods = np.stack([rod - [0.03, 0.03, 0.6], rod + [0.03, 0.03, 0.6]], axis=1)
    balls = np.column_stack([rng.uniform(-0.7, 0.7, (parts // 2, 3)), rng.uniform(0.1, 0.35, parts // 2)])
    return Solids(np.concatenate([boxes, rods]), balls)


def pixel_rays(camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(origins, rays), each (h·w, 3), through the pixel centres; a ray's parameter is the view depth."""
    columns, rows = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    ndc = np.stack([columns / size[0] * 2 - 1, 1 - rows / size[1] * 2], axis=-1).reshape(-1, 2)
    inverse = np.linalg.inv(camera.clip_from_view)
    points = []
    for depth in (-0.5, 0.5):
        clip = np.column_stack([ndc, np.full(len(ndc), depth), np.ones(len(ndc))]) @ inverse.T
        points.append(clip[:, :3] / clip[:, 3:])
    rays = points[1] - points[0]
    rays = rays / -rays[:, 2:]
    origins = points[0] + rays * points[0][:, 2:]
    return origins @ camera.view_from_world[:3, :3] + camera.eye_ws, rays @ camera.view_from_world[:3, :3]


@dataclass(frozen=True)
class Capture:
    frame: CaptureFrame
    camera: Camera
    depth: np.ndarray
    back: np.ndarray
    last: np.ndarray
    mask: np.ndarray


def capture(solids: Solids, camera: Camera, size: tuple[int, int], choice: ImpostorSettings | None = None) -> Capture:
    """What the camera captures of the solids: depth, back and last surface in metres behind the plane, mask."""
    frame = capture_frame(solids.hull, camera, size, choice or chosen())
    own = frame.camera()
    origins, rays = pixel_rays(own, (frame.width, frame.height))
    start = origins - rays * 1e3 * (not frame.is_perspective)
    entry, leave = solids.cast(start, rays)
    last = solids.last(start, rays)
    plane = (frame.source[2] * -1.0) if frame.is_perspective else 1e3
    shape = (frame.height, frame.width)
    mask = np.isfinite(entry).reshape(shape)
    return Capture(frame, camera, *((t - plane).reshape(shape) for t in (entry, leave, last)), mask)


def unseen_pixels(solids: Solids, seen: Capture, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """(h, w) bool: the pixels of `camera`'s true image whose surface point the capture does not hold.

    A point is held when a ray of the capture towards it meets nothing before it. The points are pushed a little into the solid, so that
    a wall exactly along the capture's rays, which no texel holds, does not count as held.
    """
    origins, rays = pixel_rays(camera, size)
    entry, _ = solids.cast(origins, rays)
    hit = np.isfinite(entry)
    points = origins[hit] + (entry[hit, None] + 1e-6) * rays[hit]
    own = seen.frame.camera()
    if seen.frame.is_perspective:
        towards = points - own.eye_ws
        start = np.broadcast_to(own.eye_ws, towards.shape)
    else:
        towards = np.broadcast_to(own.direction_ws, points.shape) * 100.0
        start = points - towards
    first, _ = solids.cast(np.array(start), np.array(towards))
    out = np.zeros(size[0] * size[1], bool)
    out[hit] = (1.0 - first) * np.linalg.norm(towards, axis=1) > 1e-4
    return out.reshape(size[1], size[0])


def orbit(target, distance: float, angle: float, elevation: float = 0.2, zoom: float = 1.0) -> Camera:
    """A camera on a circle round the vertical, looking at its middle, with its focal length times `zoom`."""
    flat = np.array([np.sin(angle), -np.cos(angle), 0.0]) * np.cos(elevation)
    camera = look_at(np.asarray(target) + distance * (flat + [0.0, 0.0, np.sin(elevation)]), target)
    return replace(camera, clip_from_view=np.diag([zoom, zoom, 1.0, 1.0]) @ camera.clip_from_view)
