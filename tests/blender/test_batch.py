"""Batches on the command line: folders and patterns, what is done stays done, crashes cost one input, one sheet of everything."""

import errno
import io
import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

SMALL = ("--size", "96x64", "--map-size", "128", "--preset", "fast")
CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]


def write_box(path, height=1):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        "o box\n" + "".join(f"v {x} {y} {z * height}\n" for x, y, z in CORNERS) + "".join(f"f {a} {b} {c} {d}\n" for a, b, c, d in FACES)
    )


@pytest.fixture
def parts(tmp_path):
    """a.obj, b.obj, sub/a.obj, a note that is no model."""
    folder = tmp_path / "parts"
    for i, name in enumerate(("a", "b", "sub/a")):
        write_box(folder / f"{name}.obj", i + 1)
    (folder / "notes.txt").write_text("not a model")
    return folder


def files_below(folder):
    return {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}


# ---- what is named


def names(room, inputs, recursive=False):
    return [below.as_posix() for _, below in room("cli.batch.items").expanded([str(i) for i in inputs], recursive)]


def test_folders_and_patterns_stand_for_the_models_in_them(room, parts):
    assert names(room, [parts]) == ["a.obj", "b.obj"]
    assert names(room, [parts], recursive=True) == ["a.obj", "b.obj", "sub/a.obj"]
    assert names(room, [parts / "*.obj"]) == ["a.obj", "b.obj"]
    assert names(room, [parts / "**" / "a.*"]) == ["a.obj", "sub/a.obj"]
    assert names(room, [parts / "b.obj", parts]) == ["b.obj", "a.obj"], "each input once"


def test_what_names_nothing_is_an_input_that_fails_with_its_reason(main, parts, tmp_path, capfd):
    report = tmp_path / "all.json"
    empty = tmp_path / "empty"
    empty.mkdir()
    inputs = [str(empty), str(parts / "*.step"), str(parts / "a.obj")]
    assert main(["analyse", *inputs, "--report", str(report), "--quiet", *SMALL]) == 1
    assert [len(r["errors"]) for r in json.loads(report.read_text())] == [1, 1, 0]
    assert len(capfd.readouterr().err.strip().splitlines()) == 2


def test_no_two_inputs_share_their_results(room):
    unique = room("cli.batch.items").unique_stems
    below = [Path(p) for p in ("a.obj", "a.stl", "sub/a.obj", "b.obj", "a_obj.ply", "b.obj")]
    stems = unique(below)
    assert len(set(stems)) == len(below)
    assert stems[2:4] == [Path("sub/a"), Path("b_obj")]


# ---- what was done before


@pytest.fixture
def run(main, tmp_path):
    """Run preview into out/; gives the exit code and the time each result was written."""

    def preview(*arguments):
        code = main(["preview", *map(str, arguments), "-o", str(tmp_path / "out"), "--quiet", *SMALL])
        return code, {name: path.stat().st_mtime_ns for name, path in files_below(tmp_path / "out").items() if name.endswith(".png")}

    return preview


def test_resume_does_only_what_is_missing_or_changed(run, parts, tmp_path):
    code, first = run(parts, "--recursive")
    assert code == 0
    assert set(first) == {"a_combined.png", "b_combined.png", "sub/a_combined.png"}
    assert run(parts, "--recursive", "--resume") == (0, first)
    write_box(parts / "b.obj", 7)
    (tmp_path / "out" / "sub" / "a_combined.png").unlink()
    code, second = run(parts, "--recursive", "--resume")
    assert {name for name in first if second[name] != first[name]} == {"b_combined.png", "sub/a_combined.png"}
    os.utime(parts / "a.obj", (1, 1))
    assert run(parts, "--recursive", "--resume") == (0, second), "touched, but the same content"


def test_resume_does_all_again_when_something_else_is_asked_for(run, parts):
    _, first = run(parts)
    for other in (("--warp", "psm"), ("--view", "top"), ("--light-direction", "1,1,3")):
        _, second = run(parts, "--resume", *other)
        assert all(second[name] != first[name] for name in first), other
        first = second


