"""What the camera makes of every impostor of a frame, for `maths/relief/life.py` to decide on. Worker thread only.

All textures are predicted at once; what is kept of them is stacked again only when one of them changes. The costs for the break-even are
measured: an object's triangles once, when first seen, an impostor's pixels whenever one is captured.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import SceneError
from ...maths.relief.beta import Betas, BoundsSet, betas_of_set, bounds_set
from ...maths.relief.error import EXACT, ReliefSet, predict, relief_set
from ...maths.relief.frame import box_area, capture_frame, tilt_rad
from ...maths.relief.life import SHARED, ViewedImpostor, share_wrong
from ...maths.relief.warp import CaptureFrame, pixel_from_clip
from ...maths.view import Camera
from ..geometry.clusters import frustum_planes, visible
from .capture import ImpostorTextures, capture_bytes
from .records import Part, Seen, View
from .texels import BYTES_PER_TEXEL

START_PIXEL_NS = 150.0
"""What an impostor's pixel is taken to cost until one was measured."""
REMEMBERED = 15
TOO_FINE_TILT_RAD = 0.2618
TOO_FINE_TEXELS = 0.7
"""An object found finer than its texels is tried again from 15° aside, or with texels of this share of the size."""


LEAST_SHRUNK = 0.05
"""Seen this much smaller than at capture, the bounds say nothing more of the object."""


@dataclass(frozen=True, eq=False)
class _Boxes:
    """The bounds of T textures' objects: corners (T, 8, 3), and the areas (T,) of their images at capture, texels²."""

    corners_ws: np.ndarray
    captured: np.ndarray

    @classmethod
    def of(cls, live: list[tuple[Part, ImpostorTextures]]) -> _Boxes:
        """Stack them."""
        return cls(
            np.stack([part.hull_ws for part, _ in live]),
            box_area(np.stack([textures.frame.texels(part.hull_ws)[0] for part, textures in live])),
        )

    def shrunk(self, view: View, texel_px: np.ndarray) -> np.ndarray:
        """(T,) area of the image now over that at capture, with (T,) pixels per texel; from `LEAST_SHRUNK` to 1."""
        rows = pixel_from_clip(view.size) @ view.camera.clip_from_world
        image = self.corners_ws @ rows[:, :3].T + rows[:, 3]
        flat = image[..., :2] / np.maximum(image[..., 2:], 1e-9)
        then = np.where(np.isfinite(texel_px), self.captured * texel_px, np.inf)
        return np.clip(box_area(flat) / np.maximum(then, 1e-9), LEAST_SHRUNK, 1.0)


