"""The suns of days against known day lengths and what holds of any sum over them."""

from datetime import date
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.sun import Clock, Place, daylight, nautical_offset_h
from addon.studies.sun.days import SunSpan, suns
from tests.margins import agree, at_most

days = st.dates(date(1990, 1, 1), date(2060, 12, 31))
places = st.builds(lambda a, b: Place(radians(a), radians(b)), st.integers(-60, 60), st.integers(-180, 180))


def span(place, day, **more):
    return SunSpan(Clock(day, nautical_offset_h(place.longitude_rad)), more.pop("last", day), **more)


LONDON = Place(radians(51.5074), radians(-0.1278))


@pytest.mark.parametrize(
    ("day", "hours"), [(date(2024, 6, 20), 16 + 38 / 60), (date(2024, 12, 21), 7 + 50 / 60), (date(2024, 3, 20), 12.17)]
)
def test_londons_days_are_as_long_as_the_almanac_says(day, hours):
    """timeanddate.com: 16:38:19 on 20 June, 7:49:41 on 21 December, about 12:10 on 20 March 2024."""
    agree(suns(span(LONDON, day), LONDON).weights.sum(), hours, abs=0.04)


@given(places, days, st.sampled_from([1.0, 5.0, 7.5, 60.0, 240.0]))
def test_the_weights_of_a_day_are_its_length(place, day, step):
    lights, light = suns(span(place, day, step_min=step), place), daylight(Clock(day, nautical_offset_h(place.longitude_rad)), place)
    agree(lights.weights.sum(), light[1] - light[0], abs=2e-3)
    at_most(lights.weights, step / 60.0 + 1e-9)


@given(places, days)
def test_every_sun_is_a_direction_near_or_above_the_horizon(place, day):
    lights = suns(span(place, day, step_min=30.0), place)
    agree(np.linalg.norm(lights.directions_ws, axis=1), 1.0, abs=1e-12)
    assert (lights.directions_ws[:, 2] > -0.01).all()


@given(places, days, st.integers(0, 400), st.integers(1, 15))
def test_a_range_weighs_its_days_alike(place, day, more, most):
    last = date.fromordinal(day.toordinal() + more)
    asked = span(place, day, last=last, most_days=most, step_min=60.0)
    assert len(asked.days) == min(more + 1, most) == len(set(asked.days))
    assert day <= asked.days[0] and asked.days[-1] <= last
    mean = np.mean([suns(span(place, one, step_min=60.0), place).weights.sum() for one in asked.days])
    agree(suns(asked, place).weights.sum(), mean, abs=1e-9)


def test_hours_given_cut_the_day():
    whole, cut = (suns(span(LONDON, date(2026, 6, 21), start=a, end=b), LONDON) for a, b in ((None, None), (10.0, 14.0)))
    agree(cut.weights.sum(), 4.0, abs=1e-9)
    assert whole.weights.sum() > 16.0 and len(suns(span(LONDON, date(2026, 12, 21), start=22.0), LONDON)) == 0


def test_polar_night_has_no_sun_and_polar_day_all_hours():
    place = Place(radians(78.0), radians(15.0))
    assert len(suns(span(place, date(2026, 12, 21)), place)) == 0
    agree(suns(span(place, date(2026, 6, 21)), place).weights.sum(), 24.0, abs=1e-9)


def test_north_turns_the_suns_with_it():
    turned = Place(LONDON.latitude_rad, LONDON.longitude_rad, radians(90.0))
    a, b = (suns(span(p, date(2026, 6, 21), step_min=60.0), p).directions_ws for p in (LONDON, turned))
    agree(b, np.stack([a[:, 1], -a[:, 0], a[:, 2]], axis=-1), abs=1e-9)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"last": date(2026, 6, 1)}, "before"),
        ({"step_min": 0.0}, "step"),
        ({"start": 9.0, "end": 8.0}, "forward"),
        ({"most_days": 0}, "day"),
    ],
)
def test_what_cannot_be_counted_is_refused_in_a_line(more, words):
    with pytest.raises(SettingsError, match=words):
        span(LONDON, date(2026, 6, 21), **more)