def test_resume_does_a_failed_input_again_and_keeps_the_others(run, parts, tmp_path):
    (parts / "c.obj").write_text("nothing")
    code, first = run(parts)
    assert code == 1
    write_box(parts / "c.obj")
    code, second = run(parts, "--resume")
    assert code == 0
    assert set(second) - set(first) == {"c_combined.png"}
    assert all(second[name] == first[name] for name in first)


def test_a_changed_companion_counts(room, tmp_path):
    stamp, item = room("cli.batch.stamp"), room("cli.batch.items").Item
    write_box(tmp_path / "m.obj")
    (tmp_path / "m.mtl").write_text("newmtl red\nKd 1 0 0\n")
    model = item(str(tmp_path / "m.obj"), "m", tmp_path / "m")
    report = stamp.stamped({"errors": []}, stamp.stamp_of(model, "x"), [], tmp_path)
    model.report_path.write_text(json.dumps(report))
    assert stamp.done_before(model, "x", tmp_path) == report
    assert stamp.done_before(model, "y", tmp_path) is None
    (tmp_path / "m.mtl").write_text("newmtl red\nKd 0 1 0\n")
    assert stamp.done_before(model, "x", tmp_path) is None


def test_every_option_that_changes_a_result_changes_the_digest(room):
    digest, parse = room("cli.batch.stamp").request_digest, room("cli.parser").build_parser().parse_args
    plain = ["preview", "a.obj"]
    same = (["--quiet"], ["--json"], ["-o", "x"], ["--report", "r.json"], ["--jobs", "3"], ["--resume"], ["--contact-sheet"])
    other = (["--format", "exr"], ["--passes", "depth"], ["--size", "8x8"], ["--pcf", "9"], ["--preset", "fast"], ["--units", "mm"])
    assert {digest(parse(plain + more)) for more in same} == {digest(parse(plain))}
    assert len({digest(parse(plain + more)) for more in ([], *other)}) == len(other) + 1


def test_a_single_inputs_report_keeps_to_the_contract(main, parts, tmp_path):
    main(["preview", str(parts / "a.obj"), "-o", str(tmp_path / "out"), "--quiet", *SMALL])
    assert "batch" not in json.loads((tmp_path / "out" / "a_report.json").read_text())


# ---- several processes


def test_jobs_give_the_pictures_of_one_process_in_the_order_of_the_inputs(main, room, parts, tmp_path, capfd):
    shutil.copy(parts / "notes.txt", parts / "aa.stl")
    reports = {}
    for jobs, folder in (("1", "one"), ("2", "two")):
        where = tmp_path / folder
        code = main(["preview", str(parts), "-o", str(where), "--report", str(where / "all.json"), "--jobs", jobs, "--quiet", *SMALL])
        assert code == 1
        reports[folder] = json.loads((where / "all.json").read_text())
    assert [Path(r["input"]).name for r in reports["two"]] == ["a.obj", "aa.stl", "b.obj"]
    assert [r["errors"] for r in reports["one"]] == [r["errors"] for r in reports["two"]]
    for name in ("a_combined.png", "b_combined.png"):
        assert np.array_equal(load(room, tmp_path / "one" / name), load(room, tmp_path / "two" / name))
    assert sum("aa.stl" in line for line in capfd.readouterr().err.splitlines()) == 2, "each run says once why"


@pytest.fixture
def crashing(room, monkeypatch, tmp_path):
    """Workers of a few lines instead of Blender: they die at inputs called 'crash', and talk a lot as Blender does."""
    import sys

    workers = room("cli.batch.workers")
    script = tmp_path / "worker.py"
    script.write_text(
        "import json, os, sys\n"
        "print('Blender 9.9 (hash abc)')\n"
        "for line in sys.stdin:\n"
        "    source, name, stem = json.loads(line)\n"
        "    if 'crash' in name: os._exit(11)\n"
        "    print('chatter'); print(sys.argv[1] + json.dumps([{'input': name, 'errors': [], 'warnings': []}, 'fine']), flush=True)\n"
    )
    monkeypatch.setattr(workers, "worker_command", lambda argv: ([sys.executable, str(script), workers.MARK], dict(os.environ)))
    return workers


