"""The command line and the user's files: what is asked for is there or the exit code says so, and nothing that was there is lost."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.test_user_files import full_disk

SMALL = ("--size", "96x64", "--map-size", "64", "--quiet")
BOX = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
OLD = b"what the user had"
posix = pytest.mark.skipif(sys.platform == "win32", reason="named pipes, devices and signals as POSIX has them")


@pytest.fixture
def box(tmp_path):
    """A model in in/."""
    path = tmp_path / "in" / "box.obj"
    path.parent.mkdir()
    path.write_text(BOX)
    return path


def below(folder):
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*"))


# ---- a disk that is full, or fails half way


@pytest.fixture
def small_files():
    """From the call on no file of this process grows beyond so many bytes, as on a full disk."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda count: resource.setrlimit(resource.RLIMIT_FSIZE, (count, limits[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@posix
@pytest.mark.parametrize("kind", ["png", "exr"])
def test_a_picture_that_blender_cuts_short_replaces_nothing_and_is_a_failure(main, box, tmp_path, small_files, kind, capfd):
    out = tmp_path / "out"
    out.mkdir()
    (out / f"box_combined.{kind}").write_bytes(OLD)
    small_files(1500)
    code = main(["preview", str(box), "-o", str(out), "--format", kind, *SMALL])
    small_files(resource.RLIM_INFINITY)
    assert code == 1
    assert (out / f"box_combined.{kind}").read_bytes() == OLD
    assert below(out) == [f"box_combined.{kind}"]
    (line,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("cad_shadow")]  # Blender 4.5 has a word on EXR too
    assert f"box_combined.{kind} cannot be written" in line
    assert "make room" in line


@posix
@pytest.mark.parametrize("what", ["plane", "sun", "api"])
def test_every_writer_of_blenders_is_checked(main, room, box, tmp_path, small_files, what, capfd):
    out = tmp_path / "out"
    out.mkdir()
    names = {"plane": "box_impostor.blend", "sun": "box_sun_001_1000.png", "api": "api.png"}
    target = out / names[what]
    target.write_bytes(OLD)
    day = ("--latitude", "51", "--longitude", "0", "--date", "2026-06-21", "--from", "10:00", "--steps", "1", "--pictures")
    if what == "plane":
        small_files(40_000)
        code = main(["impostor", str(box), "-o", str(out), "--plane", "--format", "npz", *SMALL])
    elif what == "sun":
        small_files(1500)
        code = main(["sun-study", str(box), "-o", str(out), *day, *SMALL])
    else:
        picture = room("api").preview(size=(96, 64))
        small_files(200)
        with pytest.raises(room("errors").OutputError, match="came out damaged"):
            picture.save(target, ("combined",))
        code = 1
    small_files(resource.RLIM_INFINITY)
    assert code == 1
    assert target.read_bytes() == OLD
    assert not [name for name in below(out) if name.startswith(".")]


def test_a_full_disk_costs_no_old_picture_and_is_a_failure(main, box, tmp_path):
    place = full_disk(tmp_path)
    if place is None:
        pytest.skip("no file system can be mounted here")
    try:
        for kind in ("png", "exr", "npz"):
            name = "box.npz" if kind == "npz" else f"box_combined.{kind}"
            (place / name).write_bytes(OLD)
        with pytest.raises(OSError, match="No space"):
            (place / "filler").write_bytes(bytes(1 << 20))
        before = below(place)
        for kind in ("png", "exr", "npz"):
            assert main(["preview", str(box), "-o", str(place), "--format", kind, *SMALL]) == 1
        assert below(place) == before
        assert all((place / name).read_bytes() == OLD for name in before if name != "filler")
    finally:
        subprocess.run(["umount", str(place)], check=True)


# ---- targets


