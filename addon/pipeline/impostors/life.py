"""The impostors of a scene from frame to frame: which are captured, how each is drawn now, and what is said about them. Worker thread only.

`maths/relief/life.py` decides; this module measures what it needs to know, captures, keeps the textures within the budget and frees them.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import DriverError, GpuError, SceneError
from ...maths.relief.carry import carries
from ...maths.relief.edges import ReliefEdges
from ...maths.relief.frame import is_at_capture, tilt_rad
from ...maths.relief.life import TOO_FINE, Action, ImpostorState, advance, decide
from ...maths.relief.warp import CaptureFrame
from ...maths.view import Camera
from ...scene.records import Scene
from ..device import Device
from ..frame import ImpostorReport
from ..geometry.draw_list import DrawList
from ..passes.gbuffer import draw_gbuffer
from .ahead import Ahead
from .capture import ImpostorTextures, capture, fingerprint
from .draw import draw_impostor
from .predictions import Predictions
from .records import ImpostorChoice, ImpostorGroup, ImpostorView, Part, Predicted, parts_of
from .views import DrawnImpostor, Views, towards_set

CARRIED = "edges carried over"
"""Added to the reason of a renewal from nearer that gathered nothing anew for the predictors (`maths/relief/carry.py`)."""


@dataclass(frozen=True, eq=False)
class ImpostorFrame:
    """What a frame does about its impostors: `geometry_rows` (I,) bool still drawn as triangles, the impostors to draw, their reports,
    and the triangles that the camera pass is spared."""

    geometry_rows: np.ndarray
    drawn: tuple[DrawnImpostor, ...]
    reports: tuple[ImpostorReport, ...]
    triangles_saved: int


class ImpostorLibrary:
    """The textures and states of all impostors of one device. `update` once per frame; `release` with the device."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._states: dict[Hashable, ImpostorState] = {}
        self._textures: dict[Hashable, ImpostorTextures] = {}
        self._old: dict[Hashable, ImpostorTextures] = {}
        self._views: dict[Hashable, Views] = {}
        self._predictions = Predictions()
        self._ahead = Ahead()
        self._captures: Counter[Hashable] = Counter()
        self._parts: tuple[Scene | None, tuple[ImpostorGroup, ...], list[Part]] = (None, (), [])
        self._judged: tuple[DrawList | None, dict[Hashable, Hashable]] = (None, {})

    def update(
        self, scene: Scene, draw_list: DrawList, camera: Camera, size: tuple[int, int], choice: ImpostorChoice, samples: int = 1
    ) -> ImpostorFrame:
        """Decide, capture, evict; what to draw with `camera` at `size` (w, h) with so many samples a pixel.

        Groups no longer asked for lose their textures.
        """
        self._drop_others(set() if choice.alone else {g.key for g in choice.groups})
        self._captures.clear()
        parts = self._found(scene, choice.groups)
        states = [self._state(part, draw_list) for part in parts]
        view = ImpostorView(camera, size, choice, samples)
        if choice.settings.break_even and choice.triangle_ns is None:
            self._measure_geometry(parts, draw_list, view)
        for key, views in self._views.items():
            self._textures[key] = views.by_nearness(camera)[0]
        kept = [self._textures.get(part.group.key) for part in parts]
        predicted = self._predictions.predict(parts, kept, view, [state.age for state in states])
        numbers: list[int | None] = [None] * len(parts)
        if choice.settings.directions:
            turned = [self._towards_set(part, seen, view) for part, seen in zip(parts, predicted, strict=True)]
            predicted, numbers = [seen for seen, _ in turned], [number for _, number in turned]
        actions = _asked(decide(states, [s.impostor for s in predicted], choice.settings, choice.model), states, predicted, choice)
        geometry_rows, drawn, reports = np.ones(len(scene.instances), bool), [], []
        for part, state, seen, action, number in zip(parts, states, predicted, actions, numbers, strict=True):
            action, shown = self._do(part, seen, action, draw_list, view, number)
            self._states[part.group.key] = replace(advance(state, action, seen.impostor), bytes=self._bytes(part.group.key))
            if action.stage not in ("geometry", "hidden"):
                drawn.append(self._drawn(part, action, shown, camera, choice))
            if action.stage != "geometry":
                geometry_rows &= ~part.rows
            reports.append(self._report(part, seen, shown, action, choice))
        self._ahead.moved_to(camera)
        saved = sum(r.triangles for r in reports if r.stage not in ("geometry", "hidden"))
        return ImpostorFrame(geometry_rows, tuple(drawn), tuple(reports), saved)

    @property
    def pixel_ns(self) -> float:
        """What an impostor's pixel costs, as far as it was measured."""
        return self._predictions.costs.pixel_ns

    def textures(self, key: Hashable) -> ImpostorTextures | None:
        """The current texture of an impostor."""
        return self._textures.get(key)

    def release(self) -> None:
        """Free everything."""
        self._drop_others(set())

    def _found(self, scene: Scene, groups: tuple[ImpostorGroup, ...]) -> list[Part]:
        """The groups in the scene, looked for once per scene."""
        if self._parts[0] is not scene or self._parts[1] != groups:
            self._parts = scene, groups, parts_of(scene, groups)
        return self._parts[2]

    def _fingerprint(self, part: Part, draw_list: DrawList) -> Hashable:
        """What the group's captures are to agree with, worked out once per draw list."""
        if self._judged[0] is not draw_list:
            self._judged = draw_list, {}
        known = self._judged[1]
        if part.group not in known:
            known[part.group] = fingerprint(draw_list, part.rows)
        return known[part.group]

    def _drop_others(self, wanted: set[Hashable]) -> None:
        for key in [k for k in self._states if k not in wanted]:
            del self._states[key]
            self._drop(key)
            self._predictions.drop(key)
            self._ahead.drop(key)

    def _drop(self, key: Hashable) -> None:
        self._textures.pop(key, None)
        for kept in (self._views, self._old):
            if key in kept:
                kept.pop(key).release()

    def _bytes(self, key: Hashable) -> int:
        """Texture memory of all captures of an impostor that stay."""
        return self._views[key].bytes if key in self._views else 0

    def _towards_set(self, part: Part, seen: Predicted, view: ImpostorView) -> tuple[Predicted, int | None]:
        return towards_set(part, seen, self._views.get(part.group.key), view, view.choice.settings.directions, view.choice.settings.views)

    def _state(self, part: Part, draw_list: DrawList) -> ImpostorState:
        key = part.group.key
        state = self._states.get(key, ImpostorState(key))
        textures = self._textures.get(key)
        if textures is not None and textures.fingerprint != self._fingerprint(part, draw_list):
            state = replace(state, is_stale=True)
            self._predictions.drop(key)
            if key in self._old:
                self._old.pop(key).release()
        return state

    def _measure_geometry(self, parts: Sequence[Part], draw_list: DrawList, view: ImpostorView) -> None:
        """Time the triangles of objects that are new or have changed."""
        target, device = self._device.gbuffer(view.size), self._device
        for part in parts:

            def draw(rows: np.ndarray) -> None:
                draw_gbuffer(device.context, device.programs, target, draw_list, view.camera, rows)
                device.context.finish()

            self._predictions.measure_geometry(part, draw)

    def _measure_impostor(self, part: Part, textures: ImpostorTextures, covered_px: float, view: ImpostorView, method: str) -> None:
        """Time the drawing of a texture just captured."""
        target, device = self._device.gbuffer(view.size), self._device

        def draw() -> None:
            draw_impostor(device, target, textures, part.hull_ws, view.camera, method=method)
            device.context.finish()

        self._predictions.measure_impostor(covered_px, draw)

    def _do(
        self,
        part: Part,
        seen: Predicted,
        action: Action,
        draw_list: DrawList,
        view: ImpostorView,
        number: int | None,
    ) -> tuple[Action, Predicted]:
        """Capture or evict as decided (`number`: which direction of a set); a capture that shows nothing turns into geometry. Returns what
        was done, and what is predicted of what there is now."""
        key = part.group.key
        if action.evict:
            if seen.impostor.is_too_fine and key in self._textures:
                self._predictions.remember_too_fine(key, self._textures[key].frame)
            self._drop(key)
        if not action.regenerate:
            if action.fade >= 1.0 and key in self._old:
                self._old.pop(key).release()
            return action, seen
        begin = time.perf_counter_ns()
        try:
            fresh, shown = self._captured(part, seen, draw_list, view, number)
        except DriverError:
            raise
        except (SceneError, GpuError) as error:
            self._drop(key)
            return Action(key, "geometry", evict=True, reason=str(error)), seen
        self._predictions.costs.captured(key, float(time.perf_counter_ns() - begin), self._states[key].age if key in self._states else 0)
        if fresh.edges.contour_share > view.choice.model.finest:
            self._predictions.remember_too_fine(key, fresh.frame)
            fresh.release()
            self._drop(key)
            return Action(key, "geometry", evict=True, reason=TOO_FINE), seen
        self._keep(key, fresh, view, number)
        if view.choice.settings.break_even and view.choice.pixel_ns is None:
            self._measure_impostor(part, fresh, seen.impostor.covered_px, view, view.choice.settings.warp)
        return action if fresh.edges.gathered is None else replace(action, reason=f"{action.reason}; {CARRIED}"), shown

    def _captured(
        self, part: Part, seen: Predicted, draw_list: DrawList, view: ImpostorView, number: int | None
    ) -> tuple[ImpostorTextures, Predicted]:
        """A new capture and what is predicted of it: from ahead of an eye that moves on, where that is good enough here, else from here."""

        def taken(frame: CaptureFrame) -> tuple[ImpostorTextures, Predicted]:
            self._captures[key] += 1
            known = _known(current, frame, view.choice) if renews else None
            fresh = capture(
                self._device, draw_list, part.rows, frame, with_back=view.choice.settings.back_layer, choice=view.choice.edges, known=known
            )
            return fresh, self._predictions.predict_alone(part, fresh, view)

        key, current = part.group.key, self._textures.get(part.group.key)
        renews = current is not None and current.fingerprint == self._fingerprint(part, draw_list) and number is None
        if renews and view.choice.settings.use == "automatic":
            ahead = self._ahead.frame(part, current, view)
            if ahead is not None:
                fresh, shown = taken(ahead)
                if self._ahead.holds(key, shown.impostor, view.choice):
                    return fresh, shown
                fresh.release()
        return taken(seen.frame or view.frame_of(part.hull_ws))

    def _keep(self, key: Hashable, fresh: ImpostorTextures, view: ImpostorView, number: int | None) -> None:
        """Put a new capture among those of its impostor; captures of what the object was before go."""
        former = self._textures.get(key)
        if former is not None and former.fingerprint != fresh.fingerprint:
            self._drop(key)
        if key in self._old:
            self._old.pop(key).release()
        views = self._views.setdefault(key, Views())
        settings = view.choice.settings
        if settings.fade_frames and number is None and settings.views == 1 and views.held:
            self._old[key] = views.held.popitem()[1]
        views.make_room(fresh.bytes, settings.memory_bytes, view.camera)
        views.put(number, fresh, settings.views)
        self._textures[key] = views.by_nearness(view.camera)[0]

    def _drawn(self, part: Part, action: Action, shown: Predicted, camera: Camera, choice: ImpostorChoice) -> DrawnImpostor:
        """Further captures are drawn with one that is over the limit alone, or is of a set: with one within it they gain nothing."""
        key, settings = part.group.key, choice.settings
        old = self._old.get(key)
        if old is not None and tilt_rad(old.frame, camera) > settings.max_tilt_rad:
            old = None
        textures = self._textures[key]
        at_rest = textures.frame.is_perspective and is_at_capture(textures.frame, camera)
        near = [t for t in self._views[key].by_nearness(camera)[1 : settings.views] if tilt_rad(t.frame, camera) <= settings.max_tilt_rad]
        gains = settings.directions > 0 or shown.impostor.predicted > settings.effective_limit
        others = tuple(near) if gains and not at_rest else ()
        return DrawnImpostor(
            textures, part.hull_ws, at_rest or action.stage == "sprite", settings.warp, action.fade, old, others, settings.fill
        )

    def _report(self, part: Part, seen: Predicted, shown: Predicted, action: Action, choice: ImpostorChoice) -> ImpostorReport:
        key = part.group.key
        textures, state = self._textures.get(key), self._states[key]
        size = (textures.frame.width, textures.frame.height) if textures else (0, 0)
        return ImpostorReport(
            key,
            part.group.name,
            action.stage,
            action.reason,
            state.age,
            seen.impostor.betas,
            seen.errors,
            shown.impostor.predicted if textures and shown.impostor.is_visible else None,
            choice.settings.effective_limit,
            seen.impostor.tilt_rad,
            size,
            self._bytes(key),
            part.triangles,
            textures.edges if textures else None,
            action.waits,
            self._captures[key],
        )


