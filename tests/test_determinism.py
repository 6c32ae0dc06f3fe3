"""The examples of property tests: the same on every machine and Python, whatever is loaded, alone and within any order."""

import hashlib
import json
import os
import subprocess
import sys

import hypothesis
from hypothesis import strategies as st

from tests.conftest import ROOT

RECORDED = "c6137a63071c2cc6e3102cf81c9201b4aa8a2c0c58c94958daa64c3b34559ad1"
LOADS_ALL = """
import importlib, pkgutil, sys, pytest
for room in map(importlib.import_module, ("addon.maths", "addon.pipeline", "addon.images", "addon.scene.platform_deck")):
    for module in pkgutil.walk_packages(room.__path__, room.__name__ + "."):
        importlib.import_module(module.name)
sys.exit(pytest.main(sys.argv[1:]))
"""
SOME = ["tests/maths/relief/test_carry.py", "tests/test_registering.py"]
MORE = [*SOME, "tests/maths/test_spaces.py", "tests/maths/relief/test_life.py", "tests/studies/test_sun_moments.py"]


def test_a_seed_draws_the_recorded_examples_here_and_now():
    """Whatever was loaded before. Only another Hypothesis may change the digest: then see that no source of chance came with it."""
    digest = hashlib.sha256()

    whole, real = st.integers(0, 2**32 - 1), st.floats(-1e3, 1e3)
    shares = st.floats(0.0, 1.0).filter(lambda x: x > 0.1).map(lambda x: 2.0 * x)
    kinds = st.tuples(whole, real, st.sampled_from("abc"), st.lists(st.tuples(st.booleans(), st.floats())), shares)

    @hypothesis.seed(1)
    @hypothesis.settings(max_examples=500)
    @hypothesis.given(kinds)
    def draw(drawn):
        digest.update(repr(drawn).encode())

    draw()
    assert digest.hexdigest() == RECORDED


def drawn(tmp_path, name, paths, *options, start=("-m", "pytest"), hash_seed="0"):
    """The digest of each property test's examples in a process of its own."""
    out = tmp_path / name
    words = [sys.executable, *start, "-p", "tests.drawn", "--drawn", str(out), "-p", "no:cacheprovider", *options, *paths]
    hashed = os.environ | {"PYTHONHASHSEED": hash_seed}
    done = subprocess.run(words, cwd=ROOT, env=hashed, capture_output=True, text=True, timeout=250)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(out.read_text())


def test_examples_do_not_depend_on_what_is_loaded_nor_on_what_ran_before(tmp_path):
    alone = drawn(tmp_path, "alone", SOME)
    within = drawn(tmp_path, "within", MORE, "--order-seed", "3", start=("-c", LOADS_ALL), hash_seed="5")
    assert len(alone) == 4 and len(within) > 10
    assert list(within) != sorted(within) and {name: within[name] for name in alone} == alone
