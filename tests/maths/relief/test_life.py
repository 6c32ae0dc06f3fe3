"""The life cycle as claims: stages, hysteresis, budgets, eviction, and never a wrong picture shown as valid."""

from dataclasses import replace
from math import atan, inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.relief.beta import Betas
from addon.maths.relief.error import PREDICTORS
from addon.maths.relief.life import STAGES, Action, ImpostorState, LifeModel, ViewedImpostor, advance, decide, share_wrong
from addon.maths.relief.settings import LIMITS, ImpostorSettings

RULES = ImpostorSettings(predictor="edge_fast_px", limit=1.0, sprite_px=1.0, memory_mib=1)
MODEL = LifeModel()
SHARE = 1024
"""Bytes of 1/1024 of the textures' memory."""


def _betas(total: float = 0.0, texel: float = 1.0, trans_n: float = 0.0) -> Betas:
    return Betas(screen=1.0, trans_p=total, trans_n=trans_n, total=total, texel=texel)


def _impostor(**changes) -> ViewedImpostor:
    return replace(ViewedImpostor(betas=_betas(), predicted=0.0, covered_px=100.0, capture_bytes=10 * SHARE, impostor_cost=1.0), **changes)


def _live(key: object = 0, **changes) -> ImpostorState:
    return replace(ImpostorState(key, is_captured=True, stage="warp", bytes=10 * SHARE), **changes)


def _one(state: ImpostorState, impostor: ViewedImpostor, rules: ImpostorSettings = RULES, model: LifeModel = MODEL) -> Action:
    return decide([state], [impostor], rules, model)[0]


def test_a_new_impostor_is_captured_then_a_sprite_then_warped_then_renewed():
    state, stages = ImpostorState("a"), []
    captured_at = 0.0
    for eye in range(9):
        moved = eye - captured_at
        impostor = _impostor(betas=_betas(total=0.6 * moved), predicted=0.3 * moved)
        action = _one(state, impostor)
        stages.append(action.stage)
        captured_at = eye if action.regenerate else captured_at
        state = advance(state, action, impostor)
    assert stages == ["regenerated", "sprite", "warp", "warp", "regenerated", "sprite", "warp", "warp", "regenerated"]


@pytest.mark.parametrize(
    ("state", "impostor"),
    [
        (ImpostorState(0), _impostor(capture_bytes=0)),
        (_live(is_stale=True), _impostor(capture_bytes=0)),
        (_live(), _impostor(predicted=inf, capture_bytes=0)),
        (_live(), _impostor(predicted=float("nan"), capture_bytes=0)),
        (_live(), _impostor(tilt_rad=0.8, capture_bytes=0)),
        (_live(), _impostor(predicted=2.0, betas=_betas(9.0), capture_bytes=0)),
    ],
)
def test_what_would_be_wrong_and_cannot_be_captured_is_geometry(state, impostor):
    action = _one(state, impostor)
    assert (action.stage, action.regenerate) == ("geometry", False)
    assert action.reason


@pytest.mark.parametrize("changes", [{"is_stale": True}, {"is_captured": False}])
def test_a_stale_or_missing_texture_is_renewed_at_once_or_shown_as_geometry(changes):
    assert _one(_live(**changes), _impostor()).regenerate
    assert _one(_live(**changes), _impostor(), replace(RULES, regenerations=0)).stage == "geometry"


def test_what_waits_for_its_turn_is_warped_up_to_the_grace_and_geometry_beyond():
    waiting = replace(RULES, regenerations=0)
    assert _one(_live(), _impostor(betas=_betas(5.0), predicted=1.4), waiting).stage == "warp"
    assert _one(_live(), _impostor(betas=_betas(5.0), predicted=1.6), waiting).stage == "geometry"


def test_the_sprite_is_left_at_the_limit_and_entered_again_below_it():
    between = _impostor(betas=_betas(total=0.85))
    assert _one(_live(stage="sprite"), between).stage == "sprite"
    assert _one(_live(stage="warp"), between).stage == "warp"
    assert _one(_live(stage="warp"), _impostor(betas=_betas(total=0.65))).stage == "sprite"
    assert _one(_live(stage="sprite"), _impostor(betas=_betas(total=1.01))).stage == "warp"


