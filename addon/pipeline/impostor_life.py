"""The impostors of a scene from frame to frame: which are captured, how each is drawn now, and what is said about them. Worker thread only.

`maths/relief_life.py` decides; this module measures what it needs to know, captures, keeps the textures within the budget and frees them.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import GpuError, SceneError
from ..maths.choices import require, require_choice
from ..maths.relief import CaptureFrame
from ..maths.relief_beta import Betas, betas
from ..maths.relief_edges import EdgeChoice, ReliefEdges
from ..maths.relief_error import predict, relief_set
from ..maths.relief_frame import CaptureChoice, capture_frame, tilt_rad
from ..maths.relief_life import SHARED, Action, ImpostorState, LifeSettings, Sight, advance, decide
from ..maths.view import Camera
from .clusters import frustum_planes, visible
from .device import Device
from .draw_list import DrawList
from .gbuffer_pass import GBuffer
from .impostor_capture import ImpostorTextures, capture, capture_bytes, fingerprint
from .impostor_draw import METHODS, draw_impostor
from .scene import Scene

MODES = ("automatic", "manual")


@dataclass(frozen=True)
class ImpostorGroup:
    """What one impostor stands for: `object_ids` of the scene (an object, or all of a collection). `key` tells it from others."""

    key: Hashable
    object_ids: tuple[int, ...]
    name: str = ""


@dataclass(frozen=True)
class ImpostorChoice:
    """The impostors wanted in a picture, and how they live.

    `mode` 'manual' captures only the keys in `regenerate` (and what has no texture yet); 'automatic' lets the life cycle decide. `method`
    'inverse' follows view rays, 'forward' is the texts' pre-warp. `triangle_ns`, `pixel_ns`: what a triangle and an impostor's pixel cost,
    for the break-even; `never_dearer` False draws impostors however cheap the geometry is. `exact` also computes `edge_sum_px`.
    `fresh`: nothing is remembered of frames before, and nothing of this one by those that are not fresh.
    """

    groups: tuple[ImpostorGroup, ...] = ()
    life: LifeSettings = field(default_factory=LifeSettings)
    capture: CaptureChoice = field(default_factory=lambda: CaptureChoice(texels_per_pixel=2.0))
    edges: EdgeChoice = field(default_factory=EdgeChoice)
    with_back: bool = True
    mode: str = "automatic"
    method: str = "inverse"
    regenerate: frozenset[Hashable] = frozenset()
    triangle_ns: float = 60.0
    pixel_ns: float = 150.0
    never_dearer: bool = True
    exact: bool = False
    fresh: bool = False

    def __post_init__(self) -> None:
        require_choice("Impostor mode", self.mode, MODES)
        require_choice("Impostor method", self.method, METHODS)
        require(len({g.key for g in self.groups}) == len(self.groups), "Two impostors have the same key.")
        require(self.triangle_ns > 0.0 and self.pixel_ns > 0.0, "The costs of a triangle and of a pixel must be positive.")


@dataclass(frozen=True, eq=False)
class ImpostorReport:
    """One impostor in one frame. `errors` every predictor by name (empty without a texture), `size` texels, `triangles` it stands for.
    `edges` what the predictors keep of the texture: its frame and critical points. `waits`: a later frame will capture it."""

    key: Hashable
    name: str
    stage: str
    reason: str
    age: int
    betas: Betas | None
    errors: dict[str, float]
    limit: float
    tilt_rad: float
    size: tuple[int, int]
    bytes: int
    triangles: int
    edges: ReliefEdges | None = None
    waits: bool = False


@dataclass(frozen=True, eq=False)
class DrawnImpostor:
    """How to draw one impostor in this frame: its texture, and the old one while the new fades in."""

    textures: ImpostorTextures
    hull_ws: np.ndarray
    sprite: bool
    method: str
    fade: float
    old: ImpostorTextures | None

    def draw(self, device: Device, target: GBuffer, camera: Camera) -> None:
        """Draw over what `target` holds."""
        fade = self.fade if self.old is not None else 1.0
        draw_impostor(device, target, self.textures, self.hull_ws, camera, method="sprite" if self.sprite else self.method, fade=fade)
        if self.old is not None and fade < 1.0:
            draw_impostor(device, target, self.old, self.hull_ws, camera, method=self.method, fade=fade, fade_rest=True)


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

    def update(self, scene: Scene, draw_list: DrawList, camera: Camera, size: tuple[int, int], choice: ImpostorChoice) -> ImpostorFrame:
        """Decide, capture, evict; what to draw with `camera` at `size` (w, h). Groups no longer asked for lose their textures."""
        self._forget(set() if choice.fresh else {g.key for g in choice.groups})
        parts = [_Part.of(scene, group) for group in choice.groups]
        states = [self._state(part, draw_list) for part in parts]
        sights = self._sights(parts, camera, size, choice)
        actions = _asked(decide(states, [s.sight for s in sights], choice.life), states, sights, choice)
        geometry_rows, drawn, reports = np.ones(len(scene.instances), bool), [], []
        for part, state, seen, action in zip(parts, states, sights, actions, strict=True):
            action = self._do(part, seen, action, draw_list, choice)
            self._states[part.group.key] = advance(state, action, seen.sight)
            if action.stage not in ("geometry", "hidden"):
                drawn.append(self._drawn(part, action, camera, choice))
            if action.stage != "geometry":
                geometry_rows &= ~part.rows
            reports.append(self._report(part, seen, action, choice))
        saved = sum(r.triangles for r in reports if r.stage not in ("geometry", "hidden"))
        return ImpostorFrame(geometry_rows, tuple(drawn), tuple(reports), saved)

    def textures(self, key: Hashable) -> ImpostorTextures | None:
        """The current texture of an impostor."""
        return self._textures.get(key)

    def release(self) -> None:
        """Free everything."""
        self._forget(set())

    def _forget(self, wanted: set[Hashable]) -> None:
        for key in [k for k in self._states if k not in wanted]:
            del self._states[key]
            self._drop(key)

    def _drop(self, key: Hashable) -> None:
        for kept in (self._textures, self._old):
            if key in kept:
                kept.pop(key).release()

    def _state(self, part: _Part, draw_list: DrawList) -> ImpostorState:
        key = part.group.key
        state = self._states.get(key, ImpostorState(key))
        textures = self._textures.get(key)
        if textures is not None and textures.fingerprint != fingerprint(draw_list, part.rows):
            state = replace(state, is_stale=True)
            if key in self._old:
                self._old.pop(key).release()
        return state

    def _sights(self, parts: Sequence[_Part], camera: Camera, size: tuple[int, int], choice: ImpostorChoice) -> list[_Seen]:
        """What the camera makes of every impostor; the predictors run once for all that have a texture."""
        kept = [self._textures.get(part.group.key) for part in parts]
        live = [i for i, textures in enumerate(kept) if textures is not None]
        errors: dict[str, np.ndarray] = {}
        if live:
            exact = choice.exact or choice.life.predictor == "edge_sum_px"
            errors = predict(relief_set([kept[i].edges for i in live]), camera, size, exact)
        planes = frustum_planes(camera.clip_from_world)
        seen = [_seen(part, textures, camera, size, planes, choice) for part, textures in zip(parts, kept, strict=True)]
        for place, i in enumerate(live):
            values = {name: float(column[place]) for name, column in errors.items()}
            seen[i] = _with_errors(seen[i], values, choice)
        return seen

    def _do(self, part: _Part, seen: _Seen, action: Action, draw_list: DrawList, choice: ImpostorChoice) -> Action:
        """Capture or evict as decided; a capture that shows nothing turns into geometry."""
        key = part.group.key
        if action.evict:
            self._drop(key)
        if not action.regenerate:
            if action.fade >= 1.0 and key in self._old:
                self._old.pop(key).release()
            return action
        try:
            fresh = capture(self._device, draw_list, part.rows, seen.frame, with_back=choice.with_back, choice=choice.edges)
        except (SceneError, GpuError) as error:
            self._drop(key)
            return Action(key, "geometry", evict=True, reason=str(error))
        old = self._textures.pop(key, None)
        if key in self._old:
            self._old.pop(key).release()
        if old is not None:
            if choice.life.fade_frames and not self._states[key].is_stale and old.fingerprint == fresh.fingerprint:
                self._old[key] = old
            else:
                old.release()
        self._textures[key] = fresh
        return action

    def _drawn(self, part: _Part, action: Action, camera: Camera, choice: ImpostorChoice) -> DrawnImpostor:
        key = part.group.key
        old = self._old.get(key)
        if old is not None and tilt_rad(old.frame, camera) > choice.life.max_tilt_rad:
            old = None
        sprite = action.stage == "sprite" or (action.stage == "regenerated" and self._textures[key].frame.is_perspective)
        return DrawnImpostor(self._textures[key], part.hull_ws, sprite, choice.method, action.fade, old)

    def _report(self, part: _Part, seen: _Seen, action: Action, choice: ImpostorChoice) -> ImpostorReport:
        key = part.group.key
        textures, state = self._textures.get(key), self._states[key]
        size = (textures.frame.width, textures.frame.height) if textures else (0, 0)
        return ImpostorReport(
            key,
            part.group.name,
            action.stage,
            action.reason,
            state.age,
            seen.sight.betas,
            seen.errors,
            choice.life.effective_limit,
            seen.sight.tilt_rad,
            size,
            textures.bytes if textures else 0,
            part.triangles,
            textures.edges if textures else None,
            action.waits,
        )


def library_of(device: Device, fresh: bool = False) -> ImpostorLibrary:
    """The device's impostors, made on first use and released with it; those of fresh frames apart from those that live on."""
    return device.attached("fresh impostors" if fresh else "impostors", lambda: ImpostorLibrary(device))


