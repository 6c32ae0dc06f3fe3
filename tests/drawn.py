"""A pytest plugin (`-p tests.drawn --drawn FILE`): every property test only draws its examples; FILE names the digest of each test's."""

import hashlib
import json
from pathlib import Path

import hypothesis
import pytest


def pytest_addoption(parser):
    parser.addoption("--drawn", type=Path, required=True, metavar="FILE", help="where to write the digests, as JSON")


class Digests:
    """Notes what each property test draws in place of running it."""

    def __init__(self):
        self.found = {}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if hypothesis.is_hypothesis_test(getattr(item, "obj", None))]

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_call(self, item):
        digest = hashlib.sha256()
        item.obj.hypothesis.inner_test = lambda **drawn: digest.update(repr(drawn).encode())
        self.found[item.nodeid] = digest

    def pytest_unconfigure(self, config):
        config.getoption("drawn").write_text(json.dumps({name: digest.hexdigest() for name, digest in self.found.items()}, indent=1))


def pytest_configure(config):
    config.pluginmanager.register(Digests())
