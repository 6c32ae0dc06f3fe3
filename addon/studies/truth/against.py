"""A picture that was made, against the truth of rays: what `compare` on the command line and in the window both do. No bpy of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...errors import Cancelled, SceneError
from ...maths.anchored_camera import AnchoredCamera
from ...pipeline.job import Job
from ..pending import Cancels
from ..run import Outcome, run
from . import TruthTracer, compare
from .compare import COMPARED_PASSES

MAIN_ALONE = "compare draws the main light '{}' alone, from its middle: rays are traced for one hard light."


def against_truth(outcome: Outcome, is_given_up: Cancels = lambda: False) -> np.ndarray:
    """Trace the outcome's view, add `truth` to its report, and return the difference image (h, w, 3) uint8.

    The frame must have `addon.studies.truth.compare.COMPARED_PASSES`. Seconds per million triangles and per million pixels; any thread.
    Raises `SceneError` without a light, or where the picture shows other surfaces than the scene has (impostors); `Cancelled` some
    milliseconds after `is_given_up()`, which is asked again and again, has become True.
    """

    def go_on() -> None:
        if is_given_up():
            raise Cancelled("Cancelled.")

    job, frame = outcome.job, outcome.frame
    if job.light is None:
        raise SceneError("There is no shadow to compare: the scene has no light. Add one, or choose a direction.")
    if len(frame.lights) > 1 or any(light.samples > 1 for light in frame.lights):
        job = main_light_alone(job)
        frame = run(job, cancelled=is_given_up).frame
        outcome.report["warnings"].append(MAIN_ALONE.format(job.light.name))
    anchor = AnchoredCamera.of(job.camera, job.scene.instance_bounds_ws()).anchor_ws
    tracer = TruthTracer(job.scene, go_on=go_on, anchor_ws=anchor)
    truth = tracer.trace(job.camera, job.light, job.size)
    metrics, difference = compare(frame, truth, job.camera, job.light, job.settings.fit.size, tracer)
    outcome.report["truth"] = metrics
    return np.rint(255.0 * difference).astype(np.uint8)


def main_light_alone(job: Job) -> Job:
    """The job with its main light alone, from its middle."""
    lit = job.scene.lit_by(job.light)
    passes = tuple(dict.fromkeys((*COMPARED_PASSES, *(name for name in job.passes if name != "combined"))))
    return replace(job, scene=lit, others=(), passes=passes, settings=job.settings.replaced(lights={"samples": 0}))


def sentence(truth: dict[str, object]) -> str:
    """The report's `truth` in a line."""
    if not truth["pixels"]:
        return "nothing to compare: no surface in view faces the light"
    return f"{truth['misclassified_pct']:.3f} % misclassified, acne {truth['acne_pct']:.3f} %, leak {truth['leak_pct']:.3f} %"
