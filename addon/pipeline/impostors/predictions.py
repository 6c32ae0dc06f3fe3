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
from ...maths.relief.frame import box_section, tilt_rad
from ...maths.relief.life import SHARED, ViewedImpostor, share_wrong
from ...maths.relief.warp import CaptureFrame
from ...maths.view import Camera
from ..geometry.clusters import frustum_planes, visible
from .capture import ImpostorTextures, capture_bytes
from .costs import Costs
from .records import ImpostorView, Part, Predicted
from .texels import BYTES_PER_TEXEL

TOO_FINE_TILT_RAD = 0.2618
TOO_FINE_TEXELS = 0.7
"""An object found finer than its texels is tried again from 15° aside, or with texels of this share of the size."""


LEAST_SHRUNK = 0.05
"""Seen this much less than at capture, the bounds say nothing more of the object."""

LEAST_NS = 1e3
"""A draw that seems to take less has been lost in what else the machine did."""


@dataclass(frozen=True, eq=False)
class _Boxes:
    """The bounds of T textures' objects: corners (T, 8, 3), and the areas (T,) that the capturing eyes saw of them (`box_section`)."""

    corners_ws: np.ndarray
    captured: np.ndarray

    @classmethod
    def of(cls, live: list[tuple[Part, ImpostorTextures]]) -> _Boxes:
        """Stack them."""
        corners = np.stack([part.hull_ws for part, _ in live])
        return cls(corners, box_section(corners, np.stack([t.frame.world_from_plane @ t.frame.eye for _, t in live])))

    def shrunk(self, camera: Camera) -> np.ndarray:
        """(T,) what the camera sees of them over what was seen at capture; from `LEAST_SHRUNK` to 1."""
        eye = np.append(-camera.direction_ws, 0.0) if camera.is_orthographic else np.append(camera.eye_ws, 1.0)
        seen = box_section(self.corners_ws, np.broadcast_to(eye, (len(self.corners_ws), 4)))
        return np.clip(seen / np.maximum(self.captured, 1e-30), LEAST_SHRUNK, 1.0)


