"""Faults while a picture is made: of the driver at every point, and Esc at every stage. What must hold is asked after each.

One line says what went wrong; the picture after it, and the one of before, are those of a worker without faults, to the last bit; nothing
of the driver's is left over; the thread ends.
"""

from __future__ import annotations

import gc
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from addon.errors import Cancelled, UserError
from addon.maths.relief.settings import ImpostorSettings
from addon.maths.view import Light
from addon.pipeline.gl.context import THREAD_NAME, GpuWorker
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer, Ticket
from addon.settings.groups import Settings
from benchmarks.gl_faults import KINDS, Points, injected, names
from tests import scenes

SIZE = (48, 32)
CAMERA, SUN = scenes.look_at((7.0, -8.0, 5.0), (0.0, 0.0, 0.7), near=1.0, far=60.0), scenes.sun(40.0)
SCENE = scenes.scene_of(scenes.floor(), scenes.box((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0)), scenes.ball((2.0, 1.0, 0.6), 0.6))
LAMP = Light("point", None, np.array([3.0, -2.0, 4.0]))
SMALL = Settings().replaced(fit={"size": 64})
IMPOSTORS = ImpostorChoice((ImpostorGroup("ball", (2,), "ball"),), ImpostorSettings(break_even=False, casters="impostor"), alone=True)
PLAIN = Job(scenes.closed_box(), CAMERA, SUN, SMALL, SIZE)
CASES = {
    "a picture": Job(SCENE, CAMERA, SUN, SMALL, SIZE),
    "all passes, edges, 4 samples": Job(
        SCENE,
        CAMERA,
        SUN,
        SMALL.replaced(shading={"samples": 4}, edges={"width": 1.5}),
        SIZE,
        ("combined", "shadow", "depth", "normal", "object", "partition", "aliasing", "texel", "edges"),
    ),
    "object ids, logarithmic maps": Job(
        SCENE, CAMERA, SUN, SMALL.replaced(test={"kind": "id-depth"}, warp={"kind": "log"}, partition={"kind": "z-adaptive"}), SIZE
    ),
    "several depths": Job(SCENE, CAMERA, SUN, SMALL.replaced(test={"kind": "depth", "depths": 4}), SIZE),
    "a lamp": Job(SCENE, CAMERA, LAMP, SMALL.replaced(test={"kind": "depth"}), SIZE),
    "impostors": Job(SCENE, CAMERA, SUN, SMALL.replaced(test={"kind": "depth"}), SIZE, impostors=IMPOSTORS),
}


class Fault(NamedTuple):
    """`name` of the point and how it fails; `wrong`: what did not hold, '' when all did."""

    name: str
    kind: str
    wrong: str


def drawn(renderer: Renderer, job: Job) -> dict[str, np.ndarray]:
    """The passes of a job; raises what it raises."""
    return renderer.submit(job)[0].result(120.0).passes


def differences(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> list[str]:
    """The passes that are not the same to the last bit."""
    return [name for name in one if not np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f")]


class Reference:
    """A case drawn without faults: its pictures, the points it passes after the plain picture, the objects that it leaves."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.said: list[str] = []
        with injected(Points()) as points:
            worker = GpuWorker()
            renderer = Renderer(worker)
            self.plain = drawn(renderer, PLAIN)
            self.first = len(points.passed)
            self.passes = drawn(renderer, job)
            self.points = list(points.passed)
            drawn(renderer, PLAIN)
            drawn(renderer, job)
            self.names = worker.call(names)
            worker.close()

    def after(self, worker: GpuWorker, error: BaseException | None, is_expected: bool = True) -> Iterator[str]:
        """What does not hold after a fault that ended in `error`."""
        if error is None and is_expected and not self.said:
            yield "no word of it"
        elif error is not None and not (isinstance(error, UserError) and str(error).isprintable() and len(str(error)) < 400):
            yield f"{type(error).__name__}: {str(error)[:80]!r} is no line for users"
        for what, job, expected in (("the same picture", self.job, self.passes), ("the one before", PLAIN, self.plain)) * 2:
            try:
                wrong = differences(drawn(Renderer(worker), job), expected)
            except Exception as failure:
                yield f"{what} cannot be drawn afterwards: {type(failure).__name__}: {failure}"
                return
            if wrong:
                yield f"{what} is another one afterwards: {', '.join(wrong)}"
                return
        drawn(Renderer(worker), self.job)
        gc.collect()
        worker.call(lambda context: None)  # after every job what Python has dropped is released
        left = worker.call(names) - self.names
        if left:
            yield f"left over: {dict(left)}"
        if worker.call(lambda context: context.error) != "GL_NO_ERROR":
            yield "an error of the driver is left"


def driver_fault(reference: Reference, at: int, kind: str) -> Fault:
    """The driver fails once, at that point of the case (or of the plain picture before it)."""
    reference.said.clear()
    before = _worker_threads()
    with injected(Points(at, kind)) as points, _logged(reference.said):
        worker, error = GpuWorker(), None
        renderer = Renderer(worker)
        try:
            for job in (PLAIN, reference.job):
                frame = renderer.submit(job)[0].result(120.0)
                reference.said += [one.reason for one in frame.impostors if "memory" in one.reason]
        except Exception as raised:
            error = raised.with_traceback(None)  # whose frames would keep what was half made
            error.__cause__ = error.__context__ = None
        name = points.passed[at] if at < len(points.passed) else "?"
        wrong = "; ".join(reference.after(worker, error))
        worker.close()
    wrong = wrong or ("the thread lives" if _worker_threads() - before else "")
    return Fault(name, kind, wrong)


def _worker_threads() -> set[threading.Thread]:
    """The threads of workers, those of others too."""
    return {thread for thread in threading.enumerate() if thread.name == THREAD_NAME}


@contextmanager
def _logged(lines: list[str]) -> Iterator[None]:
    """What the add-on logs while this lasts."""
    handler, log = logging.Handler(), logging.getLogger("addon.pipeline")
    handler.emit = lambda record: lines.append(record.getMessage())
    before = log.level
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(before)


def driver_faults(reference: Reference, first: int, step: int = 1) -> Iterator[Fault]:
    """Every `step`-th point from `first` on, each in every way."""
    for number, at in enumerate(range(first, len(reference.points), step)):
        for kind in KINDS if step == 1 else (KINDS[number % len(KINDS)],):
            yield driver_fault(reference, at, kind)


def escapes(reference: Reference) -> Iterator[Fault]:
    """Given up at every stage in turn, until there is no further one."""
    worker = GpuWorker()
    drawn(Renderer(worker), PLAIN)
    number, is_over = 0, False
    while not is_over:
        ticket, error = _Impatient(number), None
        try:
            Renderer(worker).queue(reference.job, ticket).result(120.0)
            is_over = True
        except Exception as raised:
            error = raised
        wrong = list(reference.after(worker, error, not is_over))
        wrong += [] if error is None or isinstance(error, Cancelled) else [f"{type(error).__name__} instead of Cancelled"]
        if not is_over:
            yield Fault(ticket.stage, "Esc", "; ".join(wrong))
        number += 1
    worker.close()


class _Impatient(Ticket):
    """A ticket whose owner gives up when the stage of that number begins."""

    def __init__(self, stage: int) -> None:
        super().__init__()
        self._left = stage

    def enter(self, fraction: float, stage: str) -> None:
        """Note the stage; give up at the chosen one."""
        self.is_cancelled = self.is_cancelled or self._left == 0
        self._left -= 1
        super().enter(fraction, stage)