def test_coming_near_renews_by_the_texel_or_by_schauflers_angle():
    coarse, moved = _impostor(betas=_betas(texel=1.6)), _impostor(betas=_betas(trans_n=1.1))
    assert _one(_live(), coarse).regenerate
    assert not _one(_live(), moved).regenerate
    schaufler = LifeModel(approach="schaufler")
    assert _one(_live(), moved, model=schaufler).regenerate
    assert not _one(_live(), coarse, model=schaufler).regenerate


def test_geometry_is_drawn_where_it_is_cheaper_with_hysteresis():
    alike = _impostor(geometry_cost=1.0, impostor_cost=1.03)
    assert _one(_live(stage="geometry"), alike).stage == "geometry"
    assert _one(_live(stage="geometry"), _impostor(geometry_cost=1.0, impostor_cost=0.95)).stage == "geometry"
    assert _one(_live(stage="warp"), alike).stage != "geometry"
    assert _one(_live(stage="warp"), _impostor(geometry_cost=1.0, impostor_cost=1.06)).stage == "geometry"


def test_renewal_comes_early_where_more_are_nearly_due_than_a_frame_may_renew():
    early, due = _impostor(betas=_betas(5.0), predicted=0.8), _impostor(betas=_betas(5.0), predicted=1.1)
    wearing = [_live(i, need=0.7) for i in range(3)]
    assert not _one(wearing[0], early).regenerate
    assert [a.regenerate for a in decide(wearing[:2], [early] * 2, RULES)].count(True) == 1
    assert [a.regenerate for a in decide(wearing, [early, due, early], RULES)] == [False, True, False]
    assert [a.regenerate for a in decide(wearing, [early] * 3, replace(RULES, regenerations=2))].count(True) == 1
    assert not any(a.regenerate for a in decide(wearing, [early] * 3, replace(RULES, regenerations=3)))


def test_what_gets_better_by_itself_is_not_renewed_early():
    nearly = _impostor(betas=_betas(5.0), predicted=0.8)
    assert not any(a.regenerate for a in decide([_live(i, need=0.9) for i in range(3)], [nearly] * 3, RULES))
    unknown = advance(ImpostorState("new"), Action("new", "regenerated", regenerate=True), nearly)
    assert not any(a.regenerate for a in decide([unknown, replace(unknown, key="other")], [nearly] * 2, RULES))
    later = advance(unknown, _one(unknown, nearly), nearly)
    assert later.need == pytest.approx(0.8)


def test_the_crossfade_ends_after_its_frames():
    state, impostor, fades, rules = _live(is_stale=True), _impostor(), [], replace(RULES, fade_frames=4)
    for _ in range(6):
        action = _one(state, impostor, rules)
        fades.append(action.fade)
        state = advance(state, action, impostor)
    assert fades == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0, 1.0])


def test_hidden_impostors_cost_nothing_and_are_given_up_first():
    states = [_live(0, bytes=600 * SHARE, unseen=3), _live(1, bytes=600 * SHARE), ImpostorState(2)]
    impostors = [_impostor(is_visible=False), _impostor(covered_px=5.0), _impostor(capture_bytes=300 * SHARE)]
    actions = decide(states, impostors, RULES)
    assert [a.stage for a in actions] == ["hidden", "sprite", "regenerated"]
    assert [a.evict for a in actions] == [True, False, False]
    assert [a.regenerate for a in actions] == [False, False, True]
    assert advance(states[0], actions[0], impostors[0]) == ImpostorState(0, stage="hidden", unseen=4)


def test_a_capture_larger_than_the_memory_is_never_made():
    action = _one(ImpostorState(0), _impostor(capture_bytes=2000 * SHARE))
    assert (action.stage, action.regenerate, action.evict) == ("geometry", False, False)


_SIGHTS = st.builds(
    _impostor,
    is_visible=st.booleans(),
    betas=st.builds(_betas, st.floats(0, 3), st.floats(0, 3), st.floats(0, 3)),
    predicted=st.sampled_from([0.0, 0.5, 0.9, 1.2, 3.0, inf]),
    tilt_rad=st.floats(0, 1.2),
    covered_px=st.floats(0, 1e5),
    capture_bytes=st.integers(0, 1200 * SHARE),
    impostor_cost=st.floats(0, 2),
    geometry_cost=st.floats(0, 2),
)
_STATES = st.builds(
    lambda captured, stale, stage, age, size: ImpostorState("k", captured, stale, stage, age, 0, size if captured else 0),
    st.booleans(),
    st.booleans(),
    st.sampled_from(STAGES),
    st.integers(0, 9),
    st.integers(1, 900 * SHARE),
)


