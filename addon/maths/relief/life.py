"""The life of relief impostors: sprite → warp → regenerate, for many impostors under one budget. Pure data, no GPU.

RI §5.1, with what it leaves open: hysteresis between the stages, regenerations limited per frame and done a little early when there is room
(so that they do not all fall due together), a bound on texture memory with the least needed given up first, and geometry wherever an
impostor would be wrong (no capture yet, changed mesh, eye behind the plane, tilt) or dearer than the triangles it replaces.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from math import inf, tan

from ..domains import one_of, require_fields, within
from .beta import Betas
from .settings import ImpostorSettings

STAGES = ("hidden", "geometry", "sprite", "warp", "regenerated")
APPROACHES = ("texel", "schaufler")
TOO_FINE = "finer than its texels"
"""Why an object is drawn as geometry whose parts are thinner than the texels of a capture."""
GAIN, LOSS = 0.9, 1.05
"""The cost of an impostor over the geometry's, below which it becomes one, and above which it is one no more."""
RESOLVED_PX = 0.5
"""Texels of a capture are usually as large: two a pixel and side."""
SHARED = ("edge_sum_px", "edge_fast_px")


@dataclass(frozen=True, slots=True)
class LifeModel:
    """What the life cycle takes impostors to be like: constants fitted to pictures (docs/laboratory.md), not a user's choice.

    `approach` 'texel' renews when a texel covers more than `texel_px` pixels, 'schaufler' as RI when β_transN > β_screen. `hysteresis`:
    what was left at 1 is entered again at this share; also where early renewal begins. `waiting`: up to this multiple of the limit an
    impostor that waits for its turn is still warped, beyond it the geometry is drawn.
    With the edge sums the error is a share of wrong pixels (`share_wrong`): `opening` of the predicted openings (they are over-estimated),
    `resampling` of the contours per texel (more where they crowd), `turning` of the turn's tangent. `finest`: with more contours per texel
    than this a capture's life is over at once, and the geometry is drawn.
    """

    approach: str = one_of("texel", "Approach rule", APPROACHES)
    texel_px: float = within(1.5, "The pixels that a texel may cover", 1e-6)
    hysteresis: float = within(0.7, "The hysteresis", 1e-6, 1.0)
    waiting: float = within(1.5, "The waiting factor", 1.0)
    opening: float = within(0.28, "The weight of openings", 0.0)
    resampling: float = within(0.03, "The weight of resampling", 0.0)
    turning: float = within(0.07, "The weight of turning", 0.0)
    finest: float = within(0.2, "The finest share of contours", 1e-6, has_infinity=True)

    def __post_init__(self) -> None:
        require_fields(self)


def share_wrong(
    openings: float, contours: float, texel_px: float, turned_rad: float, shrunk: float, settings: ImpostorSettings, model: LifeModel
) -> float:
    """The share of an impostor's pixels that are wrong, by the edge sums.

    `(a·openings + b·contours·max(1, ½/texel_px) + c·tan(turn)) / shrunk²`.

    `openings` in shares of the pixels covered at capture, `contours` per texel, `texel_px` the pixels that a texel covers now: below ½ the
    contours come closer together than what a picture resolves. `shrunk` the object's image over that at capture (by its bounds, at the
    same distance): less is seen of it, and what is wrong, at its edges above all, stays. a, b, c: `model`, fitted to pictures
    (docs/laboratory.md).
    """
    turn = tan(min(turned_rad, settings.max_tilt_rad))
    crowded = contours * max(1.0, RESOLVED_PX / max(texel_px, 1e-9))
    return (model.opening * openings + model.resampling * crowded + model.turning * turn) / shrunk**2


@dataclass(frozen=True, slots=True)
class ImpostorState:
    """What is remembered of one impostor between frames.

    `age` frames since its capture, `unseen` frames since it was last in view, `need` how near it was to be renewed (inf: not known yet).
    """

    key: Hashable
    is_captured: bool = False
    is_stale: bool = False
    stage: str = "geometry"
    age: int = 0
    unseen: int = 0
    bytes: int = 0
    need: float = inf


