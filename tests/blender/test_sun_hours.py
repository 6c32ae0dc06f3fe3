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


@pytest.fixture
def march(cube_scene):
    """A cube on a plane, in Munich at the equinox, counted coarsely."""
    sun = cube_scene.cad_shadow.sun
    sun.latitude, sun.longitude, sun.year, sun.month, sun.day, sun.hours_step, sun.sky_directions = 48.0, 11.0, 2026, 3, 21, 60.0, 64
    cube_scene.cad_shadow.map_size = 128
    return cube_scene


def values_of(ob, name):
    values = np.empty(len(ob.data.polygons), np.float32)
    ob.data.attributes[name].data.foreach_get("value", values)
    return values


def test_the_button_keeps_the_hours_of_every_face_and_shows_a_picture(march, blend):
    assert blend.ops.cad_shadow.sun_hours() == {"FINISHED"}
    cube = blend.data.objects["Cube"]
    hours, up = values_of(cube, "sun_hours"), {tuple(np.rint(p.normal).astype(int)): p.index for p in cube.data.polygons}
    assert hours[up[0, 0, 1]] == pytest.approx(12.2, abs=0.15), "the top has all day"
    assert hours[up[0, -1, 0]] == pytest.approx(hours[up[0, 0, 1]], abs=1.1), "at the equinox the south has nearly all of it"
    assert hours[up[0, 1, 0]] < 0.6 and hours[up[0, 0, -1]] == 0.0, "the north and the underside have none"
    assert hours[up[1, 0, 0]] == pytest.approx(hours[up[-1, 0, 0]], abs=1.1)
    sky = values_of(cube, "sky_view")
    assert sky[up[0, 0, 1]] == pytest.approx(1.0, abs=0.02) and sky[up[0, -1, 0]] == pytest.approx(0.5, abs=0.03)
    assert any("sun hours" in image.name for image in blend.data.images)
    blend.ops.cad_shadow.sun_hours()
    assert [a.name for a in cube.data.attributes].count("sun_hours") == 1


def test_objects_that_cannot_keep_hours_are_named_and_keep_none(march, blend, room):
    shared = blend.data.objects.new("Twin", blend.data.objects["Cube"].data)
    march.collection.objects.link(shared)
    blend.data.objects["Plane"].modifiers.new("more", "SUBSURF").subdivision_type = "SIMPLE"
    blend.context.view_layer.update()
    faces, complaints = room("blender.sun_hours").read_faces(blend.context)
    assert faces == [] and len(complaints) == 3
    assert any("'Plane' has modifiers" in line for line in complaints) and any("'Twin' shares" in line for line in complaints)


def test_scripts_get_arrays_and_faces(march, api, blend):
    from datetime import date

    when = {"latitude": 48, "longitude": 11, "date": date(2026, 3, 21), "step_minutes": 60}
    found = api.sun_hours(march, **when, sky_directions=16, faces=True, size=(48, 32), map_size=128)
    assert found.hours.shape == (32, 48) and np.nanmax(found.hours) == pytest.approx(found.most, abs=1e-3)
    assert found.picture.shape[1:] == (48, 3) and {row["object"] for row in found.objects} == {"Cube", "Plane"}
    assert found.keep() == 2 and "sun_hours" in blend.data.objects["Plane"].data.attributes


def test_a_blend_file_has_the_hours_of_its_faces(main, table, tmp_path, blend):
    more = ("--sky-directions", "0", "--up-axis", "z", "--blend")
    assert main(["sun-hours", str(table), *WHERE, *more, *TINY, "-o", str(tmp_path / "out")]) == 0
    blend.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "table_sun_hours.blend"))
    kept = [values_of(ob, "sun_hours") for ob in blend.data.objects if ob.type == "MESH"]
    assert len(kept) == 2 and max(values.max() for values in kept) == pytest.approx(12.2, abs=0.15)


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
