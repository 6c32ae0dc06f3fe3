"""The command `bench` in a checkout and as shipped."""

import json
import shutil
import subprocess
import sys

import pytest

from tests.conftest import ROOT
from tools.build_package import ONLY_FOR_BENCHMARKS, copy_sources

SMALL = ["--deck", "10000", "--frames", "1", "--size", "64x48", "--map-size", "64", "--quiet", "--json"]


def bench(root):
    command = [sys.executable, "-m", "addon", "bench", *SMALL]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["bench"]


@pytest.fixture
def shipped(tmp_path):
    copy_sources(tmp_path / "shipped")
    shutil.copy2(ROOT / "blender_manifest.toml", tmp_path / "shipped")  # the packer writes its own, with the wheels
    return tmp_path / "shipped"


def test_what_only_benchmarks_need_is_not_shipped_and_the_command_tells_what_it_misses(shipped):
    assert not any((shipped / name).exists() for name in ONLY_FOR_BENCHMARKS)
    result = bench(shipped)
    assert result["median_ms"].keys() == {"ours"} and result["median_ms"]["ours"] > 0.0
    assert len(result["left_out"]) == 1 and "bare passes" in result["left_out"][0] and "./dev bench" in result["left_out"][0]


def test_a_checkout_times_the_bare_passes_and_misses_nothing():
    result = bench(ROOT)
    assert result["median_ms"].keys() == {"ours", "bare passes"} and not result["left_out"]
