"""The command line as a user or a farm meets it: exit codes, files, reports, and the same picture as F12."""

import importlib
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import ROOT

REPORT_KEYS = {
    "input",
    "version",
    "gl",
    "settings",
    "gamma_deg",
    "gamma_lim_deg",
    "partitions",
    "measured",
    "lights",
    "timing_ms",
    "geometry",
    "warnings",
    "errors",
}
PARTITION_KEYS = {"index", "near", "far", "warp_parameter", "eta", "m_x_max", "m_z_max", "storage_factor", "critical_resolution"}
MEASURED_KEYS = {"m_max", "m_p99", "m_p95", "m_median", "share_above_1"}
SMALL = ("--size", "96x64", "--map-size", "128")


@pytest.fixture
def outputs(extension):
    return importlib.import_module(extension.__name__ + ".studies.outputs")


@pytest.fixture
def cube_blend(cube_scene, blend, tmp_path):
    """The cube scene saved, dithered and in AgX as Blender has it by default."""
    cube_scene.render.dither_intensity = 1.0
    cube_scene.view_settings.view_transform = "AgX"
    path = tmp_path / "cube.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def cube_obj(tmp_path):
    """A cube as an OBJ, no camera, no light."""
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
    path = tmp_path / "box.obj"
    path.write_text(
        "o box\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a} {b} {c} {d}\n" for a, b, c, d in faces)
    )
    return path


def report_in(folder, stem):
    return json.loads((folder / f"{stem}_report.json").read_text())


def pixels(bpy, path):
    image = bpy.data.images.load(str(path), check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)[::-1]


def test_preview_of_a_cad_file_writes_picture_and_report(main, cube_obj, tmp_path, blend):
    out = tmp_path / "out"
    assert main(["preview", str(cube_obj), "-o", str(out), "--quiet", *SMALL]) == 0
    assert sorted(p.name for p in out.iterdir()) == ["box_combined.png", "box_report.json"]
    assert np.ptp(pixels(blend, out / "box_combined.png")[..., 0]) > 0.1
    warnings = " ".join(report_in(out, "box")["warnings"])
    assert "no camera" in warnings
    assert "no light" in warnings


def test_the_report_has_exactly_the_contracts_keys(main, cube_blend, tmp_path):
    assert main(["analyse", str(cube_blend), "-o", str(tmp_path / "out"), "--quiet", *SMALL]) == 0
    report = report_in(tmp_path / "out", "cube")
    assert set(report) == REPORT_KEYS
    assert report["partitions"]
    assert all(set(p) == PARTITION_KEYS for p in report["partitions"])
    assert set(report["measured"]) == MEASURED_KEYS | {"perspective", "precision"}
    assert set(report["measured"]["perspective"]) == MEASURED_KEYS
    assert set(report["timing_ms"]) == {"sync", "upload", "shadow", "gbuffer", "shade", "readback", "total"}
    assert set(report["geometry"]) == {"meshes", "instances", "triangles"}
    assert set(report["settings"]) >= {"warp", "partition", "fit", "test", "shading", "impostor"}
    assert report["settings"]["fit"]["size"] == 128
    assert report["geometry"] == {"meshes": 2, "instances": 2, "triangles": 14}


def test_nothing_known_is_null(main, cube_blend, tmp_path):
    main(["analyse", str(cube_blend), "-o", str(tmp_path), "--quiet", "--partition", "none", *SMALL])
    report = report_in(tmp_path, "cube")
    (row,) = report["partitions"]
    assert all(value is not None for value in row.values())
    assert all(value is not None for value in (report["gamma_deg"], report["gamma_lim_deg"], *report["timing_ms"].values()))
    assert all(value is not None for value in report["measured"].values())


def test_an_infinite_warp_parameter_is_null(main, cube_blend, tmp_path):
    main(["analyse", str(cube_blend), "-o", str(tmp_path), "--quiet", "--warp", "uniform", *SMALL])
    rows = report_in(tmp_path, "cube")["partitions"]
    assert [row["warp_parameter"] for row in rows] == [None] * len(rows)
    assert {row["eta"] for row in rows} == {-1.0}


