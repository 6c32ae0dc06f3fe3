"""`impostor` and `impostor-path` as a user or a farm meets them: files that suffice to draw elsewhere, the documented keys, exit codes."""

import csv
import json

import numpy as np
import pytest

FRAME_KEYS = (
    *("index", "stage", "beta_screen", "beta_trans_p", "beta_trans_n", "critical_error", "critical_error_corrected", "regions_sum"),
    *("edge_sum_px", "psnr_db", "ssim", "silhouette_iou", "missing_pct", "false_pct"),
)
STAGES = {"geometry", "sprite", "warp", "regenerated"}
SMALL = ("--size", "96x64", "--map-size", "128", "--samples", "1", "--quiet")


@pytest.fixture
def balls(blend, tmp_path):
    """A file with two balls on a floor, one of them marked, an empty, a moving camera; its path."""
    bpy = blend
    bpy.ops.mesh.primitive_plane_add(size=8)
    for name, x in (("Near", 0.8), ("Far", -1.2)):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.8, location=(x, -x, 1))
        bpy.context.object.name = name
    bpy.data.objects["Near"].cad_shadow_impostor = True
    bpy.ops.object.empty_add()
    bpy.ops.object.light_add(type="SUN", rotation=(0.6, 0.3, 0.2))
    bpy.ops.object.camera_add(location=(6, -6, 5), rotation=(1.02, 0, 0.785))
    camera = bpy.context.scene.camera = bpy.context.object
    for frame, x in ((1, 6.0), (5, 6.4)):
        camera.location.x = x
        camera.keyframe_insert("location", frame=frame)
    path = tmp_path / "balls.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def run(main, out, *argv):
    code = main([str(a) for a in (*argv, *SMALL, "-o", out, "--report", out / "all.json")])
    path = out / "all.json"
    return code, json.loads(path.read_text()) if path.is_file() else None


def pixels(blend, path):
    """A PNG's raw values 0…1 (h, w, 4), row 0 at the top."""
    image = blend.data.images.load(str(path), check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    out = np.array(image.pixels[:], np.float64).reshape(image.size[1], image.size[0], 4)[::-1]
    blend.data.images.remove(image)
    return out


def world_points(data, depth_m):
    """World points (h, w, 3) of all texels, by what the JSON itself says (`how`)."""
    width, height = data["size"]
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    source, world = np.array(data["source"]), np.array(data["world_from_plane"])
    relief = depth_m / (source[2] - source[3] * depth_m)
    plane = np.stack([u, v, np.zeros_like(u), np.ones_like(u)], axis=-1) + relief[..., None] * source
    points = plane @ world.T
    return points[..., :3] / points[..., 3:]


@pytest.mark.parametrize("projection", ("perspective", "orthographic"))
def test_png_and_json_alone_give_the_surface_back(main, balls, tmp_path, blend, projection):
    code, report = run(main, tmp_path, "impostor", balls, "--object", "Far", "--impostor-projection", projection)
    assert code == 0 and [i["name"] for i in report["impostors"]] == ["Far"]
    data = json.loads((tmp_path / "balls_Far.json").read_text())
    assert data["projection"] == projection
    color, depth, normal = (pixels(blend, tmp_path / data["files"][name]) for name in ("color", "depth", "normal"))
    mask = color[..., 3] == 1.0
    assert np.array_equal(pixels(blend, tmp_path / data["files"]["mask"])[..., 0] == 1.0, mask)
    assert color.shape[:2] == tuple(data["size"][::-1]) and set(np.unique(color[..., 3])) == {0.0, 1.0} and mask.mean() > 0.3
    points = world_points(data, depth[..., 0] * 65535.0 * data["depth"]["scale_m"])
    outwards = points[mask] - (-1.2, 1.2, 1.0)
    radius = np.linalg.norm(outwards, axis=1)
    assert (radius > 0.78).all() and (radius < 0.801).all(), "a ball of 32 segments lies a little inside its sphere"
    cosine = ((normal[mask][:, :3] * 2.0 - 1.0) * outwards / radius[:, None]).sum(axis=1)
    assert cosine.min() > 0.95
    back = pixels(blend, tmp_path / data["files"]["back"])
    assert (back[mask] >= depth[mask]).all() and np.median((back - depth)[mask][:, 0]) > 0.1
    assert set(np.unique(np.rint(pixels(blend, tmp_path / data["files"]["object"])[..., 0] * 65535))) == {0, 1}
    assert data["objects"] == ["Far"] and data["triangles"] == 2 * 32 * 15


def test_the_critical_points_lie_on_the_object_and_come_largest_first(main, balls, tmp_path):
    run(main, tmp_path, "impostor", balls, "--object", "Far")
    points = json.loads((tmp_path / "balls_Far.json").read_text())["critical_points"]
    assert points and [p["step_m"] for p in points] == sorted((p["step_m"] for p in points), reverse=True)
    away = [np.linalg.norm(np.array(p["world"]) - (-1.2, 1.2, 1.0)) for p in points]
    assert min(away) > 0.7 and max(away) < 0.85
    assert all(0 <= p["near_m"] <= p["far_m"] for p in points)


def test_exr_and_npz_hold_the_same_as_png(main, balls, tmp_path, blend):
    data = {}
    for kind in ("png", "exr", "npz"):
        folder = tmp_path / kind
        assert run(main, folder, "impostor", balls, "--object", "Far", "--format", kind)[0] == 0
        data[kind] = json.loads((folder / "balls_Far.json").read_text())
    arrays = np.load(tmp_path / "npz" / data["npz"]["files"]["npz"])
    depth = pixels(blend, tmp_path / "png" / data["png"]["files"]["depth"])[..., 0] * 65535.0 * data["png"]["depth"]["scale_m"]
    assert np.abs(depth - arrays["depth"]).max() <= 0.51 * data["png"]["depth"]["scale_m"]
    image = blend.data.images.load(str(tmp_path / "exr" / data["exr"]["files"]["color"]))
    exact = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], 4)[::-1]
    assert np.array_equal(exact[arrays["mask"]], arrays["color"][arrays["mask"]])
    assert {k: v for k, v in data["exr"].items() if k != "files"} == {k: v for k, v in data["npz"].items() if k != "files"}


