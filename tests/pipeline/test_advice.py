"""What the advice promises: its numbers are a real picture's, it keeps the budget or reaches the error, and nothing measured beats it."""

import json
from dataclasses import fields

import numpy as np
import pytest

from addon.errors import SceneError, SettingsError
from addon.maths.choices import FITS
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.settings.groups import TESTS, Settings
from addon.studies.advice import Goal, SampledFrame, advice_report, advice_table, advise
from addon.studies.advice.candidates import Candidate, all_candidates, candidate_of, neighbours, pruned
from addon.studies.advice.goal import GRAIN, LARGEST_MAP
from addon.studies.run import stop_worker as stop_shared_worker
from tests import scenes

SIZE = (320, 180)
SETTINGS = Settings().replaced(fit={"size": 256})
ALONG = scenes.look_at((0.0, -4.0, 3.0), (0.0, 100.0, 0.0), near=0.5, far=120.0)
SUN = scenes.sun(40.0)


@pytest.fixture(scope="module", autouse=True)
def worker_closed():
    """Jobs run on the add-on's shared worker."""
    yield
    stop_shared_worker()


def job_at(camera=ALONG, light=SUN, settings=SETTINGS, scene=None):
    return Job(scene or scenes.border_floor(100.0, 12), camera, light, settings, SIZE)


def done(frames, goal, **options):
    """(advice, steps) of a search run to its end."""
    steps, search = [], advise(frames, goal, **options)
    while True:
        try:
            steps.append(next(search))
        except StopIteration as stop:
            return stop.value, steps


@pytest.fixture(scope="module")
def for_texels():
    return done([SampledFrame(job_at())], Goal(texels=2**18))


def test_the_points_errors_are_those_of_a_real_picture(for_texels):
    """Points of a small picture under the plan of the small picture, against the aliasing pass at full size: within 3 %."""
    frame = SampledFrame(job_at())
    for warp, partition, fit in (("uniform", "none", "frustum"), ("lispsm-general", "z-adaptive", "scene"), ("logpsm", "z-log", "samples")):
        settings = Candidate(warp, partition, 3, fit).settings(SETTINGS, 256)
        drawn, sampled = frame.rendered(settings), frame.errors(settings)[:, 0]
        assert np.median(sampled) == pytest.approx(drawn["m_median"], rel=0.03)
        assert np.quantile(sampled, 0.95) == pytest.approx(drawn["m_p95"], rel=0.03)


def test_the_proposal_keeps_the_budget_and_nothing_measured_is_much_better(for_texels):
    advice, _ = for_texels
    assert advice.best.texels <= 2**18
    assert advice.best.size % GRAIN == 0
    assert all(row.texels <= 2**18 for row in advice.rows)
    assert advice.best.m_p95 <= 1.03 * min(row.m_p95 for row in advice.rows)
    assert advice.confirmed["m_p95"] == pytest.approx(advice.best.m_p95, rel=0.03)


def test_the_scenes_own_combination_is_in_the_table_and_not_better(for_texels):
    advice, _ = for_texels
    assert candidate_of(SETTINGS) in {row.candidate for row in advice.rows}
    assert advice.current.size == 256
    assert advice.current.texels == 2**18
    assert advice.best.m_p95 <= 1.03 * advice.current.m_p95
    assert advice.confirmed_current["m_p95"] == pytest.approx(advice.current.m_p95, rel=0.03)


def test_progress_goes_up_from_nothing_to_the_last_picture(for_texels):
    _, steps = for_texels
    fractions = [step.fraction for step in steps]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0.0
    assert all(step.text for step in steps)