@posix
def test_a_report_goes_to_a_plain_file_that_is_no_input(main, box, tmp_path, capfd):
    settings = tmp_path / "s.toml"
    settings.write_text("map_size = 64\n")
    link = tmp_path / "link.json"
    link.symlink_to(box)
    before = {path: path.read_bytes() for path in (box, settings)}
    for target, words in (
        (box, "an input of this run"),
        (settings, "an input of this run"),
        (link, "a link"),
        ("/dev/null", "a device"),
        (tmp_path, "a folder"),
    ):
        code = main(["analyse", str(box), "--settings", str(settings), "--report", str(target), "--size", "96x64", "--quiet"])
        assert code == 2, target
        assert words in capfd.readouterr().err
    assert main(["theory", "--near", "1", "--far", "9", "--settings", str(settings), "--report", str(settings)]) == 2
    assert {path: path.read_bytes() for path in before} == before
    assert Path("/dev/null").is_char_device()


def test_a_report_of_all_never_takes_the_place_of_a_report_of_one(main, box, tmp_path, capfd):
    (box.parent / "other.obj").write_text(BOX)
    out = tmp_path / "out"
    assert main(["preview", str(box.parent), "-o", str(out), "--report", str(out / "box_report.json"), *SMALL]) == 2
    assert not out.exists()
    assert main(["preview", str(box.parent), "-o", str(out), "--report", str(out / "box_combined.png"), *SMALL]) == 1
    assert "was written for" in capfd.readouterr().err
    assert (out / "box_combined.png").read_bytes().startswith(b"\x89PNG")
    assert main(["preview", str(box), "-o", str(out), "--report", str(out / "box_report.json"), *SMALL]) == 0


def test_results_never_replace_textures_or_linked_files_of_the_model(main, box, tmp_path, capfd):
    (box.parent / "any.mtl").write_text("newmtl red\nKd 1 0 0\nmap_bump box_normal.png\n")
    box.write_text("mtllib any.mtl\n" + BOX)
    texture = box.parent / "box_normal.png"
    texture.write_bytes(OLD)
    assert main(["preview", str(box), "-o", str(box.parent), "--passes", "normal", *SMALL]) == 1
    assert "box_normal.png is an input of this run" in capfd.readouterr().err
    assert texture.read_bytes() == OLD


def test_a_plane_never_replaces_the_blend_it_is_made_from(main, cube_scene, blend, tmp_path, capfd):
    first = tmp_path / "a.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(first))
    twin = tmp_path / "a_impostor.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(twin))
    before = twin.read_bytes()
    assert main(["impostor", str(first), str(twin), "-o", str(tmp_path), "--plane", "--format", "npz", *SMALL]) == 1
    assert "a_impostor.blend is an input of this run" in capfd.readouterr().err
    assert twin.read_bytes() == before


@pytest.mark.parametrize("name", ["o{a}", "{blend_name}", "{{x}}", "##", "%d", "ü ö"])
def test_output_folders_and_inputs_of_any_name_get_their_pictures(main, box, tmp_path, name):
    model = box.with_name(f"{name}.obj")
    box.rename(model)
    out = tmp_path / name
    assert main(["preview", str(model), "-o", str(out), *SMALL]) == 0
    assert below(out) == [f"{name}_combined.png", f"{name}_report.json"]


def test_a_folder_beyond_what_blender_can_name_is_one_line(main, box, tmp_path, capfd):
    out = tmp_path.joinpath(*["d" * 200] * 6)
    assert main(["preview", str(box), "-o", str(out), *SMALL]) == 1
    assert "longer than Blender can write to" in capfd.readouterr().err


def compositor(bpy, scene):
    """The scene's node tree of the compositor, empty."""
    if hasattr(scene, "compositing_node_group"):
        scene.compositing_node_group = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
        return scene.compositing_node_group
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree


def output_node(tree, folder, image):
    """A File Output node that writes what comes out of a socket to a folder."""
    node = tree.nodes.new("CompositorNodeOutputFile")
    if hasattr(node, "directory"):
        node.directory, node.file_name = str(folder), "stolen"
        node.file_output_items.new("RGBA", "Image")
    else:
        node.base_path = str(folder)
    tree.links.new(image, node.inputs[0])