def test_colours_go_on_beyond_the_outline(main, balls, tmp_path):
    run(main, tmp_path, "impostor", balls, "--object", "Far", "--format", "npz")
    arrays = np.load(tmp_path / "balls_Far.npz")
    mask, color = arrays["mask"], arrays["color"]
    beside = ~mask & (np.roll(mask, 1, 0) | np.roll(mask, -1, 0) | np.roll(mask, 1, 1) | np.roll(mask, -1, 1))
    assert beside.any() and (color[beside][:, :3].max(axis=1) > 0.02).all() and (color[beside][:, 3] == 0.0).all()


def test_without_names_the_marked_are_captured_else_everything_as_one(main, balls, tmp_path, blend):
    assert [i["name"] for i in run(main, tmp_path, "impostor", balls)[1]["impostors"]] == ["Near"]
    blend.ops.wm.open_mainfile(filepath=str(balls))
    blend.data.objects["Near"].cad_shadow_impostor = False
    blend.ops.wm.save_mainfile()
    (one,) = run(main, tmp_path / "all", "impostor", balls)[1]["impostors"]
    assert one["name"] == "balls" and set(one["objects"]) == {"Plane", "Near", "Far"}
    assert (tmp_path / "all" / "balls_impostor_color.png").is_file()


def test_patterns_make_one_impostor_of_each_match(main, balls, tmp_path):
    code, report = run(main, tmp_path, "impostor", balls, "--object", "*ar")
    assert code == 0 and sorted(i["name"] for i in report["impostors"]) == ["Far", "Near"]


def test_what_fails_is_said_and_stops_nothing_else(main, balls, tmp_path):
    code, report = run(main, tmp_path, "impostor", balls, "--object", "Far", "--object", "Empty")
    assert code == 1 and [i["name"] for i in report["impostors"]] == ["Far"]
    assert len(report["errors"]) == 1 and "'Empty' has no surface" in report["errors"][0]
    code, report = run(main, tmp_path, "impostor", balls, "--object", "Pump")
    assert code == 1 and "no object or collection 'Pump'" in report["errors"][0]
    code, report = run(main, tmp_path, "impostor", balls, "--object", "Far", "--eye", "20,-20,5", "--target", "40,-40,5")
    assert code == 1 and "'Far'" in report["errors"][0] and "behind" in report["errors"][0]
    code, report = run(main, tmp_path, "impostor", balls, "--object", "Far", "--eye=-1,1,1", "--target=-1.2,1.2,1")
    assert code == 1 and "around the camera" in report["errors"][0]


def test_the_plane_comes_in_a_blend_of_its_own(main, balls, tmp_path, blend):
    assert run(main, tmp_path, "impostor", balls, "--object", "Far", "--plane")[0] == 0
    kinds = (blend.data.images, blend.data.objects, blend.data.meshes, blend.data.materials, blend.data.cameras, blend.data.collections)
    assert not [one.name for kind in kinds for one in kind if one.name.startswith("Impostor")], "nothing of it stays in the open file"
    with blend.data.libraries.load(str(tmp_path / "balls_Far.blend")) as (there, here):
        here.collections = there.collections
    (collection,) = here.collections
    plane = next(ob for ob in collection.objects if ob.type == "MESH")
    corners = np.array([plane.matrix_basis @ v.co for v in plane.data.vertices])
    data = json.loads((tmp_path / "balls_Far.json").read_text())
    width, height = data["size"]
    quad = np.array([[0, 0, 0, 1], [0, height, 0, 1], [width, height, 0, 1], [width, 0, 0, 1]])
    assert np.allclose(corners, (quad @ np.array(data["world_from_plane"]).T)[:, :3], atol=1e-5)
    assert plane.data.materials[0].node_tree.nodes["Image Texture"].image.packed_file
    assert any(ob.type == "CAMERA" for ob in collection.objects)