def test_the_least_budget_reaches_the_error_and_half_of_it_does_not():
    advice, _ = done([SampledFrame(job_at())], Goal(error=1.0))
    assert advice.confirmed["m_p95"] <= 1.005
    assert all(row.texels >= advice.best.texels / 1.03 for row in advice.rows)
    half, _ = done([SampledFrame(job_at())], Goal(texels=advice.best.texels // 2))
    assert half.best.m_p95 > 1.0


def test_an_error_out_of_reach_gives_no_proposal_and_says_so():
    advice, _ = done([SampledFrame(job_at())], Goal(error=1e-4))
    assert advice.best is None
    assert str(LARGEST_MAP) in advice.notes[0]
    assert advice.settings(SETTINGS) is SETTINGS
    assert advice_report(advice)["proposal"] is None


def test_several_frames_are_pooled_and_the_flicker_of_the_samples_fit_is_named():
    cameras = [scenes.look_at((0.0, -4.0 + 8.0 * i, 3.0), (0.0, 100.0, 0.0), near=0.5, far=120.0) for i in range(3)]
    scene = scenes.border_floor(100.0, 12)
    advice, _ = done([SampledFrame(job_at(camera, scene=scene), i + 1) for i, camera in enumerate(cameras)], Goal(texels=2**18))
    assert advice.best.frames == 3
    assert len(advice.splits) == 3
    assert min(advice.best.frame_p95) <= advice.best.m_p95 <= max(advice.best.frame_p95)
    assert any(row.candidate.fit != "samples" for row in advice.rows)
    assert (advice.best.candidate.fit == "samples") == any("samples" in note for note in advice.notes)


def test_time_that_is_up_still_gives_an_answer():
    advice, _ = done([SampledFrame(job_at())], Goal(texels=2**18), seconds=0.0)
    assert advice.best is not None
    assert any("time was up" in note for note in advice.notes)


def test_the_report_is_json_and_the_table_marks_the_proposal(for_texels):
    advice, _ = for_texels
    report = json.loads(json.dumps(advice_report(advice), allow_nan=False))
    assert report["proposal"]["options"]["map_size"] == advice.best.size
    assert report["proposal"]["splits"][0] == sorted(report["proposal"]["splits"][0])
    assert len(report["table"]) == len(advice.rows)
    lines = advice_table(advice).splitlines()
    assert sum(line.startswith("→") for line in lines) == 1
    assert sum(line.startswith("now") for line in lines) == 1


def test_the_shadow_test_proposed_is_the_cheapest_that_is_as_good_as_the_most_exact():
    """Posts thin against the texels: their shadows have edges, and only the exact test's are not read from texels."""
    posts = [scenes.box((x, y, 0.0), (x + 0.08, y + 0.08, 2.5)) for x in np.linspace(-6.0, 6.0, 9) for y in np.linspace(2.0, 20.0, 7)]
    job = job_at(scene=scenes.scene_of(scenes.floor(40.0), *posts), settings=SETTINGS.replaced(test={"kind": "depth"}))
    advice, _ = done([SampledFrame(job)], Goal(texels=2**16))
    differs = {(row.choice.kind, row.choice.outlines): row.differs_pct for row in advice.tests}
    assert set(differs) == {*((kind, False) for kind in TESTS), ("triangle", True)}
    assert differs["triangle", False] < 0.2 * differs["depth", False]
    assert advice.test.choice.kind == "triangle"
    assert advice.settings(job.settings).test == advice.test.choice
    report = advice_report(advice)
    assert report["proposal"]["options"]["test"] == "triangle"
    assert [row["test"] for row in report["tests"]] == [*TESTS, "triangle"]
    proposed = [line for line in advice_table(advice).splitlines() if line.endswith("proposed")]
    assert len(proposed) == 1 and proposed[0].startswith("test triangle")


def test_where_every_test_shows_the_same_the_cheapest_is_proposed():
    advice, _ = done([SampledFrame(job_at(scene=scenes.scene_of(scenes.floor(40.0))))], Goal(texels=2**16))
    assert [row.differs_pct for row in advice.tests] == [0.0] * 4
    assert advice.test is advice.tests[0]


def test_a_light_that_reaches_nothing_in_view_is_said():
    with pytest.raises(SceneError, match="reaches nothing"):
        done(
            [SampledFrame(job_at(light=Light("sun", np.array([0.0, 0.0, -1.0])), scene=scenes.scene_of(scenes.floor())))],
            Goal(texels=2**18),
        )


@pytest.mark.parametrize("wrong", [{}, {"texels": 2**20, "error": 1.0}, {"texels": 10}, {"error": 0.0}, {"error": float("nan")}])
def test_a_goal_is_exactly_one_sensible_number(wrong):
    with pytest.raises(SettingsError):
        Goal(**wrong)


def test_only_sensible_combinations_are_tried():
    for kind in ("spot", "point"):
        assert not any(c.warp in ("log", "logpsm") or c.partition.startswith("faces") for c in all_candidates(SETTINGS, False, kind))
    assert {c.warp for c in all_candidates(SETTINGS, True, "sun")} == {"uniform"}
    assert {c.partition for c in all_candidates(SETTINGS, False, "point")} == {"none"}
    assert {c.fit for c in all_candidates(SETTINGS, False, "sun")} == set(FITS)


def test_pruning_keeps_the_first_and_the_best_of_every_warp_and_partition():
    ranked = [c for c in all_candidates(SETTINGS, False, "sun") if c.fit == "scene"]
    kept = pruned(ranked, 5)
    assert kept[:5] == ranked[:5]
    assert {c.warp for c in kept} == {c.warp for c in ranked}
    assert {c.partition for c in kept} == {c.partition for c in ranked}
    assert len(kept) < len(ranked) / 4


def test_neighbours_differ_in_one_thing_and_stay_within_the_choices():
    for c in all_candidates(SETTINGS, False, "sun"):
        for other in neighbours(c):
            assert sum(getattr(c, field.name) != getattr(other, field.name) for field in fields(Candidate)) == 1
            chosen = other.settings(SETTINGS, 64)
            assert (chosen.partition.count, chosen.partition.alpha, chosen.warp.log_bend) == (other.count, other.alpha, other.log_bend)