@dataclass(frozen=True, slots=True)
class ViewedImpostor:
    """One impostor as the current camera sees it. `predicted` in the predictor's unit (inf: the warp does not exist), `covered_px` pixels.

    `capture_bytes` is what a capture from here would take (0: none is possible); `geometry_cost`, `impostor_cost` in any one unit.
    `is_cut`: the view's near distance cuts the object open; what is seen inside is in no texture.
    `is_too_fine`: its parts are thinner than the texels of a capture from here resolve.
    """

    is_visible: bool = True
    betas: Betas | None = None
    predicted: float = inf
    tilt_rad: float = 0.0
    covered_px: float = 0.0
    capture_bytes: int = 0
    geometry_cost: float = inf
    impostor_cost: float = 0.0
    is_cut: bool = False
    is_too_fine: bool = False


@dataclass(frozen=True, slots=True)
class Action:
    """What to do with one impostor in this frame: the stage to show it in, whether to capture it first, whether to free its texture.

    `reason` is for the report; `fade` the share (0…1] of the new texture while it fades in; `waits`: it should have been captured, but
    others went first, and a later frame can do it. `need`: how near to be renewed, the limit being 1.
    """

    key: Hashable
    stage: str
    regenerate: bool = False
    evict: bool = False
    reason: str = ""
    fade: float = 1.0
    waits: bool = False
    need: float = inf


@dataclass(frozen=True, slots=True)
class _Wish:
    """What one impostor would do if it were alone: `need` 0 = content, below 1 = would rather renew early, 1 or more = must; `felt` the
    same without the threshold."""

    stage: str
    need: float
    reason: str
    felt: float = inf


def decide(
    states: Sequence[ImpostorState], impostors: Sequence[ViewedImpostor], settings: ImpostorSettings, model: LifeModel = LifeModel()
) -> list[Action]:
    """One `Action` per impostor, in order. At most `regenerations` of them capture, and the textures kept fit `memory_bytes`.

    An impostor whose texture would be wrong is shown as geometry, never warped.
    """
    wishes = [_wish(state, impostor, settings, model) for state, impostor in zip(states, impostors, strict=True)]
    chosen = _within_budget(wishes, impostors, settings)
    actions = []
    for index, (state, impostor, wish) in enumerate(zip(states, impostors, wishes, strict=True)):
        if index in chosen:
            actions.append(Action(state.key, "regenerated", regenerate=True, reason=wish.reason, fade=_fade(0, settings)))
        else:
            stage = _while_waiting(wish, model)
            evict = state.is_captured and impostor.is_too_fine and stage == "geometry"
            waits = wish.need > 1.0 and settings.regenerations > 0 and impostor.capture_bytes <= settings.memory_bytes
            fade = _fade(state.age + 1, settings)
            reason = "" if 0.0 < wish.need <= 1.0 else wish.reason
            actions.append(Action(state.key, stage, evict=evict, reason=reason, fade=fade, waits=waits, need=wish.felt))
    return _within_memory(actions, states, impostors, settings)


def advance(state: ImpostorState, action: Action, impostor: ViewedImpostor) -> ImpostorState:
    """The state after the frame in which `action` was done."""
    unseen = 0 if impostor.is_visible else state.unseen + 1
    if action.evict:
        return ImpostorState(state.key, stage=action.stage, unseen=unseen)
    if action.regenerate:
        return ImpostorState(state.key, True, False, "regenerated", 0, unseen, impostor.capture_bytes)
    return replace(state, stage=action.stage, age=state.age + 1 if state.is_captured else 0, unseen=unseen, need=action.need)


def is_dearer(state: ImpostorState, impostor: ViewedImpostor) -> bool:
    """True when drawing the geometry is cheaper than the impostor; what begins as one must gain something, what is one may lose next to
    nothing."""
    return impostor.impostor_cost > impostor.geometry_cost * (GAIN if state.stage in ("geometry", "hidden") else LOSS)


