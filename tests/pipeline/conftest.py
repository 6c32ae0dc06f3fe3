"""One GL worker for all pipeline tests, closed at the end; GL errors are looked for after each test."""

import pytest

from addon.pipeline.gl.context import GpuWorker
from addon.pipeline.renderer import Renderer


@pytest.fixture(scope="session")
def worker():
    """A worker of the tests' own, so that the add-on's shared one is not touched."""
    worker = GpuWorker()
    yield worker
    worker.close()
    assert not worker.is_running


@pytest.fixture
def renderer(worker):
    """A renderer whose context must be without a GL error afterwards."""
    yield Renderer(worker)
    assert worker.call(lambda context: context.error) == "GL_NO_ERROR"


@pytest.fixture(scope="session")
def software_rasteriser(worker):
    """Golden comparisons hold for Mesa's llvmpipe only."""
    name = worker.call(lambda context: context.info["GL_RENDERER"])
    if "llvmpipe" not in name:
        pytest.skip(f"compares with the software rasteriser; this is {name}")
    return name
