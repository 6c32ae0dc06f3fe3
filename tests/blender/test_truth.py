"""The ray-traced truth against a float64 brute force over all triangles, and the comparison against frames whose faults are known."""

import numpy as np
import pytest

from addon.errors import SceneError, SettingsError
from addon.maths import spaces
from addon.maths.shadow.projection import LogWarp, ShadowPlan, ShadowProjection
from addon.maths.view import Camera, Light
from addon.pipeline.frame import Frame
from addon.studies.truth import TruthTracer, compare
from addon.studies.truth.footprint import smallest_singular_value, texel_extent_px
from addon.studies.truth.tracer import LEAST_FACING, camera_rays, pixel_centres
from tests import scenes

pytest.importorskip("bpy", reason="the ray tracer shipped is Blender's")
SIZE = (64, 36)
CASES = {
    "closed box": (scenes.closed_box, (6, -5, 4), (0, 0, 0.5)),
    "railing": (scenes.railing, (3, -5, 2), (0, 0, 0.5)),
    "open sheet": (scenes.open_sheet, (4, -4, 3), (0, 0, 0.5)),
    "doubled sheet": (scenes.doubled_sheet, (4, -4, 3), (0, 0, 0.5)),
    "coincident boxes": (scenes.coincident_boxes, (4, -5, 4), (0, 0, 0.5)),
    "chair": (scenes.chair, (1.2, -1.5, 1.1), (0, 0, 0.4)),
    "staircase": (scenes.staircase, (3, -3, 2), (0, 1, 0.8)),
    "sphere": (scenes.sphere, (3, -4, 3), (0, 0, 0.8)),
}
BACKENDS = [
    "blender",
    pytest.param(
        "embree", marks=pytest.mark.skipif(not __import__("importlib.util").util.find_spec("embreex"), reason="embreex is not installed")
    ),
]


def first_hits(corners, origins, directions):
    """Float64 Möller–Trumbore of every ray against every triangle: (R,) distance and triangle, inf and −1 where nothing."""
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    best, triangle = np.full(len(origins), np.inf), np.full(len(origins), -1)
    for index in range(len(corners)):
        p = np.cross(directions, e2[index])
        det = p @ e1[index]
        safe = np.where(np.abs(det) > 1e-14, det, np.inf)
        offset = origins - corners[index, 0]
        u = np.einsum("ij,ij->i", offset, p) / safe
        q = np.cross(offset, e1[index])
        v = np.einsum("ij,ij->i", directions, q) / safe
        t = q @ e2[index] / safe
        nearer = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < best) & np.isfinite(safe)
        best[nearer], triangle[nearer] = t[nearer], index
    return best, triangle


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("elevation", [12.0, 90.0])
@pytest.mark.parametrize("name", CASES)
def test_truth_is_what_a_brute_force_finds(name, elevation, backend):
    make, eye, target = CASES[name]
    tracer, camera, light = TruthTracer(make(), backend), scenes.look_at(eye, target), scenes.sun(elevation)
    truth = tracer.trace(camera, light, SIZE)
    origins, directions, lengths = camera_rays(camera, SIZE, pixel_centres(SIZE))
    corners = tracer.triangles.corners
    distance, triangle = first_hits(corners, origins, directions)
    seen = (triangle >= 0) & (distance < lengths)
    assert np.count_nonzero(seen != (truth.object.ravel() >= 0)) <= 2
    point = origins[seen] + directions[seen] * distance[seen, None]
    normal = tracer.triangles.normal[triangle[seen]]
    normal = np.where(np.einsum("ij,ij->i", normal, directions[seen])[:, None] > 0, -normal, normal)
    facing = normal @ light.direction_ws
    blocked, _ = first_hits(corners, point + 1e-6 * normal, np.broadcast_to(light.direction_ws, point.shape))
    lit = (facing > LEAST_FACING) & ~np.isfinite(blocked)
    assert 0 < lit.sum() < lit.size
    assert np.count_nonzero(lit != truth.lit.ravel()[seen]) <= 2
    assert np.count_nonzero((facing > LEAST_FACING) != truth.lit_facing.ravel()[seen]) <= 2
    depth = (point - camera.eye_ws) @ camera.direction_ws
    assert np.count_nonzero(np.abs(depth - truth.depth.ravel()[seen]) > 1e-6) <= 2


