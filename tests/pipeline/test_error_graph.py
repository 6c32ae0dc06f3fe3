"""The curves of the error over depth against their definitions."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.maths.spaces import orthographic
from addon.maths.view import Camera
from addon.pipeline.job import Job
from addon.settings.groups import Settings
from addon.studies.error_graph import BINS, FEWEST_IN_BIN, ErrorGraph, error_graph
from addon.studies.run import run
from tests import scenes

CAMERA = scenes.look_at((0.0, -4.0, 3.0), (0.0, 60.0, 0.0), near=0.5, far=90.0)
FLAT = Camera(CAMERA.view_from_world, orthographic(20.0, 16.0 / 9.0, 0.5, 90.0), 0.5, 90.0)
PASSES = ("combined", "depth", "aliasing")


def outcome(renderer, light=None, camera=CAMERA, **partition):
    chosen = Settings().replaced(partition=partition or {"kind": "z-log", "count": 4}, fit={"kind": "frustum", "size": 128})
    light = scenes.sun(50.0) if light is None else light
    job = Job(scenes.border_floor(60.0, 12), camera, light, chosen, (160, 120), PASSES)
    return run(job, on=renderer)


def test_measured_quantiles_are_those_of_the_pixels_in_each_bin(renderer):
    found = outcome(renderer)
    graph = error_graph(found)
    depth, m = found.frame.passes["depth"].astype(float), found.frame.passes["aliasing"][..., 0].astype(float)
    known = np.isfinite(depth) & np.isfinite(m)
    edges = np.geomspace(graph.near, graph.far, BINS + 1)
    assert len(graph.measured.z) > 10
    assert graph.measured.share.sum() > 0.95
    for z, median, p95, share in zip(*(getattr(graph.measured, name) for name in ("z", "median", "p95", "share")), strict=True):
        i = np.searchsorted(edges, z) - 1
        inside = m[known & (depth >= edges[i]) & (depth < edges[i + 1])]
        assert len(inside) >= FEWEST_IN_BIN
        assert share == pytest.approx(len(inside) / known.sum())
        assert (inside < median).mean() <= 0.5 <= (inside <= median).mean()
        assert abs((inside <= p95).mean() - 0.95) <= 1.0 / len(inside) + 1e-9


def test_predictions_stay_below_the_reports_maxima_and_reach_them_inside_the_view(renderer):
    found = outcome(renderer)
    graph, rows = error_graph(found), found.report["partitions"]
    assert len(graph.predictions) >= 3
    for p in graph.predictions:
        row = rows[p.index]
        assert p.z[0] >= row["near"] * (1 - 1e-9)
        assert p.z[-1] <= row["far"] * (1 + 1e-9)
        assert p.m_x.max() <= row["m_x_max"] * (1 + 1e-9)
        assert p.m_z.max() <= row["m_z_max"] * np.sin(found.frame.plan.gamma_rad) * (1 + 1e-9)  # T4 (37) as the picture shows it
        if p.z[0] <= row["near"] * (1 + 1e-9) and p.z[-1] >= row["far"] * (1 - 1e-9):
            assert p.m_x.max() == pytest.approx(row["m_x_max"])
    assert graph.splits == tuple(sorted(r["far"] for r in rows if graph.near < r["far"] < graph.far))


def test_the_axis_holds_every_depth_seen_and_runs_from_0_to_1(renderer):
    for camera in (CAMERA, FLAT):
        graph = error_graph(outcome(renderer, camera=camera))
        assert graph.is_logarithmic == (not camera.is_orthographic)
        assert graph.along(np.array([graph.near, graph.far])) == pytest.approx([0.0, 1.0])
        assert (np.diff(graph.along(graph.measured.z)) > 0.0).all()
        assert bool(graph.predictions) == (not camera.is_orthographic)


def test_there_is_no_graph_without_a_map_or_without_the_passes(renderer):
    found = outcome(renderer)
    assert error_graph(replace(found, frame=replace(found.frame, plan=None))) is None
    assert error_graph(replace(found, frame=replace(found.frame, passes={}))) is None


@given(near=st.floats(1e-3, 1e3), ratio=st.floats(1.05, 1e8), is_logarithmic=st.booleans())
def test_two_to_eight_round_depths_stand_along_the_axis(near, ratio, is_logarithmic):
    graph = ErrorGraph(near, near * ratio, is_logarithmic, (), None, ())
    ticks = graph.ticks()
    assert 2 <= len(ticks) <= 8
    assert ticks == sorted(set(ticks))
    assert all(0.0 < graph.along(z) < 1.0 for z in ticks)
    assert all(len(f"{z:g}") <= 8 for z in ticks)
