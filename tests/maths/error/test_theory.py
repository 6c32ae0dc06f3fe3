"""The theory object: its keys, the texts' own numbers, and what holds between its parts."""

import json
from math import inf, isfinite, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.choices import PARTITIONS, WARPS, PartitionChoice, WarpChoice
from addon.maths.error.aliasing import error_x, error_z
from addon.maths.error.seams import seams
from addon.maths.error.theory import text_report, theory
from addon.maths.error.warped_map import partition_maps
from tests.margins import agree, at_most
from tests.maths.views import HOSTILE_ANGLES, HOSTILE_RATIOS, views

ROW_KEYS = {"index", "near", "far", "warp_parameter", "eta", "m_x_max", "m_z_max", "storage_factor", "critical_resolution"}
TOTAL_KEYS = {"m_x_max", "m_z_max", "storage_factor"}
warps = st.sampled_from(WARPS).map(WarpChoice)
partitions = st.builds(PartitionChoice, st.sampled_from(PARTITIONS), st.integers(1, 8))


@pytest.mark.parametrize(
    "warp, partition, count, storage",
    [
        ("uniform", "none", 1, 865159),
        ("psm", "none", 1, 865.16),
        ("lispsm", "none", 1, 865.16),
        ("lispsm-general", "none", 1, 865.16),
        ("uniform", "z-log", 4, 90.06),
        ("lispsm", "z-log", 4, 16.016),
        ("lispsm-general", "z-log", 8, 9.501),
        ("logpsm", "none", 1, 5.982),
        ("logpsm", "z-log", 8, 5.982),
        ("lispsm-general", "z-adaptive", 4, 16.016),
    ],
)
def test_storage_factors_of_the_texts(warp, partition, count, storage):
    total = theory(1.0, 1000.0, radians(30), pi / 2, WarpChoice(warp), PartitionChoice(partition, count))["total"]
    assert total["storage_factor"] == pytest.approx(storage, rel=1e-3)


@given(views(max_ratio=1e7), warps, partitions)
def test_the_object_is_the_contract_s_and_holds_together(view, warp, partition):
    result = theory(*view.shape, warp, partition, curve=16)
    assert set(result) == {"gamma_deg", "gamma_lim_deg", "partitions", "total", "curve", "as_seen"}
    rows, total, curve = result["partitions"], result["total"], result["curve"]
    assert len(rows) == partition.z_count and all(set(row) == ROW_KEYS for row in rows) and set(total) == TOTAL_KEYS
    assert rows[0]["near"] == view.near and rows[-1]["far"] == view.far
    assert [row["far"] for row in rows[:-1]] == [row["near"] for row in rows[1:]]
    for row in rows:
        agree(row["storage_factor"], row["m_x_max"] * row["m_z_max"], rel=1e-6)
        agree(row["critical_resolution"], [row["m_x_max"], row["m_z_max"]], rel=1e-6)
        assert (row["warp_parameter"] is None) == (row["eta"] == -1.0)
    assert total["m_x_max"] == max(row["m_x_max"] for row in rows) and total["m_z_max"] == max(row["m_z_max"] for row in rows)
    agree(total["storage_factor"], sum(row["storage_factor"] for row in rows), rel=1e-6)
    assert len(curve["z"]) == 16
    agree(curve["z"][0], view.near, rel=1e-6)
    agree(curve["z"][-1], view.far, rel=1e-6)
    at_most(max(curve["m_x"]) / total["m_x_max"] - 1.0, 1e-9)
    assert all(m is None or m <= total["m_z_max"] * (1 + 1e-9) for m in curve["m_z"])
    assert json.loads(json.dumps(result, allow_nan=False)) == result


def test_every_number_is_finite_on_hostile_views():
    for ratio in HOSTILE_RATIOS:
        for gamma in (0.0, 1e-3, *HOSTILE_ANGLES[4:]):
            for kind in WARPS:
                result = theory(1.0, ratio, radians(30), gamma, WarpChoice(kind), PartitionChoice("z-adaptive", 4))
                assert all(isfinite(v) and v > 0.0 for v in result["total"].values())


def test_the_curve_is_each_partition_s_error():
    args = (1.0, 200.0, radians(25), radians(60), WarpChoice(), PartitionChoice("z-adaptive", 3))
    result, maps = theory(*args, curve=40), partition_maps(*args)
    for z, m_x, m_z, seen in zip(*result["curve"].values(), result["as_seen"]["curve_m_z"], strict=True):
        here = [m for m in maps if m.near <= z][-1]
        assert (m_x, m_z, seen) == pytest.approx((error_x(here, z), error_z(here, z), error_z(here, z) * np.sin(radians(60))))