class Sights:
    """Looks at all impostors of a frame. Keeps the stacked textures, the measured costs, and what was found too fine to be captured.

    `pixel_ns`: what an impostor's pixel costs, the median of what was measured.
    """

    def __init__(self) -> None:
        self._stacked: tuple[tuple[bytes, ...], ReliefSet, BoundsSet, _Boxes] | None = None
        self._geometry_ns: dict[Hashable, tuple[int, float]] = {}
        self._pixel_ns: list[float] = []
        self.pixel_ns = START_PIXEL_NS
        self._too_fine: dict[Hashable, CaptureFrame] = {}

    def look(self, parts: Sequence[Part], kept: Sequence[ImpostorTextures | None], view: View) -> list[Seen]:
        """One `Seen` per part; `kept` are the textures that they have."""
        live = [i for i, textures in enumerate(kept) if textures is not None and parts[i].triangles]
        errors, betas, tilts, shrunk = self._predicted([(parts[i], kept[i]) for i in live], view)
        places, columns = {i: place for place, i in enumerate(live)}, {name: column.tolist() for name, column in errors.items()}
        bounds = np.array([part.bounds_ws for part in parts]).reshape(-1, 2, 3)
        shown = visible(bounds, frustum_planes(view.camera.clip_from_world)) if len(parts) else np.zeros(0, bool)
        away = -view.camera.view_from_world[2]
        reaches_near = (bounds * away[:3]).min(axis=1).sum(axis=1) + away[3] < view.camera.near
        seen = []
        for i, part in enumerate(parts):
            if not part.triangles or not shown[i]:
                seen.append(Seen(ViewedImpostor(is_visible=False), None, {}))
            elif reaches_near[i] and part.is_cut(view.camera):
                seen.append(Seen(ViewedImpostor(is_cut=True), None, {}))
            elif i in places and betas[places[i]].total < np.inf:
                values = {name: column[places[i]] for name, column in columns.items()}
                turn = float(tilts[places[i]]), float(shrunk[places[i]])
                seen.append(self._with_texture(part, kept[i], betas[places[i]], turn, values, view))
            else:
                seen.append(self._without_texture(part, view))
        return seen

    def look_at(self, part: Part, textures: ImpostorTextures, view: View) -> Seen:
        """One texture by itself, which need not be one of those kept."""
        alone = Sights()
        alone._geometry_ns, alone.pixel_ns = self._geometry_ns, self.pixel_ns
        return alone.look([part], [textures], view)[0]

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
            self.pixel_ns = float(np.median(self._pixel_ns))

    def remember_too_fine(self, key: Hashable, frame: CaptureFrame) -> None:
        """A capture with this frame showed that the object is finer than its texels."""
        self._too_fine[key] = frame

    def forget(self, key: Hashable) -> None:
        """The object is not an impostor any more, or has changed."""
        self._too_fine.pop(key, None)
        self._geometry_ns.pop(key, None)

    def _predicted(
        self, live: list[tuple[Part, ImpostorTextures]], view: View
    ) -> tuple[dict[str, np.ndarray], list, np.ndarray, np.ndarray]:
        """Predictors by name, Betas, tilts and how much smaller they are seen than at capture, of all that have a texture."""
        if not live:
            return {}, [], np.zeros(0), np.zeros(0)
        members, corners = tuple(t.edges for _, t in live), tuple(part.hull_ws.tobytes() for part, _ in live)
        if self._stacked is None or not _are(self._stacked[1].members, members) or self._stacked[0] != corners:
            hulls = bounds_set([t.frame for _, t in live], [p.hull_ws for p, _ in live])
            self._stacked = corners, relief_set(members), hulls, _Boxes.of(live)
        exact = view.exact or view.life.predictor in EXACT
        _, textures, hulls, boxes = self._stacked
        errors = predict(textures, view.camera, view.size, exact)
        return errors, *betas_of_set(hulls, view.camera, view.size), boxes.shrunk(view, errors["covered_px"] / textures.texels)

    def _with_texture(
        self, part: Part, textures: ImpostorTextures, betas: Betas, turn: tuple[float, float], values: dict[str, float], view: View
    ) -> Seen:
        """What a capture from here would take follows from the texture that is there. `turn`: tilt and how much smaller it is seen."""
        life, frame, (tilt, shrunk) = view.life, textures.frame, turn
        texel_px = betas.texel / betas.screen
        predicted, contours, covered = values[life.predictor], textures.edges.contour_share, values["covered_px"]
        if life.predictor in SHARED:
            predicted = share_wrong(predicted / covered, contours, tilt, shrunk, life) if 0.0 < covered < np.inf else np.inf
        quad_px = frame.width * frame.height * texel_px**2
        room = min(quad_px * view.capture.texels_per_pixel**2, float(view.capture.max_texels) ** 2) * BYTES_PER_TEXEL
        costs = self._geometry_cost(part, view), quad_px * (view.pixel_ns or self.pixel_ns)
        sight = ViewedImpostor(True, betas, predicted, tilt, quad_px, max(1, int(room)), *costs, is_too_fine=contours > life.finest)
        return Seen(sight, None, values)

    def _without_texture(self, part: Part, view: View) -> Seen:
        """What a capture from here would take, and the costs."""
        try:
            frame = capture_frame(part.hull_ws, view.camera, view.size, view.capture)
            room = capture_bytes(frame)
            covered = frame.width * frame.height / view.capture.texels_per_pixel**2
        except SceneError:
            frame, room, covered = None, 0, 0.0
        too_fine = self._is_too_fine(part.group.key, frame, view.camera)
        costs = self._geometry_cost(part, view), covered * (view.pixel_ns or self.pixel_ns)
        return Seen(ViewedImpostor(True, None, np.inf, 0.0, covered, room, *costs, is_too_fine=too_fine), frame, {})

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


def _are(kept: Sequence[object], wanted: Sequence[object]) -> bool:
    """Whether they are the very same objects. (`id` would not tell: it goes to a new object once the old one is gone.)"""
    return len(kept) == len(wanted) and all(one is other for one, other in zip(kept, wanted, strict=True))


def _nanoseconds(draw: Callable[[], None]) -> float:
    """The shorter of two goes: the first may compile a program."""
    times = []
    for _ in range(2):
        begin = time.perf_counter_ns()
        draw()
        times.append(time.perf_counter_ns() - begin)
    return float(min(times))
