"""What every test gets: fatal numpy errors, seeded randomness, a user folder of its own for Blender, the CAD files where they are."""

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

ROOT = Path(__file__).resolve().parents[1]
CAD_DEV = ROOT.parent / "shared" / "cad" / "dev"

# Before anything imports bpy, which reads it once: no test sees or writes the developer's own Blender preferences.
_user_resources = tempfile.mkdtemp(prefix="cad-shadow-test-")
atexit.register(shutil.rmtree, _user_resources, ignore_errors=True)
os.environ["BLENDER_USER_RESOURCES"] = _user_resources

hypothesis.settings.register_profile("seeded", derandomize=True, deadline=None, database=None)
hypothesis.settings.load_profile("seeded")


@pytest.fixture(autouse=True)
def strict_numpy():
    """Overflow, division by zero, invalid values and underflow raise."""
    with np.errstate(all="raise"):
        yield


@pytest.fixture(autouse=True)
def seeded(request):
    """The global generators start the same for the same test, whatever ran before."""
    seed = zlib.crc32(request.node.nodeid.encode())
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 - for libraries that use the global one; tests take `rng`


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