@dataclass(frozen=True, eq=False)
class _Part:
    """A group found in the scene."""

    group: ImpostorGroup
    rows: np.ndarray
    hull_ws: np.ndarray
    bounds_ws: np.ndarray
    triangles: int
    scene: Scene

    @classmethod
    def of(cls, scene: Scene, group: ImpostorGroup) -> _Part:
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
class _Seen:
    """A sight, the frame that a capture from here would use, and the predictors by name."""

    sight: Sight
    frame: CaptureFrame | None
    errors: dict[str, float]


def _seen(
    part: _Part, textures: ImpostorTextures | None, camera: Camera, size: tuple[int, int], planes: np.ndarray, choice: ImpostorChoice
) -> _Seen:
    if not part.triangles or not visible(part.bounds_ws[None], planes)[0]:
        return _Seen(Sight(is_visible=False), None, {})
    try:
        frame = capture_frame(part.hull_ws, camera, size, choice.capture)
        room = capture_bytes(frame)
        covered = frame.width * frame.height / choice.capture.texels_per_pixel**2
    except SceneError:
        frame, room, covered = None, 0, 0.0
    dear = part.triangles * choice.triangle_ns if choice.never_dearer else np.inf
    if part.is_cut(camera):
        return _Seen(Sight(is_cut=True, covered_px=covered), None, {})
    sight = Sight(True, None, np.inf, 0.0, covered, room, dear, covered * choice.pixel_ns)
    if textures is not None:
        sight = replace(sight, betas=betas(textures.frame, part.hull_ws, camera, size), tilt_rad=tilt_rad(textures.frame, camera))
    return _Seen(sight, frame, {})