def test_a_path_has_exactly_the_contracts_keys_in_report_and_csv(main, balls, tmp_path):
    code, report = run(main, tmp_path, "impostor-path", balls, "--orbit", "12", "--steps", "6")
    assert code == 0 and len(report["frames"]) == 7
    assert all(tuple(row) == FRAME_KEYS and row["stage"] in STAGES for row in report["frames"])
    with (tmp_path / "balls_path.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == FRAME_KEYS and len(rows) == 7
    for row, line in zip(report["frames"], rows, strict=True):
        assert {k: "" if v is None else str(v) for k, v in row.items()} == line
    assert report["frames"][0]["stage"] == "regenerated" and report["frames"][0]["critical_error"] is None
    later = report["frames"][1:]
    assert {row["stage"] for row in later} >= {"warp"} or {row["stage"] for row in later} >= {"sprite"}
    assert all(row["beta_screen"] > 0 and row["silhouette_iou"] > 0.9 and row["psnr_db"] > 18 for row in later)
    assert [d["angle_deg"] for d in report["details"]] == [0, 2, 4, 6, 8, 10, 12]
    (one,) = report["impostors"]
    assert one["name"] == "Near" and sum(one["stages"].values()) == 7
    assert report["regenerations"] == one["captures"] - 1 == [r["stage"] for r in report["frames"]].count("regenerated") - 1


def test_a_tight_limit_captures_more_often(main, balls, tmp_path):
    argv = ("impostor-path", balls, "--orbit", "12", "--steps", "6")
    loose = run(main, tmp_path, *argv, "--impostor-limit", "0.9")[1]
    tight = run(main, tmp_path, *argv, "--impostor-limit", "0.0001")[1]
    assert tight["regenerations"] > loose["regenerations"] == 0
    quality = [[row["ssim"] for row in report["frames"]] for report in (loose, tight)]
    assert min(quality[1]) >= min(quality[0])


def test_a_path_follows_the_animation_and_leaves_its_pictures(main, balls, tmp_path, blend):
    code, report = run(main, tmp_path, "impostor-path", balls, "--from-frame", "1", "--to-frame", "3", "--object", "Near", "--pictures")
    assert code == 0 and [d["frame"] for d in report["details"]] == [1, 2, 3]
    assert [(tmp_path / f"balls_path_{i:04d}.png").is_file() for i in range(3)] == [True] * 3
    first, last = (pixels(blend, tmp_path / f"balls_path_{i:04d}.png") for i in (0, 2))
    assert not np.array_equal(first, last)
    assert blend.context.scene.frame_current == 1


def test_an_object_out_of_view_or_that_changes_is_told(main, balls, tmp_path, blend):
    blend.ops.wm.open_mainfile(filepath=str(balls))
    ball = blend.data.objects["Near"]
    for frame, place in ((2, (0.8, -0.8, 1)), (3, (0.8, -0.8, 1.5)), (4, (300, 0, 1))):
        ball.location = place
        ball.keyframe_insert("location", frame=frame)
    blend.ops.wm.save_mainfile()
    report = run(main, tmp_path, "impostor-path", balls, "--from-frame", "1", "--to-frame", "4")[1]
    rows, details = report["frames"], report["details"]
    assert rows[2]["stage"] == "regenerated" and "changed" in details[2]["impostors"][0]["reason"]
    assert rows[3]["stage"] == "geometry" and details[3]["impostors"][0]["reason"] == "out of view"
    assert rows[3]["psnr_db"] is None and rows[3]["silhouette_iou"] is None


@pytest.mark.parametrize(
    "argv",
    [
        (),
        ("--orbit", "10", "--from-frame", "1", "--to-frame", "2"),
        ("--from-frame", "1"),
        ("--from-frame", "3", "--to-frame", "2"),
        ("--orbit", "0"),
        ("--orbit", "10", "--steps", "0"),
        ("--from-frame", "1", "--to-frame", "2", "--steps", "4"),
    ],
    ids=" ".join,
)
def test_a_path_that_makes_no_sense_is_refused(main, tmp_path, argv, capsys):
    assert main(["impostor-path", "nothing.blend", *argv, "-o", str(tmp_path)]) == 2
    assert capsys.readouterr().err.strip()
    assert not list(tmp_path.iterdir())


def test_previews_on_the_command_line_draw_what_is_marked_as_impostors(main, balls, tmp_path):
    code, report = run(main, tmp_path, "preview", balls, "--no-impostor-break-even")
    assert code == 0 and report["impostors"][0]["stage"] == "regenerated"
    assert report["geometry"]["triangles_saved"] == 2 * 32 * 15
    plain = run(main, tmp_path, "preview", balls, "--impostor-use", "off")[1]
    assert "impostors" not in plain and "triangles_saved" not in plain["geometry"]
