"""Hours of direct sun and the share of the sky that is seen: pixel by pixel, and object by object over their surfaces. No bpy."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, replace

import numpy as np

from ...images.scale_bar import scaled_picture
from ...maths.light_set import LightSet, all_round
from ...pipeline.job import Job
from ...pipeline.reach_choice import COSINES, ReachChoice
from ..pending import Cancels, Progress, waited
from ..run import Outcome, run, submit_task
from ..surface_samples import SurfaceSamples, surface_samples
from .days import SKY_DIRECTIONS

LARGEST = 8192  # texels a side
PASSES = ("combined", "depth", "normal", "object")
COLUMNS = ("object", "area_m2", "samples", "sun_hours_mean", "sun_hours_min", "sun_hours_max", "sky_view_mean")


@dataclass(frozen=True, eq=False)
class HoursAsked:
    """The suns, weighted in hours; the directions that the sky is looked for in (0: not at all)."""

    suns: LightSet
    sky_directions: int = SKY_DIRECTIONS

    @property
    def most(self) -> float:
        """Hours of a place that nothing shades and that faces every sun."""
        return float(self.suns.weights.sum())


@dataclass(frozen=True, eq=False)
class SunHours:
    """What came of it. Of pixels (h, w), NaN where nothing is seen: `hours` and `sky_view`; None where nobody asked for them.

    `samples` places on the objects, with their hours and their sky (S,).
    """

    asked: HoursAsked
    outcome: Outcome | None
    hours: np.ndarray | None
    sky_view: np.ndarray | None
    samples: SurfaceSamples | None
    sample_hours: np.ndarray | None
    sample_sky: np.ndarray | None

    def channels(self) -> dict[str, np.ndarray]:
        """The pixels' exact values as channels of an EXR file: hours, and the share of the sky where it was asked for."""
        images = {"sun_hours": self.hours, "sky_view": self.sky_view}
        return {name: image.astype(np.float32) for name, image in images.items() if image is not None}

    @property
    def shade(self) -> np.ndarray:
        """(h, w) 0…1 how much each pixel's surface looks at the camera, for its shape to be seen under the colours."""
        normals, camera = self.outcome.frame.passes["normal"], self.outcome.job.camera
        return np.abs(normals @ camera.direction_ws.astype(np.float32))


def sun_hours(job: Job, asked: HoursAsked, say: Progress, is_given_up: Cancels, *, pixels: bool = True, objects: bool = True) -> SunHours:
    """Count, on the worker, waiting for it; raises as `run.run` does. Maps have twice the size that the job's settings give them."""
    parts = Parts(say, pixels * 2 + objects * 2)
    outcome = hours = sky = samples = sample_hours = sample_sky = None
    if pixels:
        shown = replace(job, passes=PASSES, measure=False, impostors=None)
        outcome = run(shown, lambda fraction, stage: say(0.02 * fraction, stage), is_given_up)
        nothing = ~np.isfinite(outcome.frame.passes["depth"])
        found = pixel_hours(shown, asked, parts, is_given_up)
        hours, sky = (None if image is None else np.where(nothing, np.nan, image) for image in found)
    if objects:
        samples = surface_samples(job.scene)
        sample_hours, sample_sky = hours_at(job, asked, samples.points_ws, samples.normals_ws, parts, is_given_up)
    return SunHours(asked, outcome, hours, sky, samples, sample_hours, sample_sky)


class Parts:
    """Several pieces of work, one after another, as one progress."""

    def __init__(self, say: Progress, count: int) -> None:
        self._say, self._count, self._done = say, max(count, 1), 0

    def next(self) -> Progress:
        """The progress of the next piece."""
        begin, self._done = self._done, self._done + 1
        return lambda fraction, stage: self._say((begin + fraction) / self._count, stage)


def map_size(job: Job) -> int:
    """Texels a side of each sun's map: twice those of the picture's maps, of which there are several for one view."""
    return min(2 * job.settings.fit.size, LARGEST)


def pixel_hours(job: Job, asked: HoursAsked, parts: Parts, is_given_up: Cancels) -> tuple[np.ndarray, np.ndarray | None]:
    """(h, w) hours and (h, w) share of the sky of what the camera sees."""
    from ...pipeline.reach_tasks import sums_of_pixels  # loads OpenGL

    size = map_size(job)
    sun = waited(submit_task(sums_of_pixels, job, asked.suns, ReachChoice(size)), parts.next(), is_given_up)
    sky, say = None, parts.next()
    if asked.sky_directions:
        lights = all_round(asked.sky_directions)
        sums = waited(submit_task(sums_of_pixels, job, lights, ReachChoice(size, sums=COSINES)), say, is_given_up)
        sky = seen_sky(sums)
    return sun[..., 0], sky


def hours_at(
    job: Job, asked: HoursAsked, points_ws: np.ndarray, normals_ws: np.ndarray, parts: Parts, is_given_up: Cancels
) -> tuple[np.ndarray, np.ndarray | None]:
    """(P,) hours and (P,) share of the sky at places (P, 3) on surfaces: those of the side that has more of either."""
    from ...pipeline.reach_tasks import sums_at_places  # loads OpenGL

    size = map_size(job)
    sun = waited(submit_task(sums_at_places, job, points_ws, normals_ws, asked.suns, ReachChoice(size)), parts.next(), is_given_up)
    sky, say = None, parts.next()
    if asked.sky_directions:
        both = np.concatenate([points_ws, points_ws]), np.concatenate([normals_ws, -normals_ws])
        lights = all_round(asked.sky_directions)
        sums = waited(submit_task(sums_at_places, job, *both, lights, ReachChoice(size, sums=COSINES)), say, is_given_up)
        sky = seen_sky(sums).reshape(2, -1).max(axis=0)
    return sun[:, :2].max(axis=1), sky


def seen_sky(sums: np.ndarray) -> np.ndarray:
    """(…) the sky view factor ∫ V max(n·ω, 0) dω / π over the upper half, 1 of open level ground; of sums (…, 4) with cosines."""
    return np.where(sums[..., 3] > 0.0, sums[..., 1] / np.maximum(sums[..., 3], 1e-9), 0.0)


def hours_picture(found: SunHours, title: str) -> np.ndarray:
    """(h + legend, w, 3) uint8: the hours of the pixels in colour above their scale."""
    return scaled_picture(found.hours, max(found.asked.most, 1e-3), title, found.shade)


def sky_picture(found: SunHours) -> np.ndarray:
    """(h + legend, w, 3) uint8: the share of the sky in colour above its scale."""
    return scaled_picture(found.sky_view, 1.0, "share of the sky that is seen", found.shade)


def object_rows(names: tuple[str, ...], found: SunHours) -> list[dict[str, object]]:
    """A row of `COLUMNS` for every object with a surface: means over its area, least and most of its places."""
    samples, rows = found.samples, []
    for number in np.unique(samples.object_id):
        own = samples.object_id == number
        hours, sky = found.sample_hours[own], None if found.sample_sky is None else float(found.sample_sky[own].mean())
        values = (names[number], float(samples.areas[number]), len(hours), float(hours.mean()), float(hours.min()), float(hours.max()), sky)
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


def csv_text(rows: list[dict[str, object]]) -> str:
    """The rows as a CSV file with a head."""
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()})
    return out.getvalue()