def _with_errors(seen: _Seen, values: dict[str, float], choice: ImpostorChoice) -> _Seen:
    """The sight with the chosen predictor in the unit of its limit."""
    if not seen.sight.is_visible:
        return seen
    name = choice.life.predictor
    predicted = values[name]
    if name in SHARED:
        predicted = predicted / values["covered_px"] if 0.0 < values["covered_px"] < np.inf else np.inf
    return _Seen(replace(seen.sight, predicted=predicted), seen.frame, values)


def _asked(actions: list[Action], states: Sequence[ImpostorState], sights: Sequence[_Seen], choice: ImpostorChoice) -> list[Action]:
    """In manual mode: what the user asked for instead of what the life cycle would renew; what is wrong is still never shown."""
    if choice.mode == "automatic":
        return actions
    out = []
    for action, state, seen in zip(actions, states, sights, strict=True):
        wanted = action.key in choice.regenerate or not state.is_captured
        if wanted and seen.frame is not None and seen.sight.is_visible:
            out.append(Action(action.key, "regenerated", regenerate=True, reason="asked for"))
        elif action.regenerate:
            usable = state.is_captured and not state.is_stale and seen.sight.predicted < np.inf
            usable = usable and seen.sight.tilt_rad <= choice.life.max_tilt_rad
            out.append(Action(action.key, "warp" if usable else "geometry", reason=action.reason))
        else:
            out.append(action)
    return out


def _corners(box: np.ndarray) -> np.ndarray:
    """(8, 3) corners of a (2, 3) box."""
    pick = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    return box[pick, np.arange(3)]