def test_npz_keeps_the_contract(main, cube_blend, tmp_path):
    passes = "combined,shadow,depth,normal,object,partition,aliasing,texel"
    assert main(["preview", str(cube_blend), "-o", str(tmp_path), "--quiet", "--format", "npz", "--passes", passes, *SMALL]) == 0
    data = dict(np.load(tmp_path / "cube.npz"))
    count = len(data["partition_bounds"])
    shapes = {
        "combined": (64, 96, 4),
        "shadow": (64, 96),
        "depth": (64, 96),
        "normal": (64, 96, 3),
        "object": (64, 96),
        "partition": (64, 96),
        "aliasing": (64, 96, 3),
        "view_from_world": (4, 4),
        "clip_from_view": (4, 4),
        "light_direction": (3,),
        "shadow_clip_from_world": (count, 4, 4),
        "partition_bounds": (count, 2),
        "shadow_depth": (count, 128, 128),
    }
    assert {name: array.shape for name, array in data.items()} == shapes
    assert data["object"].dtype == data["partition"].dtype == np.int32
    assert all(data[name].dtype == np.float32 for name in ("combined", "shadow", "depth", "normal", "aliasing", "shadow_depth"))
    assert np.isclose(np.linalg.norm(data["light_direction"]), 1.0)
    assert ((data["shadow"] >= 0.0) & (data["shadow"] <= 1.0)).all()


@pytest.mark.parametrize("warp", ["log", "logpsm", "lispsm-general"])
def test_npz_says_where_every_texel_of_a_logarithmic_map_lies(main, cube_blend, tmp_path, warp):
    """t of LogPSM 5.43 from the file alone, against what drew the maps: what m is the Jacobian of."""
    out = ["-o", str(tmp_path), "--quiet", "--warp", warp, "--partitions", "2"]
    assert main(["preview", str(cube_blend), *out, "--format", "npz", "--passes", "depth,partition,aliasing", *SMALL]) == 0
    data = np.load(tmp_path / "cube.npz")
    if warp == "lispsm-general":
        assert "shadow_log_warp" not in data.files
        return
    numbers = data["shadow_log_warp"]
    assert numbers.shape == (len(data["partition_bounds"]), 5)
    seen = np.argwhere(data["partition"] >= 0)
    y, x = seen.T
    near = data["clip_from_view"]
    z = data["depth"][y, x]
    ndc = np.stack([2.0 * (x + 0.5) / 96 - 1.0, 1.0 - 2.0 * (y + 0.5) / 64], axis=-1)
    view = np.column_stack([ndc / np.diag(near)[:2] * z[:, None], -z, np.ones(len(z))])
    points = view @ np.linalg.inv(data["view_from_world"]).T
    index = data["partition"][y, x]
    clip = np.einsum("pij,pj->pi", data["shadow_clip_from_world"][index], points)
    scale, offset, base, slope, is_divided = numbers[index].T
    t = scale * np.log2(clip[:, 3] / (base + slope * clip[:, 3])) + offset
    s = np.where(is_divided == 1.0, clip[:, 0] / clip[:, 3], clip[:, 0])
    assert set(is_divided) == {1.0 if warp == "logpsm" else 0.0}
    assert (np.abs(s) <= 1.0 + 1e-6).all() and (np.abs(t) <= 1.0 + 1e-6).all()  # every receiver lies in its map
    assert np.ptp(t) > 0.2


def test_npz_matrices_start_from_true_world_coordinates(main, cube_scene, blend, tmp_path):
    for ob in cube_scene.objects:
        ob.location.x += 5000.0
    path = tmp_path / "far.blend"
    blend.ops.wm.save_as_mainfile(filepath=str(path))
    assert main(["preview", str(path), "-o", str(tmp_path), "--quiet", "--format", "npz", *SMALL]) == 0
    data = np.load(tmp_path / "far.npz")
    eye = np.linalg.inv(data["view_from_world"])[:3, 3]
    assert np.allclose(eye, (5006.0, -6.0, 5.0), atol=1e-3)
    corner = data["clip_from_view"] @ data["view_from_world"] @ np.array([5000.0, 0.0, 2.0, 1.0])
    x, y = corner[:2] / corner[3]
    row, column = int((1 - y) / 2 * 64), int((x + 1) / 2 * 96)
    assert np.isclose(data["depth"][row, column], corner[3], rtol=0.02)


