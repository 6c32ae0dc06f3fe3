"""What a frame costs: wall and processor time, measured where it is drawn. A task of the renderer, see `Renderer.submit`."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from .device import Device
from .frame import Frame
from .gl.gl_raw import finish
from .job import Job
from .renderer import Ticket, render_frame


class FrameCost(NamedTuple):
    """Milliseconds: on the wall, and of all processors together (user and system, all threads of the process)."""

    wall_ms: float = 0.0
    cpu_ms: float = 0.0


@contextmanager
def costing() -> Iterator[list[FrameCost]]:
    """A list that holds, afterwards, what was done meanwhile cost."""
    out, wall, cpu = [], time.perf_counter(), time.process_time()
    yield out
    out.append(FrameCost((time.perf_counter() - wall) * 1e3, (time.process_time() - cpu) * 1e3))


def costed_frame(device: Device, job: Job, ticket: Ticket) -> tuple[Frame, FrameCost]:
    """The frame, and what it cost until the GPU had done with it."""
    with costing() as cost:
        frame = render_frame(device, job, ticket)
        finish(device.context)
    return frame, cost[0]


def cost_of_frame(device: Device, job: Job, ticket: Ticket) -> FrameCost:
    """What the frame cost; the frame stays where it is."""
    return costed_frame(device, job, ticket)[1]
