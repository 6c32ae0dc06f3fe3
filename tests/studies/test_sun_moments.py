"""The moments of a sun study, and the sheet of its pictures; no Blender."""

from datetime import date
from math import degrees, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.images.contact_sheet import contact_sheet, fitted, shrunk
from addon.images.lettering import lettered, printable
from addon.maths.sun import Clock, Place
from addon.settings.groups import Settings
from addon.studies.sun.moments import clock_hours, clock_text, moment, moments
from tests.margins import agree

LONDON = Place(radians(51.5), radians(-0.13))
JUNE = Clock(date(2026, 6, 21), 1.0)


def test_moments_go_evenly_from_start_to_end():
    assert [m.time for m in moments(JUNE, LONDON, 8.0, 16.0, 5)] == ["08:00", "10:00", "12:00", "14:00", "16:00"]
    assert [m.time for m in moments(JUNE, LONDON, 8.0, 16.0, 1)] == ["08:00"]


def test_without_hours_the_study_spans_the_daylight():
    found = moments(JUNE, LONDON, count=7)
    assert all(m.is_up for m in found)
    assert 0.0 < degrees(min(m.elevation_rad for m in found)) + 0.9 < 2.0
    assert max(degrees(m.elevation_rad) for m in found) == pytest.approx(90 - 51.5 + 23.4, abs=1.0)


def test_the_suns_light_moves_from_east_to_west_over_the_south():
    day = moments(JUNE, LONDON, count=9)
    assert [m.azimuth_rad for m in day] == sorted(m.azimuth_rad for m in day)
    assert day[0].direction_ws[0] > 0.7 > -0.7 > day[-1].direction_ws[0]
    noon = moment(JUNE, LONDON, 13.0).direction_ws
    assert noon[1] < 0.0
    assert abs(noon[0]) < 0.03


def test_the_light_is_out_while_the_sun_is_down():
    night, day = moment(JUNE, LONDON, 1.0), moment(JUNE, LONDON, 12.0)
    assert (night.is_up, day.is_up) == (False, True)
    assert "below the horizon" in night.caption
    assert night.settings(Settings()).shading.light_strength == 0.0
    assert day.settings(Settings()) == Settings()


def test_a_polar_night_asks_for_hours():
    tromso, december = Place(radians(69.65), radians(18.96)), Clock(date(2026, 12, 21), 1.0)
    with pytest.raises(SettingsError, match="does not rise"):
        moments(december, tromso)
    assert not any(m.is_up for m in moments(december, tromso, 0.0, 24.0, 5))


@pytest.mark.parametrize("hours", [(17.0, 9.0), (-1.0, 3.0), (3.0, 25.0)])
def test_hours_out_of_order_are_refused(hours):
    with pytest.raises(SettingsError, match="forward"):
        moments(JUNE, LONDON, *hours)


@given(st.integers(0, 24 * 60))
def test_clock_text_and_hours_are_inverse(minutes):
    assert round(clock_hours(clock_text(minutes / 60)) * 60) == minutes


@pytest.mark.parametrize("text", ["25:00", "9.5", "12:60", "noon", "24:01", ""])
def test_what_is_no_time_of_day_is_refused(text):
    with pytest.raises(SettingsError, match="HH:MM"):
        clock_hours(text)


@given(st.integers(1, 40), st.integers(1, 40), st.data())
def test_shrinking_keeps_the_mean_and_the_range(height, width, data):
    rng = np.random.default_rng(height * 41 + width)
    picture = rng.random((height, width, 3))
    small = shrunk(picture, data.draw(st.integers(1, height)), data.draw(st.integers(1, width)))
    agree(small.mean(axis=(0, 1)), picture.mean(axis=(0, 1)), abs=1e-6)
    assert small.min() >= picture.min() - 1e-6
    assert small.max() <= picture.max() + 1e-6


def test_shrinking_by_a_whole_number_is_the_mean_of_blocks(rng):
    picture = rng.random((12, 18, 4))
    assert np.allclose(shrunk(picture, 4, 6), picture.reshape(4, 3, 6, 3, 4).mean(axis=(1, 3)), atol=1e-6)


def test_pictures_keep_their_proportions_and_are_never_enlarged(rng):
    assert fitted(rng.random((90, 160, 3)), (80, 80)).shape == (45, 80, 3)
    assert np.allclose(fitted(picture := rng.random((9, 16, 3)), (80, 80)), picture, atol=1e-7)


def test_a_sheet_holds_every_picture_in_reading_order():
    colors = np.linspace(0.3, 0.9, 5)
    sheet = contact_sheet([np.full((20, 60, 4), (c, 0.0, 0.0, 1.0)) for c in colors], ["jan 12:00"] * 5, columns=3)
    red = np.where((sheet[..., 1] == 0.0), sheet[..., 0], 0.0)
    for i, c in enumerate(colors):
        y, x = np.nonzero(np.isclose(red, c))
        assert len(y) == 20 * 60
        assert (y.mean() > sheet.shape[0] / 2, int(3 * x.mean() / sheet.shape[1])) == (i >= 3, i % 3)
    ink = np.isclose(sheet[..., :3], 0.92).all(axis=-1)
    assert ink.sum() == 5 * lettered("jan 12:00").sum()


def test_transparent_pictures_show_the_paper():
    sheet = contact_sheet([np.zeros((10, 10, 4))], [""])
    assert np.ptp(sheet[..., 0]) == 0.0


@pytest.mark.parametrize(
    ("name", "spelt"),
    [
        ("Größe_1", "grosse_1"), ("Pièce façade Nº2", "piece facade no2"), ("Łódź Ærø", "lodz aero"), ("Насос ёлка", "nasos elka"),
        ("Αντλία [2]", "antlia (2)"), ("ＰＵＭＰ–３", "pump-3"), ("Çelik şasi İğne", "celik sasi igne"),
        ("ポンプ1", "<30db><30f3><30d5>1"), ("йод", "jod"), ("щель", "shchel"),
    ],
)  # fmt: skip
def test_names_are_spelt_in_the_letters_there_are(name, spelt):
    assert printable(name) == spelt
    lettered(printable(name))


def test_names_in_other_scripts_stay_apart():
    assert len({printable(name) for name in ("配管", "配線", "泵", "밸브", "وال")}) == 5


def test_captions_are_cut_to_their_tile():
    sheet = contact_sheet([np.zeros((10, 30, 3)), np.zeros((10, 30, 3))], ["x" * 100, ""], columns=2)
    ink = np.isclose(sheet[..., 0], 0.92)
    assert ink.any()
    assert not ink[:, sheet.shape[1] // 2 :].any()