@given(st.lists(st.tuples(_STATES, _SIGHTS), max_size=12), st.integers(0, 4))
@settings(max_examples=150)
def test_budgets_hold_and_nothing_wrong_is_shown_whatever_happens(pairs, regenerations):
    rules = replace(RULES, regenerations=regenerations)
    states, impostors = [replace(s, key=i) for i, (s, _) in enumerate(pairs)], [v for _, v in pairs]
    actions = decide(states, impostors, rules)
    assert [a.key for a in actions] == [s.key for s in states]
    assert sum(a.regenerate for a in actions) <= regenerations
    after = [advance(*row) for row in zip(states, actions, impostors, strict=True)]
    assert sum(s.bytes for s in after) <= rules.memory_bytes
    for state, impostor, action in zip(states, impostors, actions, strict=True):
        assert (action.stage == "hidden") == (not impostor.is_visible)
        if action.stage in ("sprite", "warp"):
            assert state.is_captured
            assert not state.is_stale
            assert not action.evict
            assert impostor.predicted < inf
            assert impostor.tilt_rad <= rules.max_tilt_rad
        if action.regenerate:
            assert impostor.capture_bytes > 0
            assert impostor.is_visible


@given(st.lists(st.tuples(_STATES, _SIGHTS), min_size=2, max_size=8))
@settings(max_examples=60)
def test_the_neediest_go_first(pairs):
    states = [replace(s, key=i) for i, (s, _) in enumerate(pairs)]
    impostors = [replace(v, capture_bytes=min(v.capture_bytes, 1)) for _, v in pairs]
    alone = [_one(s, v, replace(RULES, memory_mib=1000)) for s, v in zip(states, impostors, strict=True)]
    together = decide(states, impostors, replace(RULES, memory_mib=1000))
    assert any(a.regenerate for a in together) == any(a.regenerate for a in alone)
    assert all(b.regenerate for a, b in zip(together, alone, strict=True) if a.regenerate)


def test_every_predictor_has_a_limit():
    assert set(LIMITS) == set(PREDICTORS)
    assert ImpostorSettings(predictor="critical").effective_limit == LIMITS["critical"]


def test_the_share_of_wrong_pixels_weighs_openings_contours_and_the_turn_and_grows_as_the_object_is_seen_smaller():
    weighed = RULES, LifeModel(opening=0.5, resampling=0.25, turning=0.125)
    assert share_wrong(0.1, 0.2, 1.0, 0.0, 1.0, *weighed) == pytest.approx(0.1)
    assert share_wrong(0.1, 0.2, 1.0, 0.0, 0.5, *weighed) == pytest.approx(0.4)
    assert share_wrong(0.0, 0.0, 1.0, atan(0.4), 1.0, *weighed) == pytest.approx(0.05)
    assert share_wrong(0.0, 0.0, 1.0, 3.0, 1.0, *weighed) == pytest.approx(0.125)
    assert share_wrong(0.0, 0.2, 0.125, 0.0, 1.0, *weighed) == pytest.approx(0.2)


@pytest.mark.parametrize(
    "wrong",
    [
        {"approach": "x"},
        {"texel_px": float("inf")},
        {"hysteresis": 0.0},
        {"waiting": 0.5},
        {"opening": -0.1},
        {"turning": float("nan")},
    ],
)
def test_a_model_outside_its_domain_is_refused(wrong):
    with pytest.raises(SettingsError):
        LifeModel(**wrong)


@pytest.mark.parametrize(
    "wrong",
    [
        {"predictor": "guess"},
        {"limit": 0.0},
        {"limit": float("nan")},
        {"sprite_px": -0.1},
        {"max_tilt_deg": 90.0},
        {"ahead": 0.96},
        {"regenerations": -1},
        {"memory_mib": 0},
        {"fade_frames": -1},
        {"texels_per_pixel": 0.0},
        {"texels_per_pixel": float("nan")},
        {"max_texels": 8},
    ],
)
def test_settings_outside_their_domain_are_refused(wrong):
    with pytest.raises(SettingsError):
        ImpostorSettings(**wrong)
