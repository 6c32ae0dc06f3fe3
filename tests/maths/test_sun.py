"""The sun's position against published values, and against what holds of it everywhere."""

from datetime import date
from math import degrees, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.sun import (
    RISEN_RAD,
    Clock,
    Place,
    daylight,
    direction_ws,
    ecliptic,
    equatorial,
    horizontal,
    hour_angle,
    nautical_offset_h,
    refracted,
)
from tests.margins import agree, at_most


def place(latitude, longitude, north=0.0):
    return Place(radians(latitude), radians(longitude), radians(north))


places = st.builds(lambda a, b: place(a / 100, b / 100), st.integers(-8900, 8900), st.integers(-18000, 18000))
hours_of_day = st.integers(0, 24 * 60).map(lambda minutes: minutes / 60)
days = st.dates(date(1950, 1, 1), date(2099, 12, 31))


def test_julian_day_of_meeus_examples():
    """Meeus ch. 7: 1957-10-04.81 is 2436116.31; 1987-06-19.5 is 2446966.0; 1999-01-01.0 is 2451179.5."""
    assert Clock(date(1957, 10, 4)).julian_day(0.81 * 24) == pytest.approx(2436116.31, abs=1e-9)
    assert Clock(date(1987, 6, 19)).julian_day(12.0) == 2446966.0
    assert Clock(date(1999, 1, 1), 2.0).julian_day(2.0) == 2451179.5


def test_meeus_example_25a():
    """1992-10-13.0: λ 199.90895°, ε 23.43999°, α 198.38083°, δ −7.78507° (Meeus, example 25.a)."""
    day = Clock(date(1992, 10, 13)).julian_day(0.0)
    found = [degrees(v) for v in (*ecliptic(day), *equatorial(day))]
    assert found == pytest.approx([199.90895, 23.43999, 198.38083, -7.78507], abs=2e-4)


def test_the_worked_example_of_nrel_spa():
    """Reda & Andreas 2004, Solar Position Algorithm, A.5: Golden, Colorado, 2003-10-17 12:30:30 UTC−7, azimuth 194.34024°; zenith
    50.11162° with refraction at 820 hPa (0.016°, ours is for sea level: 0.020°)."""
    clock, golden = Clock(date(2003, 10, 17), -7.0), place(39.742476, -105.1786)
    azimuth, elevation = horizontal(clock.julian_day(12 + 30.5 / 60), golden)
    assert degrees(azimuth) == pytest.approx(194.34024, abs=0.01)
    assert 90 - degrees(refracted(elevation)) == pytest.approx(50.11162, abs=0.01)


# US Naval Observatory, "Earth's Seasons": instants of equinoxes and solstices, universal time
SEASONS = ((date(2020, 3, 20), 3 + 50 / 60, 0), (date(2020, 6, 20), 21 + 44 / 60, 90), (date(2020, 9, 22), 13 + 31 / 60, 180),
           (date(2020, 12, 21), 10 + 2 / 60, 270), (date(2024, 3, 20), 3 + 6 / 60, 0), (date(2024, 6, 20), 20 + 51 / 60, 90))  # fmt: skip


@pytest.mark.parametrize(("day", "hours", "longitude"), SEASONS, ids=str)
def test_seasons_begin_when_the_almanac_says(day, hours, longitude):
    off = degrees(ecliptic(Clock(day).julian_day(hours))[0]) - longitude
    assert abs((off + 180) % 360 - 180) < 0.01


@pytest.mark.parametrize(("day", "minutes"), [(date(2021, 2, 11), -14.2), (date(2021, 11, 3), 16.45), (date(2021, 4, 15), 0.0)], ids=str)
def test_the_equation_of_time_at_its_extremes(day, minutes):
    """Sundial minus clock: least about −14 min 12 s on 11 February, most 16 min 27 s on 3 November, zero about 15 April."""
    assert degrees(hour_angle(Clock(day).julian_day(12.0), 0.0)) * 4 == pytest.approx(minutes, abs=0.3)