def test_the_point_lies_exactly_in_its_plane_whatever_the_tracer_rounds():
    camera = scenes.look_at((0.0, -9.0, 0.4), (0.0, 9.0, 0.0))
    truth = TruthTracer(scenes.scene_of(scenes.floor())).trace(camera, scenes.sun(30.0), SIZE)
    seen = truth.object == 0
    assert seen.any() and np.abs(truth.point_ws[seen][:, 2]).max() < 1e-12
    assert (truth.depth[~seen] == np.inf).all() and not truth.lit[~seen].any()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("offset", [0.0, 40.0, 300.0, 3000.0])
def test_coincident_and_doubled_faces_never_shadow_themselves(backend, offset):
    shift = np.eye(4)
    shift[:3, :3] = scenes.look_at((1, 2, 3), (0, 0, 0)).view_from_world[:3, :3].T
    shift[:3, 3] = offset * np.array([1.0, 0.7, 0.3])
    a, b, c, d = (-1.5, 1.0, 0.0), (1.5, 1.0, 0.0), (1.5, -1.0, 0.0), (-1.5, -1.0, 0.0)
    wide = scenes.sheet(*(tuple(10.0 * np.array(p)) for p in (a, b, c, d)))
    scene = scenes.scene_of(scenes.joined(scenes.sheet(a, b, c, d), scenes.sheet(d, c, b, a)), wide, matrices=[shift, shift])
    axis, tilt = shift[:3, 2], shift[:3, 0]
    centre = shift[:3, 3]
    camera = scenes.look_at(tuple(centre - 5.0 * axis + tilt), tuple(centre), near=1.0)
    for grazing in (0.02, 0.2, 1.0):
        direction = -axis * grazing + tilt * np.sqrt(1.0 - grazing**2)
        truth = TruthTracer(scene, backend).trace(camera, Light("sun", direction / np.linalg.norm(direction)), SIZE)
        assert truth.lit_facing.sum() > 1000
        assert truth.lit[truth.lit_facing].all()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("half", [1e2, 1e4, 1e5])
@pytest.mark.parametrize("seed", range(3))
def test_on_a_ground_of_any_size_each_ray_ends_where_float64_says(backend, half, seed):
    """Millimetre plates and rods over one turned quad, off its middle: its corners in float32 are millimetres beside where they are."""
    rng = np.random.default_rng(seed)
    turned = np.eye(4)
    turned[:3, :3] = scenes.look_at(tuple(rng.normal(size=3)), (0, 0, 0)).view_from_world[:3, :3].T
    at = np.append(rng.uniform(-0.6, 0.6, 2) * half, 0.0)
    parts = []
    for height in (0.001, 0.01, 0.1):
        x, y = rng.uniform(-0.5, 0.5, 2)
        parts += [scenes.box((x, y, height), (x + 0.4, y + 0.3, height + 0.001)), scenes.rod((y, x, height), (y, x + 0.3, height), 0.0007)]
    placed = turned.copy()
    placed[:3, 3] = turned[:3, :3] @ at
    scene = scenes.scene_of(scenes.floor(half), *parts, matrices=[turned, *([placed] * len(parts))])
    axes, middle = turned[:3, :3], placed[:3, 3]
    camera = scenes.look_at(tuple(middle + axes @ [0.7, -1.1, 0.8]), tuple(middle), near=0.05)
    light = Light("sun", axes @ scenes.sun(15.0, 70.0 * seed).direction_ws)
    tracer = TruthTracer(scene, backend, anchor_ws=camera.anchor_ws(0.05))
    truth = tracer.trace(camera, light, SIZE)
    corners = tracer.triangles.corners
    origins, directions, lengths = camera_rays(camera, SIZE, pixel_centres(SIZE))
    distance, triangle = first_hits(corners, origins, directions)
    seen = distance < lengths
    assert seen.mean() > 0.5
    agree = truth.object.ravel() == np.where(seen, tracer.triangles.object_id[triangle], -1)
    assert np.count_nonzero(~agree) <= 2
    lit_facing = truth.lit_facing.ravel()
    point = truth.point_ws.reshape(-1, 3)[lit_facing]
    start = point + 1e-6 * truth.normal_ws.reshape(-1, 3)[lit_facing]
    blocked = np.isfinite(first_hits(corners, start, np.broadcast_to(light.direction_ws, start.shape))[0])
    assert 20 < blocked.sum() < len(blocked)
    assert np.count_nonzero(blocked == truth.lit.ravel()[lit_facing]) <= 4


