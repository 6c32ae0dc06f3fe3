"""Several lights, and lights with a size: which hard lights a picture is the sum of, and how they are added up. Worker thread only.

A source of light (`maths.view.LightSource`) is the mean of its samples. A picture of L sources after K rounds is the mean of pictures, one
for each sample k < K of each soft source, and K times the same one for each hard source, whose lights are L times as strong. So it can be
stopped after any round, and more rounds can be added to those there are. All lights take turns in one set of shadow maps.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import radians

from ..maths.view import Camera, Light, LightSource
from .job import Job
from .passes.gbuffer import GBuffer
from .passes.light_sums import LightSums


@dataclass(frozen=True, eq=False)
class SummedView:
    """A view that lights are added up for: what the camera sees, the sums, and how many of its pixels make a side of the picture's;
    `layers` of what is see-through before it, the nearest first."""

    camera: Camera
    gbuffer: GBuffer
    sums: LightSums
    side: int = 1
    layers: tuple[SummedView, ...] = ()

    @property
    def all(self) -> tuple[SummedView, ...]:
        """It and its layers."""
        return self, *self.layers


@dataclass(frozen=True, eq=False)
class HardLight:
    """A hard light of a source, its colour multiplied by the number of sources, and its part in the mean (not normalised)."""

    source: int
    light: Light
    part: float


AddLight = Callable[[Job, Sequence[SummedView], HardLight], None]
"""Draw the maps of a job with a hard light, and add a part of what it lights to the sums of all views."""


def sources_of(job: Job) -> tuple[LightSource, ...]:
    """What lights the picture, with the settings' softness; empty where one hard light, or none, is all: there is nothing to add up."""
    if job.settings.shading.display in ("aliasing", "partitions"):
        return ()
    found = tuple(_sized(source, job) for source in (job.light, *job.others) if source is not None)
    return found if len(found) > 1 or any(source.is_soft for source in found) else ()


def _sized(source: LightSource, job: Job) -> LightSource:
    lights = job.settings.lights
    if not isinstance(source, Light):
        return source
    if lights.samples == 0:
        return source.hard
    if source.kind == "sun" and lights.sun_angle_deg is not None:
        source = replace(source, half_angle_rad=radians(lights.sun_angle_deg) / 2.0)
    return source.softened(lights.softness)


def rounds_of(job: Job, sources: Sequence[LightSource]) -> int:
    """How many samples each soft source has in the picture: what the settings say, or what the job asks for so far."""
    if not any(source.is_soft for source in sources):
        return 1
    wanted = max(job.settings.lights.samples, 1)
    return wanted if job.rounds is None else max(1, min(job.rounds, wanted))


def steps(sources: Sequence[LightSource], begin: int, end: int) -> Iterator[HardLight]:
    """The hard lights to add to go on from `begin` rounds to `end`."""
    for i, source in enumerate(sources):
        if not source.is_soft:
            yield HardLight(i, _brighter(source.sample(0), len(sources)), float(end - begin))
            continue
        for k in range(begin, end):
            yield HardLight(i, _brighter(source.sample(k), len(sources)), 1.0)


def _brighter(light: Light, factor: int) -> Light:
    return light if factor == 1 else replace(light, color=tuple(c * factor for c in light.color))


def begin_or_go_on(views: Sequence[SummedView], holds: Hashable, job: Job, sources: Sequence[LightSource]) -> None:
    """Keep what the views' sums hold if it is `holds` (None: never), and no more rounds of it than the job has; else begin anew."""
    known, most = {(view.sums.holds, view.sums.rounds) for view in views}, rounds_of(job, sources)
    if holds is not None and len(known) == 1:
        (held, rounds), *_ = known
        if held == holds and rounds <= most:
            return
    for view in views:
        view.sums.clear()
        view.sums.holds = holds


def add_up(job: Job, views: Sequence[SummedView], sources: Sequence[LightSource], add: AddLight, go_on: Callable[[float], None]) -> None:
    """Bring the sums of all views, which hold equally many rounds, to those of the job. `go_on(fraction)` may raise."""
    begin, end = views[0].sums.rounds, rounds_of(job, sources)
    todo = list(steps(sources, begin, end))
    for number, step in enumerate(todo):
        go_on(number / len(todo))
        lit = replace(job, scene=job.scene.lit_by(step.light), light=step.light, others=())
        add(lit, views, step)
        for view in views:
            view.sums.added(step.part)
    for view in views:
        view.sums.rounds = end