def test_resolutions_enter_m_and_the_critical_resolution_but_not_s():
    args = (1.0, 100.0, radians(30), 1.2, WarpChoice(), PartitionChoice("z-log", 2))
    plain, real, image_only = theory(*args, curve=5), theory(*args, 2048, (1280, 720), 5), theory(*args, None, (1280, 720))
    for a, b, c in zip(plain["partitions"], real["partitions"], image_only["partitions"], strict=True):
        assert b["m_x_max"] == pytest.approx(a["m_x_max"] * 1280 / 2048) and b["m_z_max"] == pytest.approx(a["m_z_max"] * 720 / 2048)
        assert b["storage_factor"] == a["storage_factor"] and c["m_x_max"] == a["m_x_max"]
        assert b["critical_resolution"] == c["critical_resolution"] == pytest.approx([1280 * a["m_x_max"], 720 * a["m_z_max"]])
    assert real["curve"]["m_z"] == pytest.approx([720 / 2048 * m for m in plain["curve"]["m_z"]])


def test_parallel_light_has_the_storage_of_the_texts_and_no_curve_of_m_z():
    result = theory(1.0, 100.0, radians(30), 0.0, WarpChoice(), PartitionChoice("z-log", 4), curve=3)
    assert result["total"]["storage_factor"] == pytest.approx(4 * 100 ** (2 / 4))  # (54)
    assert result["curve"]["m_z"] == [None] * 3 and [row["warp_parameter"] for row in result["partitions"]] == [None] * 4


def test_side_faces_keep_their_warp_at_every_angle():
    overhead, parallel = (theory(1.0, 1000.0, radians(30), g, WarpChoice("logpsm"), PartitionChoice("faces")) for g in (pi / 2, 0.0))
    assert overhead["partitions"] == parallel["partitions"]
    assert parallel["total"]["storage_factor"] == pytest.approx(np.log(1000) / (2 * np.tan(radians(30)) * np.cos(radians(30)) ** 3))  # 5.52


def test_orthographic_cameras_have_splits_but_no_theory():
    result = theory(-5.0, 5.0, 0.0, 1.0, WarpChoice(), PartitionChoice("z-log", 2), curve=4)
    assert [(row["near"], row["far"]) for row in result["partitions"]] == [(-5.0, 0.0), (0.0, 5.0)]
    assert result["total"] == dict.fromkeys(TOTAL_KEYS) and result["curve"] is None


@pytest.mark.parametrize(
    "near, far, phi, gamma",
    [
        (2.0, 1.0, 0.5, 1.0),
        (0.0, 1.0, 0.5, 1.0),
        (1.0, 2.0, pi / 2, 1.0),
        (1.0, inf, 0.5, 1.0),
        (1.0, 2.0, float("nan"), 1.0),
        (1.0, 2.0, 0.5, -0.1),
    ],
)
def test_impossible_views_are_refused(near, far, phi, gamma):
    with pytest.raises(SettingsError):
        theory(near, far, phi, gamma, WarpChoice(), PartitionChoice())


@given(views(min_ratio=2.0), warps)
def test_seams_are_the_two_sides_of_each_border(view, warp):
    partition = PartitionChoice("z-adaptive", 3)
    maps, found = partition_maps(*view.shape, warp, partition), seams(*view.shape, warp, partition)
    assert [s.z for s in found] == [m.near for m in maps[1:]]
    for seam, before, behind in zip(found, maps[:-1], maps[1:], strict=True):
        agree(seam.jump_x, error_x(behind, seam.z) / error_x(before, seam.z), rel=1e-6)
        if view.gamma > 0.0:
            agree(seam.jump_z, error_z(behind, seam.z) / error_z(before, seam.z), rel=1e-6)


def test_generalised_lispsm_has_no_seam_in_z_between_log_splits():
    for seam in seams(1.0, 1000.0, radians(20), radians(70), WarpChoice(), PartitionChoice("z-log", 4)):
        assert seam.jump_z == pytest.approx(1.0, rel=1e-9) and seam.jump_x > 1.5


@pytest.mark.parametrize("partition", PARTITIONS)
@pytest.mark.parametrize("gamma", [0.0, radians(20), pi / 2])
def test_the_report_prints_every_partition_and_its_numbers(partition, gamma):
    choices = WarpChoice(pseudo_near=4.0), PartitionChoice(partition, 3)
    result = theory(1.0, 100.0, radians(30), gamma, *choices)
    text = text_report(result, radians(30), *choices)
    for row in result["partitions"]:
        for value in (row["far"], row["m_x_max"], row["m_z_max"], row["storage_factor"]):
            assert f"{value:.5g}" in text
    assert all(kind in text for kind in WARPS) and ("seams" in text) == (len(result["partitions"]) > 1)
    assert "nan" not in text.lower() and max(map(len, text.splitlines())) <= 140