def test_a_sheet_is_dark_on_the_side_away_from_the_light_and_lit_on_the_other_whatever_its_winding():
    below = scenes.look_at((0.0, -1.0, 0.1), (0.0, 0.3, 0.9), near=0.01)
    above = scenes.look_at((0.0, -4.0, 4.0), (0.0, 0.0, 0.9))
    for make in (scenes.open_sheet, scenes.doubled_sheet):
        tracer = TruthTracer(make())
        under, over = (tracer.trace(camera, scenes.sun(80.0, 90.0), SIZE) for camera in (below, above))
        assert (under.object == 1).sum() > 500 and not under.lit[under.object == 1].any()
        assert (over.object == 1).sum() > 100 and over.lit[over.object == 1].all()


def test_both_tracers_agree_to_a_handful_of_pixels():
    pytest.importorskip("embreex")
    scene = scenes.railing()
    camera, light, size = scenes.look_at((3, -5, 2), (0, 0, 0.5)), scenes.sun(25.0), (320, 180)
    one, other = (TruthTracer(scene, backend).trace(camera, light, size) for backend in ("blender", "embree"))
    assert np.count_nonzero(one.lit != other.lit) <= 5
    assert np.count_nonzero(one.object != other.object) <= 5


def test_spot_and_point_lights_end_at_their_cone_and_at_their_position():
    roof = scenes.sheet((-9, -9, 5), (9, -9, 5), (9, 9, 5), (-9, 9, 5))
    tracer = TruthTracer(scenes.scene_of(scenes.floor(), scenes.box((-0.5, -0.5, 0.5), (0.5, 0.5, 1.0)), roof))
    camera, position = scenes.look_at((0.0, -8.0, 4.5), (0.0, 0.0, 0.0)), np.array([0.0, 0.0, 3.0])
    spot = Light("spot", np.array([0.0, 0.0, 1.0]), position, cone_rad=0.6)
    point = Light("point", None, position)
    ground = None
    for light in (spot, point):
        truth = tracer.trace(camera, light, (160, 90))
        ground = truth.object == 0
        radius = np.hypot(truth.point_ws[..., 0], truth.point_ws[..., 1])
        square = np.abs(truth.point_ws[..., :2]).max(axis=-1)
        shaded = square < 0.5 * 3.0 / 2.0  # the box's top edge at z = 1, seen from z = 3
        reach = radius < 3.0 * np.tan(0.6) if light.kind == "spot" else np.ones_like(ground)
        assert (truth.lit_facing[ground] == reach[ground]).mean() > 0.999
        assert (truth.lit[ground] == (reach & ~shaded)[ground]).mean() > 0.995
    assert ground.sum() > 3000


def overhead(x, y):
    """An orthographic camera 20 m above the floor, north up, that sees ±1/x by ±1/y metres."""
    return Camera(spaces.look_at((0, 0, 20), (0, 0, 0), (0, 1, 0)), np.diag([x, y, -0.02, 1.0]), -50.0, 50.0)


def test_an_orthographic_camera_sees_along_parallel_rays():
    camera = overhead(0.5, 0.5)
    truth = TruthTracer(scenes.closed_box()).trace(camera, scenes.sun(45.0, 0.0), (40, 40))
    x, y = np.meshgrid((np.arange(40) + 0.5) / 10.0 - 2.0, 2.0 - (np.arange(40) + 0.5) / 10.0)
    on_box = np.maximum(np.abs(x), np.abs(y)) < 1.0
    np.testing.assert_array_equal(truth.object, np.where(on_box, 1, 0))
    np.testing.assert_allclose(truth.depth, np.where(on_box, 18.0, 20.0), atol=1e-12)
    np.testing.assert_array_equal(truth.lit, on_box | (x > 0) | (np.abs(y) > 1.0))


def test_an_unknown_tracer_is_refused():
    with pytest.raises(SettingsError, match="blender, embree"):
        TruthTracer(scenes.closed_box(), "cycles")


def overhead_plan(half=10.0, log=None):
    """One uniform map seen from straight above: 2·half metres over the map's side."""
    matrix = np.diag([1.0 / half, 1.0 / half, -1.0 / half, 1.0])
    return ShadowPlan((ShadowProjection(matrix, 0.1, 100.0, log),), 0.0, 0.0, np.eye(4))


def whole_extent(truth, camera, plan, map_size):
    """The extent at every pixel, all served by map 0; 0 where nothing is seen."""
    height, width = truth.depth.shape
    partition = np.where(truth.object.ravel() >= 0, 0, -1)
    flat = truth.reshaped((height * width,))
    return texel_extent_px(flat, pixel_centres((width, height)), camera, (width, height), plan, partition, map_size).reshape(height, width)