@pytest.mark.parametrize("is_in_a_group", [False, True])
def test_file_outputs_of_a_blend_write_nowhere_and_are_said(main, cube_scene, blend, tmp_path, is_in_a_group):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    tree = compositor(blend, cube_scene)
    rendered = tree.nodes.new("CompositorNodeRLayers").outputs[0]
    if is_in_a_group:
        inner = blend.data.node_groups.new("inner", "CompositorNodeTree")
        inner.interface.new_socket("Image", in_out="INPUT", socket_type="NodeSocketColor")
        output_node(inner, elsewhere, inner.nodes.new("NodeGroupInput").outputs[0])
        group = tree.nodes.new("CompositorNodeGroup")
        group.node_tree = inner
        tree.links.new(rendered, group.inputs[0])
    else:
        output_node(tree, elsewhere, rendered)
    blend.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert main(["preview", str(tmp_path / "a.blend"), "-o", str(tmp_path / "out"), *SMALL]) == 0
    assert below(elsewhere) == []
    warnings = json.loads((tmp_path / "out" / "a_report.json").read_text())["warnings"]
    assert any("File Output" in line for line in warnings)
    assert not any(one.mute for group in blend.data.node_groups for one in group.nodes)


def test_a_stereo_scene_gives_one_whole_picture(main, cube_scene, blend, tmp_path):
    cube_scene.render.use_multiview = True
    blend.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert main(["preview", str(tmp_path / "a.blend"), "-o", str(tmp_path / "out"), *SMALL]) == 0
    assert below(tmp_path / "out") == ["a_combined.png", "a_report.json"]
    assert (tmp_path / "out" / "a_combined.png").stat().st_size > 100


# ---- inputs


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


# ---- what was done before


def times(folder):
    return {p.name: p.stat().st_mtime_ns for p in folder.glob("*.png")}


def test_resume_sees_a_changed_preset_and_a_changed_material_file_of_any_name(main, room, box, tmp_path, user_resources):
    (box.parent / "any.mtl").write_text("newmtl red\nKd 1 0 0\n")
    box.write_text("mtllib any.mtl\n" + BOX)
    preset = user_resources / "scripts" / "presets" / room("blender.presets").SUBDIR / "Mine.py"
    preset.parent.mkdir(parents=True, exist_ok=True)
    head = "import bpy\nsettings = bpy.context.scene.cad_shadow\n"
    preset.write_text(head + "settings.warp = 'psm'\n")
    out = tmp_path / "out"
    try:

        def again():
            assert main(["preview", str(box), "-o", str(out), "--resume", "--preset", "mine", *SMALL]) == 0
            return times(out)

        first = again()
        assert again() == first
        preset.write_text(head + "settings.warp = 'tsm'\n")
        second = again()
        assert second != first
        assert json.loads((out / "box_report.json").read_text())["settings"]["warp"]["kind"] == "tsm"
        (box.parent / "any.mtl").write_text("newmtl red\nKd 0 0 1\n")
        third = again()
        assert third != second
        assert again() == third
    finally:
        preset.unlink()


def test_resume_sees_a_changed_library(main, cube_scene, blend, tmp_path):
    out, library, file = tmp_path / "out", tmp_path / "library.blend", tmp_path / "linked.blend"
    blend.data.libraries.write(str(library), {blend.data.objects["Cube"].data})
    with blend.data.libraries.load(str(library), link=True) as (there, here):
        here.meshes = there.meshes
    blend.data.objects["Cube"].data = blend.data.libraries[0].users_id[0]
    blend.ops.wm.save_as_mainfile(filepath=str(file))
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)

    def again():
        assert main(["preview", str(file), "-o", str(out), "--resume", *SMALL]) == 0
        return times(out)

    first = again()
    assert again() == first
    data = library.read_bytes()
    library.write_bytes(data + b"\0")
    os.utime(library, (1, 1))
    assert again() != first


# ---- streams, and where code comes from


def run(*arguments, **options):
    command = [sys.executable, "-m", "addon", *arguments]
    return subprocess.run(command, cwd=options.pop("cwd", ROOT), stdin=subprocess.DEVNULL, timeout=120, **options)


THEORY = ("theory", "--near", "1", "--far", "10")


