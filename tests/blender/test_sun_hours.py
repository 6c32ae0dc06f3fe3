"""Hours of sun on the command line: files, numbers that follow from the almanac alone, mistakes in a line."""

import csv
import json

import numpy as np
import pytest

WHERE = ("--latitude", "48", "--longitude", "11", "--date", "2026-03-21", "--step", "60", "--sky-directions", "64")
TINY = ("--size", "48x32", "--map-size", "128", "--quiet")
TABLE = "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\no plate\nf 1 2 3 4\no floor\nf 5 6 7 8\n"


@pytest.fixture
def table(tmp_path):
    """A level plate over a level floor."""
    path = tmp_path / "in" / "table.obj"
    path.parent.mkdir()
    path.write_text(TABLE)
    return path


def test_a_plate_in_the_open_has_the_whole_day_and_the_whole_sky(main, table, tmp_path):
    out = tmp_path / "out"
    assert main(["sun-hours", str(table), *WHERE, *TINY, "--up-axis", "z", "-o", str(out)]) == 0
    assert sorted(p.name for p in out.iterdir()) == [
        "table_report.json",
        "table_sky_view.png",
        "table_sun_hours.csv",
        "table_sun_hours.exr",
        "table_sun_hours.png",
    ]
    report = json.loads((out / "table_report.json").read_text())["sun_hours"]
    assert report["most"] == pytest.approx(12.2, abs=0.1) and report["suns"] == 13
    rows = {row["object"]: row for row in csv.DictReader((out / "table_sun_hours.csv").read_text().splitlines())}
    plate, floor = (next(row for name, row in rows.items() if word in name) for word in ("plate", "floor"))
    # the first and the last sun stand at about 4°, all above the horizon: nothing shades the plate
    assert float(plate["sun_hours_min"]) == pytest.approx(report["most"], abs=1e-4)
    assert float(plate["sky_view_mean"]) == pytest.approx(1.0, abs=0.02)
    assert float(plate["area_m2"]) == pytest.approx(4.0 * 1.0, rel=0.01)
    assert float(floor["sun_hours_min"]) < float(floor["sun_hours_mean"]) < report["most"]


def test_hours_of_a_range_are_those_of_its_mean_day(main, table, tmp_path, capfd):
    more = ("--to-date", "2026-06-21", "--days", "3", "--sky-directions", "0", "--up-axis", "z")
    assert main(["sun-hours", str(table), *WHERE, *more, *TINY, "-o", str(tmp_path / "out"), "--json"]) == 0
    report = json.loads(capfd.readouterr().out)["sun_hours"]
    assert len(report["days"]) == 3 and 12.5 < report["most"] < 16.0
    assert all(row["sky_view_mean"] is None for row in report["objects"])
    assert not (tmp_path / "out" / "table_sky_view.png").exists()


def test_polar_night_is_said_and_is_no_failure(main, table, tmp_path):
    dark = ("--latitude", "80", "--longitude", "11", "--date", "2026-12-21", "--sky-directions", "0")
    assert main(["sun-hours", str(table), *dark, *TINY, "-o", str(tmp_path / "out")]) == 0
    report = json.loads((tmp_path / "out" / "table_report.json").read_text())
    assert any("does not shine" in line for line in report["warnings"])
    assert all(row["sun_hours_max"] == 0.0 for row in report["sun_hours"]["objects"])


WRONG = [
    (["--to-date", "2026-01-01"], "before"),
    (["--from", "12:00", "--to", "09:00"], "forward"),
    (["--step", "0"], "step"),
]


@pytest.mark.parametrize(("more", "words"), WRONG)
def test_days_and_hours_that_mean_nothing_are_a_misuse(main, table, capfd, more, words):
    assert main(["sun-hours", str(table), *WHERE, *more]) == 2
    assert words in capfd.readouterr().err


def test_the_exact_values_are_the_pictures(room):
    """NaN is where nothing is seen; the picture has the height of the view and a legend."""
    hours = room("studies.sun.hours")
    found = hours.seen_sky(np.array([[[0.5, 0.25, 0.25, 1.0], [0.0, 0.0, 0.0, 0.0]]], np.float32))
    assert found.tolist() == [[0.25, 0.0]]