def test_the_texel_extent_is_texel_over_pixel_size_along_the_shorter_axis_of_the_pixel():
    camera = overhead(0.5, 0.25)
    truth = TruthTracer(scenes.scene_of(scenes.floor())).trace(camera, scenes.sun(90.0), (40, 40))
    extent = whole_extent(truth, camera, overhead_plan(), 100)
    np.testing.assert_allclose(extent, (20.0 / 100) / min(4.0 / 40, 8.0 / 40), rtol=1e-9)


def test_the_texel_extent_agrees_with_rays_through_the_ends_of_texels():
    camera, size = scenes.look_at((3.0, -6.0, 1.2), (0.0, 3.0, 0.0)), (96, 54)
    truth = TruthTracer(scenes.scene_of(scenes.floor())).trace(camera, scenes.sun(90.0), size)
    seen = truth.object == 0
    extent = whole_extent(truth, camera, overhead_plan(), 4096)[seen]
    longest = np.zeros(seen.sum())
    texel = 20.0 / 4096
    for angle in np.linspace(0.0, np.pi, 720, endpoint=False):
        step = 0.5 * texel * np.array([np.cos(angle), np.sin(angle), 0.0])
        ends = []
        for sign in (-1.0, 1.0):
            clip = np.append(truth.point_ws[seen] + sign * step, np.ones((seen.sum(), 1)), axis=1) @ camera.clip_from_world.T
            ends.append(clip[:, :2] / clip[:, 3:] * np.array(size) / 2.0)
        longest = np.maximum(longest, np.linalg.norm(ends[1] - ends[0], axis=1))
    np.testing.assert_allclose(extent, longest, rtol=2e-3)


def test_a_logarithmic_axis_has_texels_that_grow_with_w():
    camera = overhead(0.5, 0.5)
    truth = TruthTracer(scenes.scene_of(scenes.floor())).trace(camera, scenes.sun(90.0), (40, 40))
    matrix = np.array([[0.1, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, -0.1, 0], [0, 1.0, 0, 4.0]])  # w = y + 4
    log = LogWarp(2.0, 6.0, 2.0 / np.log2(3.0), -1.0 - 2.0 / np.log2(3.0), False)  # t from −1 at w = 2 to 1 at w = 6
    plan = ShadowPlan((ShadowProjection(matrix, 0.1, 100.0, log),), 0.0, 0.0, np.eye(4))
    extent = whole_extent(truth, camera, plan, 64)
    along_t = (truth.point_ws[..., 1] + 4.0) * np.log(3.0) / 64 / 0.1  # dy per texel: w·ln(f'/n')/N, over 0.1 m per pixel
    np.testing.assert_allclose(extent, np.maximum(along_t, 20.0 / 64 / 0.1), rtol=1e-3)


def test_the_closed_form_of_the_smallest_singular_value(rng):
    matrices = rng.normal(size=(500, 2, 2))
    np.testing.assert_allclose(smallest_singular_value(matrices), np.linalg.svd(matrices, compute_uv=False)[:, 1], atol=1e-12)


def frame_with(truth, shadow, plan=None):
    partition = np.where(truth.point_ws[..., 0] > -2.0, 1, 0)
    plan = plan or ShadowPlan(overhead_plan().projections * 2, 0.0, 0.0, np.eye(4))
    passes = {"shadow": shadow.astype(np.float32), "depth": truth.depth.astype(np.float32), "object": truth.object, "partition": partition}
    return Frame(passes, plan, {}, {}, {}, None)


@pytest.fixture(scope="module")
def box_view():
    tracer, camera, light = TruthTracer(scenes.closed_box()), scenes.look_at((-6, -5, 4), (-1, -0.5, 0.5)), scenes.sun(40.0)
    return tracer, camera, light, tracer.trace(camera, light, (320, 180))


def test_a_perfect_preview_has_no_error_anywhere(box_view):
    _, camera, light, truth = box_view
    metrics, image = compare(frame_with(truth, truth.lit), truth, camera, light, 2048)
    assert metrics["pixels"] == truth.lit_facing.sum() > 20000
    parts = metrics.pop("partitions")
    for numbers in (metrics, *parts):
        assert [numbers[k] for k in ("misclassified_pct", "acne_pct", "leak_pct", "edge_px_median", "edge_px_p95")] == [0.0] * 5
    assert sum(p["pixels"] for p in parts) == metrics["pixels"] and image.shape == (180, 320, 3)


