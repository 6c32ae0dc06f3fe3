"""Where the sun stands in the sky, seen from a place on Earth at a moment. numpy only.

Source: J. Meeus, Astronomical Algorithms (2nd edition): Julian day ch. 7, sidereal time (12.4), horizontal coordinates (13.5), (13.6),
refraction (16.4), the sun's coordinates of low accuracy ch. 25 – the formulas that NOAA's Solar Calculator uses too. Between 1800 and
2200 the geometric position is good to 0.01°; refraction at the horizon depends on the weather and adds up to 0.1°.

Not here: the sun's parallax (0.002°), the difference between universal and dynamical time (0.001°), the observer's height.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from math import cos, inf, pi, radians, sin

import numpy as np

from .choices import require

J2000 = 2451545.0  # Julian day of 2000-01-01 12:00
DAYS_PER_CENTURY = 36525.0
RISEN_RAD = radians(-0.833)  # geometric elevation of the sun's centre when its upper rim touches the horizon: refraction and radius
LEAST_REFRACTED_RAD = radians(-1.0)  # below, refraction stays what it is there


@dataclass(frozen=True, slots=True)
class Place:
    """A scene's place on Earth. Latitude positive northwards, longitude positive eastwards, radians.

    `north_offset_rad` turns north from world +Y, clockwise seen from above (as Blender's Sun Position add-on does).
    """

    latitude_rad: float
    longitude_rad: float
    north_offset_rad: float = 0.0

    def __post_init__(self) -> None:
        require(abs(self.latitude_rad) <= pi / 2, "The latitude must lie between -90° and 90°.")
        require(abs(self.longitude_rad) <= pi, "The longitude must lie between -180° and 180°.")
        require(abs(self.north_offset_rad) < inf, "The north offset must be a number.")


@dataclass(frozen=True, slots=True)
class Clock:
    """A day and its clock: `utc_offset_h` hours ahead of universal time (2 in Berlin in summer)."""

    day: date
    utc_offset_h: float = 0.0

    def __post_init__(self) -> None:
        require(abs(self.utc_offset_h) <= 15.0, "The UTC offset must lie between -15 and 15 hours.")

    def julian_day(self, hours: np.ndarray | float) -> np.ndarray:
        """Julian day of the clock's time in hours, 0…24 (Meeus ch. 7; `date` knows the Gregorian calendar)."""
        return self.day.toordinal() + 1721424.5 + (np.asarray(hours, dtype=np.float64) - self.utc_offset_h) / 24.0


def nautical_offset_h(longitude_rad: float) -> float:
    """Hours ahead of universal time of the nautical time zone: whole hours, noon within half an hour of the sun's."""
    return float(round(longitude_rad / pi * 12.0))


def ecliptic(julian_day: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The sun's apparent longitude λ and the obliquity ε of the ecliptic, radians (Meeus (25.2)–(25.8))."""
    t = (np.asarray(julian_day, dtype=np.float64) - J2000) / DAYS_PER_CENTURY
    mean_longitude = 280.46646 + t * (36000.76983 + 0.0003032 * t)
    anomaly = np.radians(357.52911 + t * (35999.05029 - 0.0001537 * t))
    centre = (
        (1.914602 - t * (0.004817 + 0.000014 * t)) * np.sin(anomaly)
        + (0.019993 - 0.000101 * t) * np.sin(2.0 * anomaly)
        + 0.000289 * np.sin(3.0 * anomaly)
    )
    node = np.radians(125.04 - 1934.136 * t)
    longitude = mean_longitude + centre - 0.00569 - 0.00478 * np.sin(node)
    obliquity = 23.439291 - t * (0.0130042 + t * (1.64e-7 - 5.04e-7 * t)) + 0.00256 * np.cos(node)
    return np.radians(longitude) % (2.0 * pi), np.radians(obliquity)


def equatorial(julian_day: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The sun's apparent right ascension 0…2π and declination, radians (Meeus (25.6), (25.7))."""
    longitude, obliquity = ecliptic(julian_day)
    ascension = np.arctan2(np.cos(obliquity) * np.sin(longitude), np.cos(longitude)) % (2.0 * pi)
    return ascension, np.arcsin(np.sin(obliquity) * np.sin(longitude))


def hour_angle(julian_day: np.ndarray, longitude_rad: float) -> np.ndarray:
    """The sun's local hour angle in radians, −π…π, 0 when it culminates, growing westwards (Meeus (12.4), ch. 13)."""
    days = np.asarray(julian_day, dtype=np.float64) - J2000
    sidereal = np.radians((280.46061837 + 360.98564736629 * days) % 360.0)
    return (sidereal + longitude_rad - equatorial(julian_day)[0] + pi) % (2.0 * pi) - pi


def horizontal(julian_day: np.ndarray, place: Place) -> tuple[np.ndarray, np.ndarray]:
    """The sun's azimuth, 0…2π from north over east, and its geometric elevation above the horizon, radians (Meeus (13.5), (13.6))."""
    h, declination = hour_angle(julian_day, place.longitude_rad), equatorial(julian_day)[1]
    up = sin(place.latitude_rad) * np.sin(declination) + cos(place.latitude_rad) * np.cos(declination) * np.cos(h)
    north = cos(place.latitude_rad) * np.sin(declination) - sin(place.latitude_rad) * np.cos(declination) * np.cos(h)
    east = -np.cos(declination) * np.sin(h)
    return np.arctan2(east, north) % (2.0 * pi), np.arctan2(up, np.hypot(east, north))


def refracted(elevation_rad: np.ndarray) -> np.ndarray:
    """The elevation at which the sun is seen, and its light arrives, in mean weather (Meeus (16.4): 1010 hPa, 10 °C). Never lower."""
    h = np.degrees(np.maximum(elevation_rad, LEAST_REFRACTED_RAD))
    minutes = 1.02 / np.tan(np.radians(h + 10.3 / (h + 5.11)))
    return elevation_rad + np.radians(np.maximum(minutes, 0.0) / 60.0)


def direction_ws(azimuth_rad: np.ndarray, elevation_rad: np.ndarray, north_offset_rad: float = 0.0) -> np.ndarray:
    """(…, 3) unit vectors towards the sun: world +Y is north and +X east until the north offset turns them."""
    angle = np.asarray(azimuth_rad) + north_offset_rad
    flat = np.cos(elevation_rad)
    return np.stack([np.sin(angle) * flat, np.cos(angle) * flat, np.broadcast_to(np.sin(elevation_rad), angle.shape)], axis=-1)


def daylight(clock: Clock, place: Place) -> tuple[float, float] | None:
    """Hours between which the sun is up that day, at most 0 and 24; None when it does not rise. To a few seconds.

    Where the clock is so far from the sun's that the day holds two pieces of daylight, both ends are the outermost ones.
    """
    hours = np.linspace(0.0, 24.0, 1441)
    height = horizontal(clock.julian_day(hours), place)[1] - RISEN_RAD
    up = np.flatnonzero(height > 0.0)
    if not len(up):
        return None
    first, last = int(up[0]), int(up[-1])
    rise = 0.0 if first == 0 else float(_crossing(hours, height, first - 1))
    fall = 24.0 if last == len(hours) - 1 else float(_crossing(hours, height, last))
    return rise, fall


def _crossing(hours: np.ndarray, height: np.ndarray, i: int) -> float:
    """Where the height passes 0 between samples i and i + 1."""
    return hours[i] + (hours[i + 1] - hours[i]) * height[i] / (height[i] - height[i + 1])