def test_combined_is_bit_identical_to_f12(main, cube_blend, blend, tmp_path):
    assert main(["preview", str(cube_blend), "-o", str(tmp_path / "cli"), "--quiet"]) == 0
    blend.ops.wm.open_mainfile(filepath=str(cube_blend))
    scene = blend.context.scene
    scene.render.filepath = str(tmp_path / "f12.png")
    blend.ops.render.render(write_still=True)
    f12, cli = pixels(blend, tmp_path / "f12.png"), pixels(blend, tmp_path / "cli" / "cube_combined.png")
    assert np.array_equal(f12, cli)
    assert len(np.unique(np.rint(f12[..., 0] * 255))) > 8, "dithered and shaded, so that a difference could show"


def test_every_pass_is_written_in_every_format(main, cube_blend, blend, tmp_path):
    passes = ("combined", "shadow", "depth", "normal", "object", "partition", "aliasing", "texel")
    for kind in ("png", "exr"):
        out = tmp_path / kind
        words = ["--quiet", "--format", kind, "--passes", ",".join(passes), "--light-direction", "-1,1,1", *SMALL]
        assert main(["preview", str(cube_blend), "-o", str(out), *words]) == 0
        for name in passes:
            if (name, kind) == ("texel", "exr"):
                assert b"map0.Depth.Z\0" in (out / "cube_texel.exr").read_bytes()[:2000]
                continue
            values = pixels(blend, out / f"cube_{name}.{kind}")[..., :3]
            assert np.ptp(values[np.isfinite(values)]) > 0.0, (kind, name)


def test_exr_values_are_the_npz_values(main, cube_blend, blend, tmp_path):
    for kind in ("exr", "npz"):
        assert (
            main(["preview", str(cube_blend), "-o", str(tmp_path), "--quiet", "--format", kind, "--passes", "normal,shadow", *SMALL]) == 0
        )
    data = np.load(tmp_path / "cube.npz")
    assert np.array_equal(pixels(blend, tmp_path / "cube_shadow.exr")[..., 0], data["shadow"])
    assert np.array_equal(pixels(blend, tmp_path / "cube_normal.exr")[..., :3], data["normal"])


def test_one_bad_input_fails_alone(main, cube_obj, tmp_path, capfd):
    liar = tmp_path / "liar.blend"
    liar.write_bytes(b"solid nothing")
    reports = tmp_path / "all.json"
    inputs = [str(tmp_path / "missing.step"), str(liar), str(cube_obj)]
    assert main(["preview", *inputs, "-o", str(tmp_path / "out"), "--report", str(reports), "--quiet", *SMALL]) == 1
    missing, lying, good = json.loads(reports.read_text())
    assert (len(missing["errors"]), len(lying["errors"]), good["errors"]) == (1, 1, [])
    assert set(missing) == REPORT_KEYS
    assert "not a Blender file" in lying["errors"][0]
    assert (tmp_path / "out" / "box_combined.png").exists()
    errors = capfd.readouterr().err.strip().splitlines()
    assert len(errors) == 2
    assert all("\n" not in line and line.startswith("cad_shadow: ") for line in errors)