def library_of(device: Device, fresh: bool = False) -> ImpostorLibrary:
    """The device's impostors, made on first use and released with it; those of fresh frames apart from those that live on."""
    return device.attached("fresh impostors" if fresh else "impostors", lambda: ImpostorLibrary(device))


def _known(current: ImpostorTextures, frame: CaptureFrame, choice: ImpostorChoice) -> ReliefEdges | None:
    """What the predictors keep of the last capture, where it may serve a new one on `frame`."""
    edges = current.edges
    alike = edges.choice == choice.edges and edges.has_back == choice.settings.back_layer
    return edges if alike and carries(edges, frame) else None


def _asked(actions: list[Action], states: Sequence[ImpostorState], predicted: Sequence[Predicted], choice: ImpostorChoice) -> list[Action]:
    """In manual mode: what the user asked for instead of what the life cycle would renew; what is wrong is still never shown."""
    if choice.settings.use == "automatic":
        return actions
    out = []
    for action, state, seen in zip(actions, states, predicted, strict=True):
        wanted = action.key in choice.regenerate or not state.is_captured
        if wanted and seen.impostor.capture_bytes and seen.impostor.is_visible and not seen.impostor.is_too_fine:
            out.append(Action(action.key, "regenerated", regenerate=True, reason="asked for"))
        elif action.regenerate:
            usable = state.is_captured and not state.is_stale and seen.impostor.predicted < np.inf
            usable = usable and seen.impostor.tilt_rad <= choice.settings.max_tilt_rad
            out.append(Action(action.key, "warp" if usable else "geometry", reason=action.reason))
        else:
            out.append(action)
    return out
