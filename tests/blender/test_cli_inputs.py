"""Odd inputs of the command line: each costs itself alone, and none another's results."""

import json
import os
from pathlib import Path

import pytest

from tests.blender.user_folder import BOX, SMALL, posix


@posix
def test_pipes_and_devices_as_inputs_are_one_line_each(main, box, tmp_path, capfd):
    for name in ("p.stl", "p.blend", "p.step"):
        os.mkfifo(box.parent / name)
    (box.parent / "zero.obj").symlink_to("/dev/zero")
    report = tmp_path / "all.json"
    inputs = [str(box.parent / name) for name in ("p.stl", "p.blend", "p.step", "zero.obj", "box.obj")]
    assert main(["analyse", *inputs, "--report", str(report), *SMALL]) == 1
    errors = [one["errors"] for one in json.loads(report.read_text())]
    assert [len(e) for e in errors] == [1, 1, 1, 1, 0]
    assert all("a named pipe" in e[0] or "a device" in e[0] for e in errors[:4])
    assert len(capfd.readouterr().err.strip().splitlines()) == 4


@posix
def test_one_odd_argument_costs_itself_alone(main, box, tmp_path, capfd):
    (box.parent / "..stl").write_bytes(b"no model")
    undecodable = os.fsdecode(os.fsencode(box.parent) + b"/b\xff\x1b[31md.obj")
    Path(undecodable).write_text(BOX)
    inputs = ["", "x" * 10_000, "x" * 300 + ".obj", "a\nforged.obj", str(box.parent / "..stl"), undecodable, str(box)]
    out, report = tmp_path / "out", tmp_path / "all.json"
    assert main(["preview", *inputs, "-o", str(out), "--report", str(report), "--json", *SMALL]) == 1
    said = capfd.readouterr()
    for text in (report.read_text(encoding="utf-8"), said.out[said.out.index("[\n {") :]):  # within a test Blender's chatter comes late
        reports = json.loads(text)
        assert [one["input"] for one in reports] == inputs
        assert [len(one["errors"]) for one in reports] == [1, 1, 1, 1, 1, 0, 0]
    lines = said.err.strip().splitlines()
    assert len(lines) == 5
    assert all(
        line.isprintable() and line.startswith("cad_shadow: ") and "please report" not in line and len(line) < 2500 for line in lines
    )
    assert "\x1b" not in said.out
    assert len(list(out.iterdir())) == 4


@posix
@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="root may look into everything")
def test_folders_that_cannot_be_looked_into_are_said(main, box, tmp_path, capfd):
    closed = box.parent / "closed"
    closed.mkdir(mode=0)
    try:
        assert main(["analyse", str(box.parent), "--recursive", *SMALL]) == 1
        assert "Permission denied" in capfd.readouterr().err
        assert main(["analyse", str(closed), *SMALL]) == 1
        assert "Permission denied" in capfd.readouterr().err
    finally:
        closed.chmod(0o700)


def test_folders_that_fail_to_open_count_as_inputs(room, box, monkeypatch):
    """As the test before, for root."""
    closed = box.parent / "closed"
    closed.mkdir()
    real = os.scandir

    def scandir(path):
        if Path(path) == closed:
            raise PermissionError(13, "Permission denied", str(path))
        return real(path)

    monkeypatch.setattr(os, "scandir", scandir)
    named = [path for path, _ in room("cli.batch.items").expanded([str(box.parent)], recursive=True)]
    assert named == [str(box), str(closed)]
    with pytest.raises(room("errors").CadFileError, match="Permission denied"):
        room("scene.cad").read(closed)


@pytest.mark.parametrize("pair", [("a/Part.stl", "b/part.stl"), ("a/Ä.stl", "b/A\u0308.stl"), ("x/STRASSE.obj", "y/straße.obj")])
def test_names_that_some_disk_takes_for_one_get_results_of_their_own(room, pair):
    unique = room("cli.batch.items").unique_stems
    flat = [Path(Path(one).name) for one in pair]
    stems = unique(flat)
    assert len({room("cli.batch.items")._alike(stem) for stem in stems}) == 2
    assert unique([*flat, Path("deck_5.obj"), Path("deck_5")])[2:] == [Path("deck_5_obj"), Path("deck_5")]