# published times of sunrise and sunset (upper rim, sea level), in minutes: London 2024-06-21 BST, 2024-12-21 GMT; Sydney 2024-12-21 AEDT
RISES = ((51.5074, -0.1278, date(2024, 6, 21), 1.0, "04:43", "21:22"), (51.5074, -0.1278, date(2024, 12, 21), 0.0, "08:04", "15:54"),
         (-33.8688, 151.2093, date(2024, 12, 21), 11.0, "05:41", "20:06"))  # fmt: skip


@pytest.mark.parametrize(("latitude", "longitude", "day", "offset", "rise", "fall"), RISES, ids=str)
def test_sunrise_and_sunset_to_two_minutes(latitude, longitude, day, offset, rise, fall):
    found = daylight(Clock(day, offset), place(latitude, longitude))
    for hours, text in zip(found, (rise, fall), strict=True):
        assert hours * 60 == pytest.approx(int(text[:2]) * 60 + int(text[3:]), abs=2.0)


def test_polar_day_and_night():
    tromso = place(69.65, 18.96)
    assert daylight(Clock(date(2024, 6, 21), 2.0), tromso) == (0.0, 24.0)
    assert daylight(Clock(date(2024, 12, 21), 1.0), tromso) is None


@given(places, days)
def test_the_sun_is_up_between_its_rise_and_its_set(where, day):
    clock = Clock(day, nautical_offset_h(where.longitude_rad))
    found = daylight(clock, where)
    hours = np.linspace(0.0, 24.0, 97)
    up = horizontal(clock.julian_day(hours), where)[1] > RISEN_RAD
    if found is None:
        assert not up.any()
        return
    outside = (hours < found[0] - 0.02) | (hours > found[1] + 0.02)
    assert not up[outside].any()
    for end in found:
        if 0.0 < end < 24.0:
            agree(horizontal(clock.julian_day(end), where)[1], RISEN_RAD, abs=1e-5)


@given(places, days)
def test_the_sun_culminates_in_the_meridian_at_90_degrees_less_the_distance_from_its_declination(where, day):
    clock = Clock(day)
    noon = 12.0 - degrees(hour_angle(clock.julian_day(12.0), where.longitude_rad)) / 15.0
    moment = clock.julian_day(noon)
    azimuth, elevation = horizontal(moment, where)
    declination = equatorial(moment)[1]
    agree(degrees(elevation), 90 - abs(degrees(declination - where.latitude_rad)), abs=0.02)
    if abs(declination - where.latitude_rad) > radians(5.0):  # nearer to the zenith the azimuth is ill-conditioned
        at_most(abs(np.sin(azimuth)), 0.02)
        assert np.cos(azimuth) * (declination - where.latitude_rad) > 0.0


@given(places, days, hours_of_day)
def test_the_clock_does_not_matter_only_the_instant(where, day, hours):
    here, there = Clock(day, 0.0), Clock(day, 3.5)
    agree(horizontal(here.julian_day(hours), where), horizontal(there.julian_day(hours + 3.5), where), abs=1e-9)


@given(st.integers(-9000, 8990).map(lambda v: radians(v / 100)))
def test_refraction_lifts_and_keeps_the_order(elevation):
    lifted = refracted(np.array([elevation, elevation + 1e-3]))
    assert lifted[0] >= elevation
    assert lifted[1] > lifted[0]


def test_refraction_at_the_horizon_is_about_the_suns_diameter():
    assert degrees(refracted(0.0)) == pytest.approx(29.0 / 60.0, abs=0.5 / 60.0)
    assert degrees(refracted(radians(-0.5))) == pytest.approx(0.0, abs=0.1)


def test_directions_follow_the_compass():
    assert np.allclose(direction_ws(0.0, 0.0), (0, 1, 0))
    assert np.allclose(direction_ws(pi / 2, 0.0), (1, 0, 0))
    assert np.allclose(direction_ws(1.0, pi / 2), (0, 0, 1))
    assert np.allclose(direction_ws(0.0, 0.0, pi / 2), (1, 0, 0)), "north turned clockwise lies in +X"
    assert direction_ws(np.zeros(5), np.zeros(5)).shape == (5, 3)


@pytest.mark.parametrize("bad", [(91, 0), (0, 181), (float("nan"), 0)])
def test_places_off_the_map_are_refused(bad):
    with pytest.raises(SettingsError, match="must lie"):
        place(*bad)
