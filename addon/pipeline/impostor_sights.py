"""What the camera makes of every impostor of a frame, for `maths/relief_life.py` to decide on. Worker thread only.

All textures are predicted at once; what is kept of them is stacked again only when one of them changes. The costs for the break-even are
measured: an object's triangles once, when first seen, an impostor's pixels whenever one is captured.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import SceneError
from ..maths.relief import CaptureFrame
from ..maths.relief_beta import BoundsSet, betas_of_set, bounds_set
from ..maths.relief_error import ReliefSet, predict, relief_set
from ..maths.relief_frame import CaptureChoice, capture_frame, tilt_rad
from ..maths.relief_life import SHARED, LifeSettings, Sight
from ..maths.view import Camera
from .clusters import frustum_planes, visible
from .impostor_capture import ImpostorTextures, capture_bytes
from .scene import Scene

if TYPE_CHECKING:
    from .impostor_life import ImpostorGroup

START_PIXEL_NS = 150.0
"""What an impostor's pixel is taken to cost until one was measured."""
REMEMBERED = 15
TOO_FINE_TILT_RAD = 0.2618
TOO_FINE_TEXELS = 0.7
"""An object found finer than its texels is tried again from 15° aside, or with texels of this share of the size."""


@dataclass(frozen=True, eq=False)
class Part:
    """A group found in the scene: its rows (I,), the corners (8, 3) and box (2, 3) of its bounds, its triangles."""

    group: ImpostorGroup
    rows: np.ndarray
    hull_ws: np.ndarray
    bounds_ws: np.ndarray
    triangles: int
    scene: Scene

    @classmethod
    def of(cls, scene: Scene, group: ImpostorGroup) -> Part:
        """The group's rows and bounds; a group without instances (deleted, hidden) has no rows."""
        rows = np.isin(scene.instances.object_id, group.object_ids)
        bounds = scene.instance_bounds_ws()[rows]
        counts = np.array([len(m.triangles) for m in scene.meshes], np.int64)[scene.instances.mesh_index[rows]]
        if not len(bounds):
            return cls(group, rows, np.empty((0, 3)), np.zeros((2, 3)), 0, scene)
        box = np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])
        return cls(group, rows, _corners(box), box, int(counts.sum()), scene)

    def is_cut(self, camera: Camera) -> bool:
        """True when the camera's near plane passes through the object: of the triangles that it cuts one sees the inside."""
        away = -camera.view_from_world[2]
        if (self.hull_ws @ away[:3] + away[3]).min() >= camera.near:
            return False
        instances = self.scene.instances
        rows = away @ instances.world_from_object[self.rows]
        meshes = (self.scene.meshes[i].positions for i in instances.mesh_index[self.rows])
        nearest = (float((mesh @ row[:3].astype(np.float32)).min() + row[3]) for mesh, row in zip(meshes, rows, strict=True))
        return any(depth < camera.near for depth in nearest)


@dataclass(frozen=True, eq=False)
class Seen:
    """A sight, the frame that a capture from here would use, and the predictors by name."""

    sight: Sight
    frame: CaptureFrame | None
    errors: dict[str, float]


@dataclass(frozen=True)
class View:
    """For whom the impostors are looked at: camera, picture size (w, h), how captures are made, the life's settings; the rest as in
    `ImpostorChoice`."""

    camera: Camera
    size: tuple[int, int]
    capture: CaptureChoice
    life: LifeSettings
    exact: bool
    break_even: bool
    triangle_ns: float | None
    pixel_ns: float | None