def test_a_crash_costs_only_the_input_it_happened_at(crashing, room):
    item = room("cli.batch.items").Item
    items = [item(n, n, Path(n)) for n in ("a", "crash 1", "b", "c", "crash 2", "d")]
    answers = {done.name: report for done, (report, _) in crashing.answers(items, [], 2)}
    assert set(answers) == {i.name for i in items}
    for name, report in answers.items():
        assert bool(report["errors"]) == ("crash" in name)
    assert "exit code 11" in answers["crash 1"]["errors"][0]


class DeadPipe(io.StringIO):
    """The pipe to a process that has ended, as Windows has it: no BrokenPipeError, but errno 22."""

    def flush(self):
        raise OSError(errno.EINVAL, "Invalid argument")

    def close(self):
        super().close()
        raise OSError(errno.EINVAL, "Invalid argument")


def test_a_pipe_that_breaks_as_on_windows_costs_its_input_alone(room):
    workers, item = room("cli.batch.workers"), room("cli.batch.items").Item
    worker = workers.Worker([])
    worker._process = type("Dead", (), {"stdin": DeadPipe(), "stdout": io.StringIO(), "wait": lambda self: 3})()
    report, _ = worker.answer(item("a", "a", Path("a")))
    assert "exit code 3" in report["errors"][0]


def test_giving_up_early_leaves_no_process_and_no_thread(crashing, room):
    import threading

    item = room("cli.batch.items").Item
    before = set(threading.enumerate())
    running = crashing.answers([item(str(n), str(n), Path(str(n))) for n in range(50)], [], 3)
    next(running)
    running.close()
    assert set(threading.enumerate()) <= before


# ---- how far it is


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_gets_a_bar_and_anything_else_plain_lines(room):
    progress = room("cli.batch.progress").Progress
    for stream in (Terminal(), io.StringIO()):
        shown = progress(3, stream)
        for i in range(3):
            shown.say(f"line {i}")
            shown.advance()
        shown.close()
        text = stream.getvalue()
        assert all(f"line {i}\n" in text for i in range(3))
        assert ("3/3" in text or "\r" in text) == stream.isatty()
    quiet = Terminal()
    shown = progress(3, quiet, is_quiet=True)
    shown.say("no")
    shown.complain("yes")
    assert quiet.getvalue() == "yes\n"


def test_the_bar_leaves_no_thread(room):
    import threading

    before = set(threading.enumerate())
    shown = room("cli.batch.progress").Progress(5, Terminal())
    shown.advance()
    shown.close()
    assert set(threading.enumerate()) <= before


# ---- the sheet


def load(room, path):
    return room("cli.batch.sheet").read_picture(path)


def test_the_contact_sheet_shows_every_input_and_marks_failures(main, room, parts, tmp_path):
    (parts / "bad.stl").write_text("nothing")
    out = tmp_path / "out"
    assert main(["preview", str(parts), "-o", str(out), "--contact-sheet", "--quiet", *SMALL]) == 1
    sheet = load(room, out / "contact_sheet.png")
    small = load(room, out / "a_combined.png")
    found = [
        (y, x)
        for y in range(sheet.shape[0] - 63)
        for x in range(sheet.shape[1] - 95)
        if np.array_equal(sheet[y, x : x + 96, :3], small[0, :, :3]) and np.array_equal(sheet[y : y + 64, x : x + 96, :3], small[..., :3])
    ]
    assert len(found) == 1, "the picture itself, unchanged, once"