ONE = ("preview", "x.obj")
MISUSES = (
    (), ("nonsense",), ("preview",), (*ONE, "--warp", "wavy"), (*ONE, "--size", "0x4"), (*ONE, "--pcf", "7"), (*ONE, "--passes", "beauty"),
    (*ONE, "--partitions", "9"), (*ONE, "--fov-y", "180"), (*ONE, "--eye", "1,2"), (*ONE, "--settings", "nowhere.toml"),
    (*ONE, "--camera", "A", "--view", "iso"), ("theory", "--near", "1"), ("theory", "--near", "2", "--far", "1"),
    ("theory", "--near", "nan", "--far", "1"), ("theory", "--near", "1", "--far", "9", "--points", "100000000"),
    (*ONE, "--near", "5", "--far", "1"), (*ONE, "--near", "nan"), (*ONE, "--far", "inf"), (*ONE, "--light-direction", "0,0,0"),
    (*ONE, "--eye", "1,1,1", "--target", "1,1,1"), (*ONE, "--target", "1,1,1"), (*ONE, "--up", "0,0,0"), (*ONE, "--size", "1x1"),
    (*ONE, "--size", "16385x9"), (*ONE, "--alpha", "-1"), (*ONE, "--margin", "1e308"), (*ONE, "--background", "nan,0,0,1"),
    (*ONE, "--clay", "1,0"), (*ONE, "--warp-parameter", "inf"), (*ONE, "--bias", "1e308"), (*ONE, "--units", "parsec"),
    (*ONE, "--up-axis", "Q"), (*ONE, "--eta", "0", "--warp-parameter", "1"), ("preview", "--deck", "0"), (*ONE, "--jobs", "0"),
    ("bench", "--frames", "0"), ("advise", "x.obj", "--texels", "-5"), ("advise", "x.obj", "--error", "nan"),
    ("impostor-path", "x.obj", "--orbit", "nan"),
    ("sun-study", "x.obj", "--latitude", "95", "--longitude", "0", "--date", "2026-01-01"),
)  # fmt: skip


@pytest.mark.parametrize("arguments", MISUSES, ids=" ".join)
def test_bad_usage_exits_2(main, arguments, capfd):
    assert main(list(arguments)) == 2
    assert capfd.readouterr().err


SETTINGS_FILES = (
    "[fit]\nsize = 64.5", "[fit]\nsize = true", "[test]\npcf = 4.0", "[shading]\nbackground = 'red'", "[shading]\nclay = ['a','b','c']",
    "[shading]\nbackground = [nan,0,0,1]", "[warp]\nkind = 3", "[partition]\nalpha = 3.0", "[partition]\nalpha = ['x']", "[nope]\na = 1",
    "nope = 1", "map_size = 1e400", "map_size = inf", "map_size = '64'", "alpha = 'x'", "warp = 3", "samples = [4]", "= 1",
    "[fit]\nnope = 1",
)  # fmt: skip


@pytest.mark.parametrize("content", SETTINGS_FILES)
def test_a_settings_file_of_wrong_types_exits_2_with_a_line(main, tmp_path, content, capfd):
    settings = tmp_path / "s.toml"
    settings.write_text(content + "\n")
    assert main(["theory", "--near", "1", "--far", "9", "--settings", str(settings)]) == 2
    (line,) = capfd.readouterr().err.strip().splitlines()
    assert line.startswith("cad_shadow: ")


def test_an_infinite_warp_parameter_of_a_settings_file_is_null_in_the_report(main, cube_blend, tmp_path):
    settings = tmp_path / "s.toml"
    settings.write_text("[warp]\nparameter = inf\n")
    assert main(["analyse", str(cube_blend), "-o", str(tmp_path), "--quiet", "--settings", str(settings), *SMALL]) == 0
    assert report_in(tmp_path, "cube")["settings"]["warp"]["parameter"] is None


BAD_VALUES = (
    (("--near", "5000"), "near"), (("--map-size", "1000000"), "map"), (("--camera", "Nobody"), "Nobody"), (("--light", "Nobody"), "Nobody"),
)  # fmt: skip


@pytest.mark.parametrize(("arguments", "word"), BAD_VALUES, ids=lambda value: " ".join(value) if isinstance(value, tuple) else None)
def test_bad_values_for_an_input_exit_1_and_say_why(main, cube_blend, tmp_path, arguments, word):
    report = tmp_path / "report.json"
    assert main(["analyse", str(cube_blend), "--report", str(report), "--quiet", "--size", "96x64", *arguments]) == 1
    (message,) = json.loads(report.read_text())["errors"]
    assert word.lower() in message.lower()
    assert "\n" not in message


def test_an_unwritable_folder_exits_1_and_leaves_nothing(main, cube_obj, tmp_path, capfd):
    blocker = tmp_path / "file"
    blocker.write_text("in the way")
    assert main(["preview", str(cube_obj), "-o", str(blocker / "out"), "--quiet", *SMALL]) == 1
    assert "cannot be written" in capfd.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["box.obj", "file"]