class Predictions:
    """Predicts all impostors of a frame. Keeps the stacked textures, the `costs`, and what was found too fine to be captured."""

    def __init__(self) -> None:
        self._stacked: tuple[tuple[bytes, ...], ReliefSet, BoundsSet, _Boxes] | None = None
        self.costs = Costs()
        self._too_fine: dict[Hashable, CaptureFrame] = {}

    def predict(
        self, parts: Sequence[Part], kept: Sequence[ImpostorTextures | None], view: ImpostorView, ages: Sequence[int] | None = None
    ) -> list[Predicted]:
        """One `Predicted` per part; `kept` are the textures that they have, `ages` the pictures that these have served."""
        live = [i for i, textures in enumerate(kept) if textures is not None and parts[i].triangles]
        errors, betas, tilts, shrunk = self._predicted([(parts[i], kept[i]) for i in live], view)
        places, columns = {i: place for place, i in enumerate(live)}, {name: column.tolist() for name, column in errors.items()}
        bounds = np.array([part.bounds_ws for part in parts]).reshape(-1, 2, 3)
        shown = visible(bounds, frustum_planes(view.camera.clip_from_world)) if len(parts) else np.zeros(0, bool)
        away = -view.camera.view_from_world[2]
        reaches_near = (bounds * away[:3]).min(axis=1).sum(axis=1) + away[3] < view.camera.near
        seen, ages = [], ages or [0] * len(parts)
        for i, part in enumerate(parts):
            if not part.triangles or not shown[i]:
                seen.append(Predicted(ViewedImpostor(is_visible=False), None, {}))
            elif reaches_near[i] and part.is_cut(view.camera):
                seen.append(Predicted(ViewedImpostor(is_cut=True), None, {}))
            elif i in places and betas[places[i]].total < np.inf:
                values = {name: column[places[i]] for name, column in columns.items()}
                turn = float(tilts[places[i]]), float(shrunk[places[i]])
                seen.append(self._with_texture(part, kept[i], betas[places[i]], turn, values, view, ages[i]))
            else:
                seen.append(self._without_texture(part, view))
        return seen

    def predict_alone(self, part: Part, textures: ImpostorTextures, view: ImpostorView) -> Predicted:
        """One texture by itself, which need not be one of those kept."""
        alone = Predictions()
        alone.costs = self.costs
        return alone.predict([part], [textures], view)[0]

    def measure_geometry(self, part: Part, draw: Callable[[np.ndarray], None]) -> None:
        """Time an object's triangles, once for their number. `draw` draws rows of the scene alone and waits for the GPU."""
        if not self.costs.knows_geometry(part):
            empty = _nanoseconds(lambda: draw(np.zeros_like(part.rows)))
            self.costs.geometry(part, max(LEAST_NS, _nanoseconds(lambda: draw(part.rows)) - empty))

    def measure_impostor(self, covered_px: float, draw: Callable[[], None]) -> None:
        """Time the drawing of an impostor that covers so many pixels. `draw` waits for the GPU."""
        self.costs.impostor(covered_px, _nanoseconds(draw))

    def remember_too_fine(self, key: Hashable, frame: CaptureFrame) -> None:
        """A capture with this frame showed that the object is finer than its texels."""
        self._too_fine[key] = frame

    def drop(self, key: Hashable) -> None:
        """The object is not an impostor any more, or has changed."""
        self._too_fine.pop(key, None)
        self.costs.drop(key)

    def _predicted(
        self, live: list[tuple[Part, ImpostorTextures]], view: ImpostorView
    ) -> tuple[dict[str, np.ndarray], list, np.ndarray, np.ndarray]:
        """Predictors by name, Betas, tilts and how much smaller they are seen than at capture, of all that have a texture."""
        if not live:
            return {}, [], np.zeros(0), np.zeros(0)
        members, corners = tuple(t.edges for _, t in live), tuple(part.hull_ws.tobytes() for part, _ in live)
        if self._stacked is None or not _are(self._stacked[1].members, members) or self._stacked[0] != corners:
            hulls = bounds_set([t.frame for _, t in live], [p.hull_ws for p, _ in live])
            self._stacked = corners, relief_set(members), hulls, _Boxes.of(live)
        exact = view.choice.exact or view.choice.settings.predictor in EXACT
        _, textures, hulls, boxes = self._stacked
        errors = predict(textures, view.camera, view.size, exact)
        return errors, *betas_of_set(hulls, view.camera, view.size), boxes.shrunk(view.camera)

    def _with_texture(
        self,
        part: Part,
        textures: ImpostorTextures,
        betas: Betas,
        turn: tuple[float, float],
        values: dict[str, float],
        view: ImpostorView,
        age: int,
    ) -> Predicted:
        """What a capture from here would take follows from the texture that is there. `turn`: tilt and how much smaller it is seen."""
        settings, model, frame, (tilt, shrunk) = view.choice.settings, view.choice.model, textures.frame, turn
        texel_px = betas.texel / betas.screen
        predicted, contours, covered = values[settings.predictor], textures.edges.contour_share, values["covered_px"]
        if settings.predictor in SHARED:
            is_seen = 0.0 < covered < np.inf
            predicted = share_wrong(predicted / covered, contours, texel_px, tilt, shrunk, settings, model) if is_seen else np.inf
        quad_px = frame.width * frame.height * texel_px**2
        texels = min(quad_px * settings.texels_per_pixel**2, float(settings.max_texels) ** 2)
        costs, room = self.costs.of(part, view, quad_px, texels, age), texels * BYTES_PER_TEXEL
        impostor = ViewedImpostor(True, betas, predicted, tilt, quad_px, max(1, int(room)), *costs, is_too_fine=contours > model.finest)
        return Predicted(impostor, None, values)

    def _without_texture(self, part: Part, view: ImpostorView) -> Predicted:
        """What a capture from here would take, and the costs."""
        try:
            frame = view.frame_of(part.hull_ws)
            room, texels = capture_bytes(frame), frame.width * frame.height
        except SceneError:
            frame, room, texels = None, 0, 0
        too_fine = self._is_too_fine(part.group.key, frame, view.camera)
        covered = texels / view.choice.settings.texels_per_pixel**2
        costs = self.costs.of(part, view, covered, texels, 0)
        return Predicted(ViewedImpostor(True, None, np.inf, 0.0, covered, room, *costs, is_too_fine=too_fine), frame, {})

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