@pytest.mark.parametrize("kind", ["exr", "npz"])
def test_pictures_of_other_formats_reach_the_sheet_as_displayed(main, room, parts, tmp_path, kind):
    for form in ("png", kind):
        main(["preview", str(parts / "a.obj"), "-o", str(tmp_path / form), "--format", form, "--contact-sheet", "--quiet", *SMALL])
    sheets = [load(room, tmp_path / form / "contact_sheet.png") for form in ("png", kind)]
    assert np.abs(sheets[0] - sheets[1]).mean() < 0.01


def test_compare_and_analyse_know_batches_too(room):
    parse = room("cli.parser").build_parser().parse_args
    assert parse(["analyse", "x", "--resume", "--jobs", "2"]).jobs == 2
    assert parse(["compare", "x", "--contact-sheet"]).contact_sheet
    for command in (["analyse", "x", "--contact-sheet"], ["preview", "x", "--jobs", "0"]):
        with pytest.raises(SystemExit):
            parse(command)


# ---- sun study


PLACE = ("--latitude", "51.5", "--longitude", "-0.13", "--date", "2026-06-21", "--utc-offset", "1")


def test_sun_study_writes_a_sheet_and_the_moments(main, room, parts, tmp_path):
    out = tmp_path / "out"
    hours = ("--from", "03:00", "--to", "13:00", "--steps", "3", "--pictures")
    assert main(["sun-study", str(parts / "a.obj"), "-o", str(out), *PLACE, *hours, "--quiet", *SMALL]) == 0
    singles = [f"a_sun_{i + 1:03d}_{t}.png" for i, t in enumerate(("0300", "0800", "1300"))]
    assert sorted(p.name for p in out.iterdir()) == sorted([*singles, "a_sun_study.png", "a_report.json"])
    moments = json.loads((out / "a_report.json").read_text())["sun_study"]["moments"]
    assert [m["is_up"] for m in moments] == [False, True, True]
    assert moments[0]["lit_share"] == 0.0 < moments[1]["lit_share"]
    assert moments[2]["elevation_deg"] == pytest.approx(61.9, abs=0.2)
    night, day = (load(room, out / singles[i])[..., :3].mean() for i in (0, 2))
    assert night < day


def test_a_single_picture_is_that_of_a_preview_under_the_same_light(main, room, parts, tmp_path):
    out = tmp_path / "out"
    main(["sun-study", str(parts / "a.obj"), "-o", str(out), *PLACE, "--from", "10:00", "--steps", "1", "--pictures", "--quiet", *SMALL])
    light = json.loads((out / "a_report.json").read_text())["sun_study"]["moments"][0]["light_direction"]
    main(["preview", str(parts / "a.obj"), "-o", str(out), "--light-direction", ",".join(map(repr, light)), "--quiet", *SMALL])
    assert np.array_equal(load(room, out / "a_sun_001_1000.png"), load(room, out / "a_combined.png"))


def test_sun_study_refuses_what_is_no_day_or_hour(main, parts, capfd):
    for wrong in (("--date", "2026-02-30"), ("--from", "25:00"), ("--steps", "0")):
        assert main(["sun-study", str(parts / "a.obj"), *PLACE, *wrong]) == 2
    assert main(["sun-study", str(parts / "a.obj"), *PLACE, "--from", "13:00", "--to", "12:00", "--quiet", *SMALL]) == 1
    assert "forward within one day" in capfd.readouterr().err


# ---- presets


def test_a_preset_lies_below_the_other_options(main, parts, tmp_path):
    report = tmp_path / "r.json"
    arguments = ["--preset", "sharp", "--map-size", "64", "--size", "64x48", "--report", str(report), "--quiet"]
    assert main(["analyse", str(parts / "a.obj"), *arguments]) == 0
    used = json.loads(report.read_text())["settings"]
    assert (used["test"]["kind"], used["shading"]["samples"], used["fit"]["size"]) == ("triangle", 16, 64)


def test_an_unknown_preset_fails_with_a_line(main, parts, capfd):
    assert main(["analyse", str(parts / "a.obj"), "--preset", "shiny", "--quiet"]) == 1
    assert "no preset 'shiny'" in capfd.readouterr().err
