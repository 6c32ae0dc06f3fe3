"""The suns of a day or of a range of days, each with the time it stands for. No bpy."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import date, timedelta
from math import ceil, degrees

import numpy as np

from ...maths.choices import require
from ...maths.light_set import LightSet
from ...maths.sun import RISEN_RAD, Clock, Place, daylight, direction_ws, horizontal, refracted

DEFAULT_STEP_MIN = 5.0
SKY_DIRECTIONS = 256
MOST_DAYS = 12
"""Days of a longer range that are looked at, unless told."""


@dataclass(frozen=True, slots=True)
class SunSpan:
    """When the sun is counted: the days from that of `clock` to `last`, each between `start` and `end` o'clock (None: all of its light),
    every `step_min` minutes; of a long range `most_days` days, evenly."""

    clock: Clock
    last: date
    step_min: float = DEFAULT_STEP_MIN
    start: float | None = None
    end: float | None = None
    most_days: int = MOST_DAYS

    def __post_init__(self) -> None:
        require(self.last >= self.clock.day, "The last day comes before the first one.")
        require(0.1 <= self.step_min <= 240.0, "The step must lie between 0.1 and 240 minutes.")
        require(self.most_days >= 1, "At least one day must be looked at.")
        ends = 0.0 if self.start is None else self.start, 24.0 if self.end is None else self.end
        require(0.0 <= ends[0] < ends[1] <= 24.0, "The hours must go forward within one day.")

    @property
    def days(self) -> tuple[date, ...]:
        """Those that are looked at: all, or the middles of equal parts of the range."""
        count = (self.last - self.clock.day).days + 1
        parts = min(count, self.most_days)
        return tuple(self.clock.day + timedelta(days=int((i + 0.5) * count / parts)) for i in range(parts))

    def title(self, place: Place) -> str:
        """What stands under a picture of its hours, in the characters of `images.lettering`."""
        first, last = self.clock.day.isoformat(), self.last.isoformat()
        north, east = degrees(place.latitude_rad), degrees(place.longitude_rad)
        when = first if first == last else f"{first} to {last}, a mean day"
        return (
            f"hours of direct sun, {when}, {abs(north):.2f}° {'n' if north >= 0.0 else 's'} {abs(east):.2f}° {'e' if east >= 0.0 else 'w'}"
        )

    def as_dict(self, place: Place) -> dict[str, object]:
        """JSON-ready."""
        return {
            "latitude": degrees(place.latitude_rad),
            "longitude": degrees(place.longitude_rad),
            "north_offset": degrees(place.north_offset_rad),
            "date": self.clock.day.isoformat(),
            "to_date": self.last.isoformat(),
            "days": [day.isoformat() for day in self.days],
            "utc_offset": self.clock.utc_offset_h,
            "step_minutes": self.step_min,
            "from": self.start,
            "to": self.end,
        }


def suns(span: SunSpan, place: Place) -> LightSet:
    """The suns of a span; their weights are hours of a mean day, together as long as the sun is up in the hours asked for.

    The day's light is cut into equal steps, none longer than asked; a step's sun stands in its middle and is counted while its upper rim is
    above the horizon, in the direction that its light comes from (refraction included).
    """
    directions, weights = [np.empty((0, 3))], [np.empty(0)]
    for day in span.days:
        clock = replace(span.clock, day=day)
        hours, step = _middles(clock, place, span)
        azimuth, height = horizontal(clock.julian_day(hours), place)
        up = height > RISEN_RAD
        directions.append(direction_ws(azimuth[up], refracted(height[up]), place.north_offset_rad))
        weights.append(np.full(int(up.sum()), step / len(span.days)))
    return LightSet(np.concatenate(directions), np.concatenate(weights))


def _middles(clock: Clock, place: Place, span: SunSpan) -> tuple[np.ndarray, float]:
    """The middles of the steps between first and last light, and their length, hours."""
    light = daylight(clock, place)
    if light is None:
        return np.empty(0), 0.0
    first = light[0] if span.start is None else max(light[0], span.start)
    last = light[1] if span.end is None else min(light[1], span.end)
    if not first < last:
        return np.empty(0), 0.0
    count = ceil((last - first) * 60.0 / span.step_min - 1e-9)
    step = (last - first) / count
    return first + (np.arange(count) + 0.5) * step, step