def test_dots_in_the_light_are_acne_and_holes_in_the_shadow_are_leaks(box_view, rng):
    tracer, camera, light, truth = box_view
    edges = np.zeros_like(truth.lit)
    for shift in np.ndindex(9, 9):
        edges |= truth.lit != np.roll(truth.lit, np.array(shift) - 4, axis=(0, 1))
        edges |= truth.object != np.roll(truth.object, np.array(shift) - 4, axis=(0, 1))
    inner = ~edges & truth.lit_facing
    inner[:8], inner[-8:], inner[:, :8], inner[:, -8:] = False, False, False, False
    dots = rng.random(truth.lit.shape) < 0.01
    dark, light_spots = dots & inner & truth.lit, dots & inner & ~truth.lit
    assert dark.sum() > 50 and light_spots.sum() > 10
    metrics, _ = compare(frame_with(truth, truth.lit ^ dark ^ light_spots), truth, camera, light, 8192, tracer)
    assert metrics["acne_pct"] == pytest.approx(100.0 * dark.sum() / metrics["pixels"])
    assert metrics["leak_pct"] == pytest.approx(100.0 * light_spots.sum() / metrics["pixels"])


def test_a_shadow_thinner_than_a_pixel_excuses_a_dark_pixel_beside_it():
    wire = scenes.rod((-3.0, 0.0, 1.0), (3.0, 0.0, 1.0), 0.008, 4)
    tracer, light = TruthTracer(scenes.scene_of(scenes.floor(), wire)), scenes.sun(60.0, 80.0)
    camera, size = scenes.look_at((0.0, -0.3, 9.0), (0.0, -0.6, 0.0)), (160, 90)
    truth = tracer.trace(camera, light, size)
    shadow_y = -np.sin(np.radians(80.0)) / np.tan(np.radians(60.0))
    beside = (truth.object == 0) & (np.abs(truth.point_ws[..., 1] - shadow_y) < 0.15) & (np.abs(truth.point_ws[..., 0]) < 1.5) & truth.lit
    far = (truth.object == 0) & (np.abs(truth.point_ws[..., 1] - shadow_y) > 1.0) & (np.abs(truth.point_ws[..., 1]) > 1.0)
    far[:8], far[-8:], far[:, :8], far[:, -8:] = False, False, False, False
    far &= np.random.default_rng(1).random(far.shape) < 0.01
    assert beside.sum() > 30 and far.sum() > 10
    plan = ShadowPlan(overhead_plan(8.0).projections * 2, 0.0, 0.0, np.eye(4))
    wrong = frame_with(truth, truth.lit & ~beside & ~far, plan)
    blind, _ = compare(wrong, truth, camera, light, 512)
    seeing, _ = compare(wrong, truth, camera, light, 512, tracer)
    pixels = seeing["pixels"]
    assert seeing["acne_pct"] == pytest.approx(100.0 * far.sum() / pixels, abs=100.0 * 2 / pixels)
    assert blind["acne_pct"] > seeing["acne_pct"] and seeing["misclassified_pct"] == blind["misclassified_pct"]


def test_a_frame_of_another_scene_is_refused(box_view):
    _, camera, light, truth = box_view
    frame = frame_with(truth, truth.lit)
    frame.passes["object"] = np.roll(truth.object, 40, axis=1)
    frame.passes["depth"] = np.roll(truth.depth, 40, axis=1).astype(np.float32)
    with pytest.raises(SceneError, match="different surfaces"):
        compare(frame, truth, camera, light, 2048)


def test_a_frame_without_light_is_refused(box_view):
    _, camera, light, truth = box_view
    with pytest.raises(SettingsError, match="no light"):
        compare(Frame({}, None, {}, {}, {}, None), truth, camera, light, 2048)


def test_between_two_questions_whether_to_go_on_few_rays_are_traced(monkeypatch):
    monkeypatch.setattr("addon.studies.truth.backends.ROWS_AT_ONCE", 100)
    traced, most = [0], []

    def go_on():
        most.append(traced[0])
        traced[0] = 0

    tracer = TruthTracer(scenes.closed_box(), go_on=go_on)
    cast = tracer._backend._backend._cast
    tracer._backend._backend._cast = lambda *ray: (traced.__setitem__(0, traced[0] + 1), cast(*ray))[1]
    tracer.trace(scenes.look_at((-6, -5, 4), (-1, -0.5, 0.5)), scenes.sun(40.0), (40, 40))
    assert len(most) > 16 and max(most) == 100
