"""A sun study: the sun at N moments of a day over one place. No bpy; the command line, the operator and the animation share it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import degrees

import numpy as np

from ...errors import SettingsError
from ...maths.choices import require
from ...maths.sun import RISEN_RAD, Clock, Place, daylight, direction_ws, horizontal, refracted
from ...maths.view import Light
from ...settings.groups import Settings

DEFAULT_STEPS = 9


@dataclass(frozen=True, slots=True)
class Moment:
    """The sun at one time of the day: clock hours, azimuth from north over east and apparent elevation in radians, world direction."""

    hours: float
    azimuth_rad: float
    elevation_rad: float
    is_up: bool
    direction_ws: tuple[float, float, float]

    @property
    def time(self) -> str:
        """HH:MM."""
        return clock_text(self.hours)

    @property
    def caption(self) -> str:
        """What stands under its picture."""
        height = f"{degrees(self.elevation_rad):.1f}°"
        return f"{self.time}  elevation {height}" + ("" if self.is_up else " (below the horizon)")

    def as_dict(self) -> dict[str, object]:
        """JSON-ready."""
        return {
            "time": self.time,
            "azimuth_deg": degrees(self.azimuth_rad),
            "elevation_deg": degrees(self.elevation_rad),
            "is_up": self.is_up,
            "light_direction": list(self.direction_ws),
        }

    def light(self, model: Light | None = None) -> Light:
        """The sun as a light, in the colour of `model` where that is a sun."""
        direction = np.array(self.direction_ws)
        if model is not None and model.kind == "sun":
            return replace(model, direction_ws=direction, name="sun study")
        return Light("sun", direction, name="sun study")

    def settings(self, settings: Settings) -> Settings:
        """`settings`, with the light out while the sun is down."""
        return settings if self.is_up else settings.replaced(shading={"light_strength": 0.0})


def moment(clock: Clock, place: Place, hours: float) -> Moment:
    """The sun at one time. It is up while its upper rim shows; its light comes from where it is seen, refraction included."""
    azimuth, height = (float(v) for v in horizontal(clock.julian_day(hours), place))
    seen = float(refracted(np.float64(height)))
    direction = direction_ws(azimuth, seen, place.north_offset_rad)
    return Moment(hours, azimuth, seen, height > RISEN_RAD, tuple(float(v) for v in direction))


def moments(clock: Clock, place: Place, start: float | None = None, end: float | None = None, count: int = DEFAULT_STEPS) -> list[Moment]:
    """`count` moments evenly from `start` to `end`, both among them; None: the ends of the day's light (a little inside them).

    Raises `SettingsError` where the sun does not rise and no hours are given, and for hours out of order.
    """
    require(count >= 1, "A sun study needs at least one step.")
    if start is None or end is None:
        light = daylight(clock, place)
        if light is None:
            raise SettingsError(f"The sun does not rise there on {clock.day.isoformat()}: give the hours with --from and --to.")
        start = _rounded_up(light[0]) if start is None else start
        end = _rounded_up(light[1]) - 1 / 60 if end is None else end
    require(0.0 <= start <= end <= 24.0, f"The study must go forward within one day: {clock_text(start)} to {clock_text(end)} does not.")
    return [moment(clock, place, float(hours)) for hours in np.linspace(start, end, count)]


def _rounded_up(hours: float) -> float:
    return float(np.ceil(hours * 60.0) / 60.0)


def clock_text(hours: float) -> str:
    """HH:MM, to the nearest minute."""
    minutes = round(hours * 60.0)
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def clock_hours(text: str) -> float:
    """Hours of HH:MM or HH, 0…24; raises `SettingsError`."""
    match = re.fullmatch(r"(\d{1,2})(?::([0-5]\d))?", text)
    hours = int(match[1]) + int(match[2] or 0) / 60.0 if match else 25.0
    if hours > 24.0:
        raise SettingsError(f"'{text}' is not a time of day: write HH:MM, for example 09:30.")
    return hours
