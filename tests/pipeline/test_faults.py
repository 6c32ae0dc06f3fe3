"""The driver fails somewhere, or Esc is pressed: one line says so, and the next pictures are as if nothing had been.

Every point is tried by `python -m benchmarks.faults`; here a part of them, another one for each case and kind.
"""

import pytest

from addon.errors import DriverError, UserError
from addon.pipeline.gl.context import GpuWorker
from addon.pipeline.renderer import Renderer
from benchmarks.fault_jobs import CASES, PLAIN, Reference, drawn, driver_fault, escapes
from benchmarks.gl_faults import KINDS, Points, injected, makers

SPREAD = 3


@pytest.fixture(scope="module")
def references():
    return {name: Reference(job) for name, job in CASES.items()}


@pytest.mark.parametrize("case", CASES)
def test_a_driver_that_fails_costs_a_line_and_the_next_pictures_are_right(references, case):
    reference = references[case]
    points = len(reference.points) - (0 if case == "a picture" else reference.first)
    for number in range(SPREAD):
        at = len(reference.points) - 1 - number * points // SPREAD
        fault = driver_fault(reference, at, KINDS[(number + len(case)) % len(KINDS)])
        assert not fault.wrong, fault


@pytest.mark.parametrize("case", ["a picture", "impostors"])
def test_esc_at_every_stage_leaves_the_next_pictures_right(references, case):
    found = list(escapes(references[case]))
    assert len(found) >= 5
    assert not [fault for fault in found if fault.wrong]


def test_the_points_are_found_where_the_driver_makes_things():
    assert {"buffer", "texture", "texture_array", "framebuffer", "renderbuffer", "program", "vertex_array"} <= set(makers())
    assert not {"clear", "enable", "finish", "release"} & set(makers())
    assert {"buffer", "program", "TexImage3D", "RenderbufferStorage", "CheckFramebufferStatus"} <= set(Reference(PLAIN).points)


def test_memory_that_ran_out_unnoticed_is_a_line_and_no_picture():
    with injected(Points()) as points:
        worker = GpuWorker()
        try:
            points.noted.append((worker.call(lambda context: context), "GL_OUT_OF_MEMORY"))
            with pytest.raises(DriverError, match="not enough graphics memory"):
                drawn(Renderer(worker), PLAIN)
            assert drawn(Renderer(worker), PLAIN)["combined"].any()
        finally:
            worker.close()


def test_a_defect_in_a_job_leaves_no_half_made_state_to_the_next():
    worker = GpuWorker()
    try:
        first = worker.call(lambda context: context)
        with pytest.raises(ZeroDivisionError):
            worker.call(lambda context: 1 // 0)
        assert worker.call(lambda context: context) is not first
        kept = worker.call(lambda context: context)

        def refused(_context):
            raise UserError("too large")

        with pytest.raises(UserError):
            worker.call(refused)
        assert worker.call(lambda context: context) is kept, "what is refused costs no context"
    finally:
        worker.close()
