"""What every test gets: fatal numpy errors, seeded randomness, any order asked for, a user folder of its own for Blender, the CAD files.

Property tests draw the same examples on every machine, on both Pythons, alone and in any order. Hypothesis itself would take its seed from
the test's source (whose tokens differ between Pythons) and a twentieth of its numbers from the constants of the modules loaded so far.
"""

import atexit
import os
import random
import shutil
import subprocess
import tempfile
import zlib
from pathlib import Path

import hypothesis
import numpy as np
import pytest
from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants

ROOT = Path(__file__).resolve().parents[1]
CAD_DEV = ROOT.parent / "shared" / "cad" / "dev"

# Before anything imports bpy, which reads it once: no test sees or writes the developer's own Blender preferences.
_user_resources = tempfile.mkdtemp(prefix="cad-shadow-test-")
atexit.register(shutil.rmtree, _user_resources, ignore_errors=True)
os.environ["BLENDER_USER_RESOURCES"] = _user_resources

# The clock decides nothing: neither a deadline nor a slow machine fails a test. `derandomize` covers what is drawn outside a test's call.
hypothesis.settings.register_profile(
    "seeded",
    max_examples=100,
    derandomize=True,
    deadline=None,
    database=None,
    print_blob=False,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("seeded")


providers._get_local_constants = Constants  # none, whatever is loaded; private, so test_determinism.py sees to it that it works


def pytest_addoption(parser):
    """`--order-seed N`: files, and the tests of each, in an order that only N decides; `--examples-at-most N`, as in `./dev quick`."""
    parser.addoption("--order-seed", type=int, metavar="N", help="run the files, and the tests in each, in the order that N gives")
    parser.addoption("--examples-at-most", type=int, metavar="N", help="no more examples than N of each property test")


def pytest_collection_modifyitems(config, items):
    """Shuffled by the hash of N and the name, so that a part of the suite keeps its order within the whole; examples cut."""
    if (most := config.getoption("examples_at_most")) is not None:
        draw_at_most(most, items)
    order = config.getoption("order_seed")
    if order is not None:

        def place(item) -> list[int]:
            return [zlib.crc32(f"{order} {name}".encode()) for name in (item.nodeid.split("::")[0], item.nodeid)]

        items.sort(key=place)


def draw_at_most(most, items):
    """Every property test among the items draws no more than so many examples: the first of those it always draws."""
    for test in {item.obj for item in items if hypothesis.is_hypothesis_test(getattr(item, "obj", None))}:
        used = getattr(test, "_hypothesis_internal_use_settings", hypothesis.settings.default)
        test._hypothesis_internal_use_settings = hypothesis.settings(used, max_examples=min(most, used.max_examples))


def pytest_report_header(config):
    """The order is named, so that a failure can be had again."""
    order = config.getoption("order_seed")
    return None if order is None else f"order seed: {order}"


@pytest.fixture(autouse=True)
def strict_numpy():
    """Overflow, division by zero, invalid values and underflow raise."""
    with np.errstate(all="raise"):
        yield


@pytest.fixture(autouse=True)
def seeded(request):
    """The global generators, and Hypothesis, start the same for the same test, whatever ran before."""
    seed = zlib.crc32(request.node.nodeid.encode())
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 - for libraries that use the global one; tests take `rng`
    if hypothesis.is_hypothesis_test(request.function):
        hypothesis.seed(seed)(request.function)


@pytest.fixture
def rng(request) -> np.random.Generator:
    """A generator seeded by the test's name."""
    return np.random.default_rng(zlib.crc32(request.node.nodeid.encode()))


@pytest.fixture(scope="session")
def cad_dev() -> Path:
    """The folder of real CAD files that lies beside a developer's checkout; without it the test is skipped."""
    if not (CAD_DEV / "manifest.json").is_file():
        pytest.skip("needs the CAD files of ../shared/cad/dev")
    return CAD_DEV


@pytest.fixture(scope="session")
def user_resources() -> Path:
    """Blender's user folder for this run (BLENDER_USER_RESOURCES), removed at the end."""
    return Path(_user_resources)


@pytest.fixture(scope="session")
def x_display():
    """The name of a virtual X screen of this run's own: of the Xvfb installed, or of the one in `./dev gui-test`'s chroot."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"), "cad-shadow-preview", "gui")
    roots = sorted(ready.parent for ready in cache.glob("*/.ready")) if hasattr(os, "getuid") and os.getuid() == 0 else []
    command = ["Xvfb"] if shutil.which("Xvfb") else ["chroot", str(roots[0]), "Xvfb"] if roots else None
    if command is None:
        pytest.skip("needs Xvfb (apt install xvfb, or ./dev gui-test once)")
    reader, writer = os.pipe()
    options = ["-displayfd", str(writer), "-screen", "0", "320x240x24", "-nolisten", "tcp"]
    server = subprocess.Popen([*command, *options], pass_fds=(writer,), stderr=subprocess.DEVNULL)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        number = pipe.readline().strip()
    yield f":{number}"
    server.terminate()
    server.wait(20)