def _wish(state: ImpostorState, impostor: ViewedImpostor, settings: ImpostorSettings, model: LifeModel) -> _Wish:
    if not impostor.is_visible:
        return _Wish("hidden", 0.0, "out of view")
    if impostor.is_cut:
        return _Wish("geometry", 0.0, "the view's near distance cuts it open")
    if is_dearer(state, impostor):
        return _Wish("geometry", 0.0, "the geometry is cheaper")
    if impostor.is_too_fine:
        return _Wish("geometry", 0.0, TOO_FINE)
    can_capture = impostor.capture_bytes > 0
    urgent = inf if can_capture else 0.0
    for wrong, reason in (
        (not state.is_captured, "not captured yet"),
        (state.is_stale, "the object has changed"),
        (impostor.tilt_rad > settings.max_tilt_rad, "seen too far from the side"),
        (not impostor.predicted < inf, "the eye is not before the plane"),
    ):
        if wrong:
            return _Wish("geometry", urgent, reason if can_capture else f"{reason}; cannot be captured from here")
    return _wish_of_captured(state, impostor, settings, model, can_capture)


def _wish_of_captured(
    state: ImpostorState, impostor: ViewedImpostor, settings: ImpostorSettings, model: LifeModel, can_capture: bool
) -> _Wish:
    """The wish of an impostor with a valid warp: RI's two critical moments and the approach."""
    betas, error = impostor.betas, impostor.predicted / settings.effective_limit
    assert betas is not None, "there are angles where there is a texture"
    as_sprite = settings.sprite_px if state.stage in ("sprite", "regenerated") else settings.sprite_px * model.hysteresis
    is_sprite = betas.total <= as_sprite * betas.screen
    stage = "sprite" if is_sprite else "warp"
    nearness = betas.texel / (model.texel_px * betas.screen)
    if model.approach == "schaufler":
        nearness = betas.trans_n / betas.screen
    need, reason = max((nearness, "too coarse from this near"), (0.0 if is_sprite else error, "the predicted error is over the limit"))
    if need <= model.hysteresis:
        return _Wish(stage, 0.0, "", need)
    if not can_capture:
        return _Wish(stage if need <= model.waiting else "geometry", 0.0, f"{reason}; cannot be captured from here")
    if need <= 1.0:
        return _Wish(stage, need, "renewed early", need) if need > state.need else _Wish(stage, 0.0, "", need)
    return _Wish(stage, need, reason, need)


def _within_budget(wishes: Sequence[_Wish], impostors: Sequence[ViewedImpostor], settings: ImpostorSettings) -> set[int]:
    """Who may capture: first those that must, by how much and how large they are seen; then, if more would rather than may in a frame, one
    of those."""
    must = sorted((i for i, w in enumerate(wishes) if w.need > 1.0), key=lambda i: (-wishes[i].need, -impostors[i].covered_px, i))
    early = sorted((i for i, w in enumerate(wishes) if 0.0 < w.need <= 1.0), key=lambda i: (-wishes[i].need, i))
    affordable = [i for i in must if impostors[i].capture_bytes <= settings.memory_bytes][: settings.regenerations]
    room = settings.regenerations - len(affordable)
    return {*affordable, *(early[: min(room, 1)] if len(early) > settings.regenerations else ())}


def _while_waiting(wish: _Wish, model: LifeModel) -> str:
    """The stage of an impostor that does not capture now."""
    if wish.stage not in ("sprite", "warp"):
        return wish.stage
    return wish.stage if wish.need <= model.waiting else "geometry"


def _within_memory(
    actions: list[Action], states: Sequence[ImpostorState], impostors: Sequence[ViewedImpostor], settings: ImpostorSettings
) -> list[Action]:
    """Free the least needed textures (longest unseen, then smallest on the screen) until the rest fits; in view, geometry stands in."""
    rows = zip(actions, states, impostors, strict=True)
    sizes = [impostor.capture_bytes if action.regenerate else state.bytes for action, state, impostor in rows]
    total = sum(sizes)
    order = sorted(range(len(actions)), key=lambda i: (actions[i].regenerate, -_unseen(states[i], impostors[i]), impostors[i].covered_px))
    for i in order:
        if total <= settings.memory_bytes:
            break
        if sizes[i]:
            stage = "hidden" if not impostors[i].is_visible else "geometry"
            actions[i] = Action(states[i].key, stage, evict=states[i].bytes > 0, reason="texture memory is used up")
            total -= sizes[i]
    return actions


def _unseen(state: ImpostorState, impostor: ViewedImpostor) -> int:
    return 0 if impostor.is_visible else state.unseen + 1


def _fade(age: int, settings: ImpostorSettings) -> float:
    return min(1.0, (age + 1) / (settings.fade_frames + 1))