@posix
@pytest.mark.parametrize("form", [(), ("--json",)])
def test_a_standard_output_that_takes_nothing_is_a_failure_of_one_line(form):
    with Path("/dev/full").open("wb") as full:
        done = run(*THEORY, *form, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert done.stderr.decode().splitlines() == ["cad_shadow: standard output cannot be written (No space left on device)."]
    reader, writer = os.pipe()
    os.close(reader)
    done = run(*THEORY, *form, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert done.returncode == 1
    assert done.stderr.decode().splitlines() == ["cad_shadow: standard output cannot be written (Broken pipe)."]


@posix
def test_closed_streams_cost_only_what_they_were_to_show():
    assert run(*THEORY, preexec_fn=lambda: os.close(1), stderr=subprocess.PIPE).returncode == 1
    assert run(*THEORY, preexec_fn=lambda: os.close(2), stdout=subprocess.PIPE).stdout.startswith(b"view")
    assert run(*THEORY, "--quiet", preexec_fn=lambda: os.closerange(0, 3)).returncode == 0


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-8"])
def test_every_text_can_be_shown_in_every_encoding(encoding):
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    for words in (THEORY, ("preview", "--help"), ("theory", "--help")):
        done = run(*words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        assert done.returncode == 0, done.stderr
        assert done.stderr == b""
        assert len(done.stdout.decode(encoding)) > 100
    assert json.loads(run(*THEORY, "--json", env=environment, stdout=subprocess.PIPE).stdout)


def test_a_worker_takes_no_code_from_the_current_folder(room, tmp_path):
    (tmp_path / "tomllib.py").write_text("raise SystemExit('code of the current folder runs')\n")
    command, environment = room("cli.batch.workers").worker_command([*THEORY, "--quiet"])
    assert command.pop() == "--worker"
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")


# ---- being stopped


@posix
@pytest.mark.parametrize(("number", "jobs"), [(signal.SIGINT, 1), (signal.SIGTERM, 1), (signal.SIGTERM, 2)])
def test_a_batch_that_is_stopped_keeps_what_is_done_and_says_what_is_not(box, tmp_path, user_resources, number, jobs):
    for i in range(40):
        (box.parent / f"b{i}.obj").write_text(BOX)
    out, report = tmp_path / "out", tmp_path / "all.json"
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(user_resources), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "addon", "preview", str(box.parent), "-o", str(out), "--report", str(report), "--jobs", str(jobs)]
    process = subprocess.Popen(
        [*command, "--size", "320x240", "--samples", "4", "--map-size", "64"],
        env=environment,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # a shell's background jobs ignore it
    )
    deadline = time.monotonic() + 90.0
    while len(list(out.glob("*_report.json"))) <= jobs and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 1, said
    assert "Traceback" not in said
    assert "stopped;" in said
    reports = json.loads(report.read_text())
    assert len(reports) == 41
    done = [Path(one["input"]).stem for one in reports if not one["errors"]]
    assert 1 <= len(done) < 41
    assert all(one["errors"] == ["Not done: the run was stopped."] for one in reports if one["errors"])
    whole = {f"{name}_{kind}" for name in done for kind in ("combined.png", "report.json")}
    assert whole <= set(below(out))
    assert not [name for name in below(out) if name.startswith(".")]
    assert len(set(below(out)) - whole) <= 2 * jobs, "those that were at hand may have got some of their files, whole ones"


def test_a_render_under_way_is_given_up_when_asked_to_stop(main, room, box, monkeypatch):
    """In this process: the signal comes while Blender renders, where nothing may be raised."""
    stopping, calls = room("studies.stopping"), []

    engine = room("blender.engine").CadShadowEngine
    deliver = engine._outcome

    def outcome(self, *job):
        calls.append(len(calls))
        os.kill(os.getpid(), signal.SIGINT)
        return deliver(self, *job)

    monkeypatch.setattr(engine, "_outcome", outcome)
    assert main(["analyse", str(box), str(box.parent / "gone.obj"), *SMALL]) == 1
    assert calls == [0]
    assert not stopping.is_asked()