class Sights:
    """Looks at all impostors of a frame. Keeps the stacked textures, the measured costs, and what was found too fine to be captured."""

    def __init__(self) -> None:
        self._stacked: tuple[tuple[int, ...], ReliefSet, BoundsSet] | None = None
        self._geometry_ns: dict[Hashable, tuple[int, float]] = {}
        self._pixel_ns: list[float] = []
        self._too_fine: dict[Hashable, CaptureFrame] = {}

    def look(self, parts: Sequence[Part], kept: Sequence[ImpostorTextures | None], view: View) -> list[Seen]:
        """One `Seen` per part; `kept` are the textures that they have."""
        live = [i for i, textures in enumerate(kept) if textures is not None and parts[i].triangles]
        errors, betas, tilts = self._predicted([(parts[i], kept[i]) for i in live], view)
        planes = frustum_planes(view.camera.clip_from_world)
        seen = []
        for i, part in enumerate(parts):
            if not part.triangles or not visible(part.bounds_ws[None], planes)[0]:
                seen.append(Seen(Sight(is_visible=False), None, {}))
                continue
            found = self._alone(part, view)
            if i in live:
                place = live.index(i)
                values = {name: float(column[place]) for name, column in errors.items()}
                sight = replace(found.sight, betas=betas[place], tilt_rad=float(tilts[place]))
                found = _with_errors(Seen(sight, found.frame, values), kept[i], view.life)
            seen.append(found)
        return seen

    def measure_geometry(self, part: Part, draw: Callable[[np.ndarray], None]) -> None:
        """Time an object's triangles, once for their number. `draw` draws rows of the scene alone and waits for the GPU."""
        known = self._geometry_ns.get(part.group.key)
        if known is None or known[0] != part.triangles:
            empty = _nanoseconds(lambda: draw(np.zeros_like(part.rows)))
            self._geometry_ns[part.group.key] = part.triangles, max(0.0, _nanoseconds(lambda: draw(part.rows)) - empty)

    def measure_impostor(self, covered_px: float, draw: Callable[[], None]) -> None:
        """Time the drawing of an impostor that covers so many pixels. `draw` waits for the GPU."""
        if covered_px > 0.0:
            self._pixel_ns = [*self._pixel_ns[-REMEMBERED:], _nanoseconds(draw) / covered_px]

    @property
    def pixel_ns(self) -> float:
        """What an impostor's pixel costs: the median of what was measured."""
        return float(np.median(self._pixel_ns)) if self._pixel_ns else START_PIXEL_NS

    def remember_too_fine(self, key: Hashable, frame: CaptureFrame) -> None:
        """A capture with this frame showed that the object is finer than its texels."""
        self._too_fine[key] = frame

    def forget(self, key: Hashable) -> None:
        """The object is not an impostor any more, or has changed."""
        self._too_fine.pop(key, None)
        self._geometry_ns.pop(key, None)

    def _predicted(self, live: list[tuple[Part, ImpostorTextures]], view: View) -> tuple[dict[str, np.ndarray], list, np.ndarray]:
        """Predictors by name, Betas and tilts of all that have a texture."""
        if not live:
            return {}, [], np.zeros(0)
        marks = tuple(mark for part, textures in live for mark in (id(textures), part.hull_ws.tobytes()))
        if self._stacked is None or self._stacked[0] != marks:
            hulls = bounds_set([t.frame for _, t in live], [p.hull_ws for p, _ in live])
            self._stacked = marks, relief_set([t.edges for _, t in live]), hulls
        exact = view.exact or view.life.predictor == "edge_sum_px"
        return predict(self._stacked[1], view.camera, view.size, exact), *betas_of_set(self._stacked[2], view.camera, view.size)

    def _alone(self, part: Part, view: View) -> Seen:
        """What does not depend on a texture: what a capture from here would take, and the costs."""
        if part.is_cut(view.camera):
            return Seen(Sight(is_cut=True), None, {})
        try:
            frame = capture_frame(part.hull_ws, view.camera, view.size, view.capture)
            room = capture_bytes(frame)
            covered = frame.width * frame.height / view.capture.texels_per_pixel**2
        except SceneError:
            frame, room, covered = None, 0, 0.0
        too_fine = self._is_too_fine(part.group.key, frame, view.camera)
        costs = self._geometry_cost(part, view), covered * (view.pixel_ns or self.pixel_ns)
        return Seen(Sight(True, None, np.inf, 0.0, covered, room, *costs, is_too_fine=too_fine), frame, {})

    def _geometry_cost(self, part: Part, view: View) -> float:
        """Nanoseconds; infinite where impostors are drawn however cheap the geometry is."""
        if not view.break_even:
            return np.inf
        return part.triangles * view.triangle_ns if view.triangle_ns else self._geometry_ns[part.group.key][1]

    def _is_too_fine(self, key: Hashable, frame: CaptureFrame | None, camera: Camera) -> bool:
        before = self._too_fine.get(key)
        if before is None or frame is None:
            return False
        return frame.texel_m > TOO_FINE_TEXELS * before.texel_m and tilt_rad(before, camera) <= TOO_FINE_TILT_RAD


def _with_errors(seen: Seen, textures: ImpostorTextures, life: LifeSettings) -> Seen:
    """The sight with the chosen predictor in the unit of its limit."""
    predicted, contours = seen.errors[life.predictor], textures.edges.contour_share
    if life.predictor in SHARED:
        covered = seen.errors["covered_px"]
        predicted = predicted / covered + life.resampling * contours if 0.0 < covered < np.inf else np.inf
    return replace(seen, sight=replace(seen.sight, predicted=predicted, is_too_fine=contours > life.finest))


def _nanoseconds(draw: Callable[[], None]) -> float:
    """The shorter of two goes: the first may compile a program."""
    times = []
    for _ in range(2):
        begin = time.perf_counter_ns()
        draw()
        times.append(time.perf_counter_ns() - begin)
    return float(min(times))


def _corners(box: np.ndarray) -> np.ndarray:
    """(8, 3) corners of a (2, 3) box."""
    pick = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    return box[pick, np.arange(3)]