def test_a_failed_write_leaves_no_half_file(outputs, tmp_path):
    target = tmp_path / "report.json"
    target.write_text("old")
    with pytest.raises(ZeroDivisionError), outputs.written(target) as temporary:
        temporary.write_text("half")
        raise ZeroDivisionError
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"report.json": "old"}


def test_settings_file_below_command_line(main, cube_blend, tmp_path):
    settings = tmp_path / "s.toml"
    settings.write_text('map-size = 64\nwarp = "psm"\n[partition]\nkind = "z-log"\ncount = 2\n')
    assert main(["analyse", str(cube_blend), "-o", str(tmp_path), "--quiet", "--settings", str(settings), "--warp", "uniform"]) == 0
    used = report_in(tmp_path, "cube")["settings"]
    assert (used["fit"]["size"], used["warp"]["kind"], used["partition"]["kind"], used["partition"]["count"]) == (64, "uniform", "z-log", 2)


def test_the_scenes_own_settings_are_the_base(main, cube_scene, blend, tmp_path):
    cube_scene.cad_shadow.map_size, cube_scene.cad_shadow.warp = 64, "uniform"
    blend.ops.wm.save_as_mainfile(filepath=str(tmp_path / "own.blend"))
    assert main(["analyse", str(tmp_path / "own.blend"), "-o", str(tmp_path), "--quiet", "--size", "96x64"]) == 0
    used = report_in(tmp_path, "own")["settings"]
    assert (used["fit"]["size"], used["warp"]["kind"]) == (64, "uniform")


def test_negative_vectors_need_no_equals_sign(main, cube_blend, tmp_path):
    arguments = ["--eye", "-9,-9,9", "--target", "0,0,1", "--light-direction", "-1,1,2"]
    assert main(["preview", str(cube_blend), "-o", str(tmp_path), "--quiet", "--format", "npz", *arguments, *SMALL]) == 0
    data = np.load(tmp_path / "cube.npz")
    assert np.allclose(np.linalg.inv(data["view_from_world"])[:3, 3], (-9, -9, 9))
    assert np.allclose(data["light_direction"], np.array((-1, 1, 2)) / np.sqrt(6))


def test_two_inputs_of_one_stem_do_not_overwrite_each_other(main, cube_obj, tmp_path):
    (tmp_path / "sub").mkdir()
    twin = tmp_path / "sub" / "box.stl"
    twin.write_text("solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n")
    assert main(["preview", str(cube_obj), str(twin), "-o", str(tmp_path / "out"), "--quiet", *SMALL]) == 0
    assert {"box_obj_combined.png", "box_stl_combined.png"} <= {p.name for p in (tmp_path / "out").iterdir()}


def test_the_example_is_drawn_only_when_nothing_is_named(main, cube_obj, tmp_path):
    common = ("--example", "10000", "-o", str(tmp_path / "out"), "--quiet", *SMALL)
    assert main(["preview", str(cube_obj), *common]) == 0
    assert not list((tmp_path / "out").glob("deck*"))
    assert main(["preview", *common]) == 0
    assert (tmp_path / "out" / "deck_10000_combined.png").exists()


def test_theory_prints_the_contracts_object(main, capfd):
    assert main(["theory", "--near", "1", "--far", "1000", "--warp", "uniform", "--partition", "none", "--curve", "z", "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert {"gamma_deg", "gamma_lim_deg", "partitions", "total", "curve"} <= set(result)
    assert set(result["total"]) == {"m_x_max", "m_z_max", "storage_factor"}
    assert set(result["partitions"][0]) == PARTITION_KEYS
    assert result["total"]["storage_factor"] == pytest.approx(865159, rel=1e-5)


def test_json_alone_on_standard_output_of_the_module(cube_obj, tmp_path):
    command = [sys.executable, "-m", "addon", "preview", str(cube_obj), "-o", str(tmp_path / "out"), "--json", *SMALL]
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "user")}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert set(json.loads(done.stdout)) == REPORT_KEYS
