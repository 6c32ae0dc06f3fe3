"""The shadow tests on the GPU against their numpy definitions, pixel by pixel; the exact test against rays; scenes built to break them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.errors import SettingsError
from addon.maths.shadow.lookup import texel_footprint
from addon.pipeline.device import device_of
from addon.pipeline.job import Job
from addon.pipeline.passes import shadow_defines
from addon.settings.groups import PCF_COUNTS, TESTS, Settings, ShadowTestChoice
from addon.studies.run import run
from tests import scenes
from tests.pipeline import oracle
from tests.pipeline import shadow_definition as definition

SIZE, MAP = (160, 90), 128
CAMERA = scenes.look_at((1.9, -2.3, 1.6), (0.0, 0.1, 0.3), near=0.3, far=60.0)
SUN = scenes.sun(30.0)
PLANS = [
    ("uniform", "none"),
    ("lispsm-general", "none"),
    ("lispsm-general", "z-adaptive"),
    ("logpsm", "none"),
    ({"kind": "logpsm", "log_bend": 2.0}, "none"),
    ({"kind": "logpsm", "log_bend": -0.7}, "none"),
]


def settings(warp="lispsm-general", partition="none", size=MAP, **test):
    chosen = warp if isinstance(warp, dict) else {"kind": warp}
    return Settings().replaced(warp=chosen, partition={"kind": partition}, fit={"size": size}, test={"kind": "depth", **test})


def render(renderer, scene, chosen, light=SUN, camera=CAMERA):
    return run(Job(scene, camera, light, chosen, SIZE, ("shadow", "depth", "normal", "object", "partition", "texel")), on=renderer).frame


def layers_of(renderer, name, components):
    """Arrays (k, N, N, components) of the shadow maps the last frame used: 'ids', or ('depths' | 'ids', target) of the n-SM's cells."""

    def read(context):
        maps = device_of(context, renderer.worker)._kept["shadow"][1]
        texture = maps.ids if name == "ids" else getattr(maps.cells, name[0])[name[1]]
        dtype = np.float32 if texture.dtype == "f4" else np.uint32
        return np.frombuffer(texture.read(), dtype).reshape(maps.layers, maps.size, maps.size, components)

    return renderer.worker.call(read)


def receivers(scene, frame, light=SUN, camera=CAMERA):
    """The lit-facing points of the frame in its map of most shadow, by rays: the map, rows, columns and `ReceiverSamples`."""
    points, normals, objects = oracle.surface_points(scene, camera, SIZE)
    towards = definition.towards_light(light, points.reshape(-1, 3)).reshape(points.shape)
    chosen = (objects >= 0) & ((normals * towards).sum(-1) > 0.02) & (frame.passes["object"] == objects)
    index = int(np.bincount(frame.passes["partition"][chosen], 1.0 - frame.passes["shadow"][chosen]).argmax())
    chosen &= frame.passes["partition"] == index
    rows, columns = np.nonzero(chosen)
    projection = frame.plan.projections[index]
    return (
        index,
        rows,
        columns,
        definition.ReceiverSamples(
            projection, light, frame.passes["shadow_depth"].shape[1], points[chosen], normals[chosen], objects[chosen]
        ),
    )


def agree(shown, expected, clear, least=0.9):
    """Every pixel whose decisions are clear is as defined, and most are clear."""
    assert clear.mean() > least
    assert np.abs(shown[clear] - expected[clear]).max() < 1e-5
    assert 0.005 < (expected < 0.6).mean() < 0.995


def sampled(r, depth01, side, places=None):
    """Cells (P, k, n, 2), NDC depths (P, k, n), and whether no tap is within a hundredth of a cell's border."""
    depth = depth01.astype(np.float64) * 2.0 - 1.0
    texels = r.texels()
    cells = definition.tap_cells(texels, side)
    where = np.zeros((*depth.shape, 1, 2), dtype=np.int64) if places is None else places
    offsets = definition.cell_values(where, cells)
    depths = definition.cell_values(definition.selected(depth, where), cells)
    fraction = np.abs((texels + (side - 1) / 2.0) % 1.0 - 0.5)
    return cells[:, :, None] + offsets, depths, (fraction < 0.49).all(axis=1)


@pytest.mark.parametrize(("warp", "partition"), PLANS)
@pytest.mark.parametrize("pcf", [1, 9])
def test_manual_id_depth_is_idds_comparison(renderer, warp, partition, pcf):
    scene, near, far = scenes.chair(), 0.01, 0.25
    frame = render(renderer, scene, settings(warp, partition, kind="id-depth", pcf=pcf, epsilon=near, epsilon_far=far))
    index, rows, columns, r = receivers(scene, frame)
    ids = layers_of(renderer, "ids", 1)[index, :, :, 0].astype(np.int64)
    cells, depths, clear = sampled(r, frame.passes["shadow_depth"][index], int(pcf**0.5))
    difference = r.distances_m(depths)
    same = definition.cell_values(ids, cells) == (r.ids + 1)[:, None, None]
    expected = definition.filtered(~definition.is_dark_by_id(difference, same, near, far))
    clear &= (np.minimum(np.abs(difference - near), np.abs(difference - far)) > 2e-4).all(axis=(1, 2))
    agree(frame.passes["shadow"][rows, columns], expected, clear)


@pytest.mark.parametrize("side", [1, 2, 3])
@pytest.mark.parametrize("depths", range(2, 9))
def test_pcf_over_an_n_sm_is_the_mean_of_composite_tests(renderer, depths, side):
    scene, bias = scenes.chair(), 0.02
    frame = render(renderer, scene, settings(depths=depths, pcf=side * side, bias_strategy="constant", bias=bias))
    index, rows, columns, r = receivers(scene, frame)
    _, depth, clear = sampled(
        r, frame.passes["shadow_depth"][index], side, definition.selected_places(frame.passes["shadow_depth"][index], depths)
    )
    difference = r.distances_m(depth)
    expected = definition.filtered(difference <= bias)
    clear &= (np.abs(difference - bias) > 2e-4).all(axis=(1, 2))
    agree(frame.passes["shadow"][rows, columns], expected, clear, least=0.7)


@pytest.mark.parametrize("with_ids", [False, True])
@pytest.mark.parametrize("depths", range(2, 9))
def test_selection_pass_gathers_the_cells_of_the_definition(renderer, depths, with_ids):
    kind = "id-depth" if with_ids else "depth"
    frame = render(renderer, scenes.chair(), settings(kind=kind, depths=depths, partition="z-adaptive"))
    for layer, depth in enumerate(frame.passes["shadow_depth"]):
        if frame.plan.projections[layer].is_empty:
            continue
        places = definition.selected_places(depth, depths)
        cells = np.concatenate([layers_of(renderer, ("depths", i), 4)[layer] for i in range(-(-depths // 4))], axis=-1)
        assert np.array_equal(cells[..., :depths], definition.selected(depth, places))
        if with_ids:
            stored = np.concatenate([layers_of(renderer, ("ids", i), 4)[layer] for i in range(-(-depths // 4))], axis=-1)
            assert np.array_equal(stored[..., :depths], definition.selected(layers_of(renderer, "ids", 1)[layer, :, :, 0], places))


@pytest.mark.parametrize(("warp", "partition"), PLANS)
def test_automatic_bias_compares_heights_over_the_receivers_plane(renderer, warp, partition):
    scene = scenes.staircase()
    frame = render(renderer, scene, settings(warp, partition))
    index, rows, columns, r = receivers(scene, frame)
    depth = frame.passes["shadow_depth"][index].astype(np.float64) * 2.0 - 1.0
    cell = definition.tap_cells(r.texels(), 1)[:, 0]
    offset = r.texels() - cell - 0.5
    side = np.where(offset < 0.0, -1, 1)

    def height(dx, dy):
        there = cell + np.stack([dx * side[:, 0], dy * side[:, 1]], axis=-1)
        return r.heights_m(there, definition.cell_values(depth, there))

    heights = np.stack([height(0, 0), height(1, 0), height(0, 1), height(1, 1)], axis=-1)
    steps = texel_footprint(r.projection, r.points_ws, r.light, r.size)
    bias = shadow_defines.AUTO_TILT * 0.5 * np.abs((steps * r.normals_ws[:, None]).sum(-1)).sum(-1)
    most = shadow_defines.FOOT_TEXELS * r.footprint_m()
    shares = shadow_defines.EDGE_SHARE, shadow_defines.FOOT_SHARE
    dark, near = heights > bias[:, None], np.abs(offset)
    expected = definition.is_dark_between(heights, dark, near, most, *shares)
    clear = (np.abs(heights - bias[:, None]) > 2e-4).all(axis=1) & (np.abs(heights - most[:, None]) > 2e-4).all(axis=1)
    for nudge in (0.99, 1.01):  # the share is not near its limit
        clear &= definition.is_dark_between(heights, dark, near, most, *np.multiply(shares, nudge)) == expected
    clear &= (near < 0.49).all(axis=1) & (near > 0.01).all(axis=1)
    assert ((expected != dark[:, 0]) & clear).any()
    agree(frame.passes["shadow"][rows, columns], 1.0 - expected, clear, least=0.8)


@pytest.mark.parametrize(("k", "n"), [(4, 1), (4, 2), (9, 1), (9, 2), (4, 3), (9, 4), (4, 8), (25, 3)])
def test_pcf_k_n_has_n_k_plus_1_levels(renderer, k, n):
    """A tilted half plane over a floor crosses every fraction of every kernel."""
    cover = scenes.sheet((-6.0, -6.0, 1.0), (0.31, -6.0, 1.0), (0.93, 6.0, 1.0), (-6.0, 6.0, 1.0))
    corner = scenes.sheet((-6.0, 0.4, 1.4), (6.0, 0.9, 1.4), (6.0, 6.0, 1.4), (-6.0, 6.0, 1.4))
    chosen = settings("uniform", size=64, depths=n, pcf=k)
    shadow = render(renderer, scenes.scene_of(scenes.floor(6.0), cover, corner), chosen).passes["shadow"]
    levels = np.unique(np.round(shadow * n * k).astype(int))
    assert np.abs(shadow * n * k - np.round(shadow * n * k)).max() < 1e-3
    if n == 2:  # the second depth is the largest of the 3x3: it never darkens more than its own cell
        assert len(levels) > k + 1
    else:
        assert len(levels) >= 0.85 * (n * k + 1)


def misclassified(renderer, scene, chosen, light=SUN, camera=CAMERA):
    """Share of lit-facing pixels on the wrong side of ½, and of those the share that should be lit; truth by rays in float64."""
    frame = render(renderer, scene, chosen, light, camera)
    points, normals, objects = oracle.surface_points(scene, camera, SIZE)
    flat = points.reshape(-1, 3)
    towards = definition.towards_light(light, flat).reshape(points.shape)
    counted = (objects >= 0) & ((normals * towards).sum(-1) > 0.01) & (objects == frame.passes["object"])
    lit = ~oracle.is_blocked(scene, points[counted], normals[counted], light)
    shown = frame.passes["shadow"][counted] >= 0.5
    return (lit != shown).mean(), (lit & ~shown).mean()


HARD = [scenes.chair, scenes.railing, scenes.open_sheet, scenes.doubled_sheet, scenes.coincident_boxes, scenes.staircase, scenes.closed_box]


@pytest.mark.parametrize("make", HARD)
@pytest.mark.parametrize("elevation", [8.0, 50.0])
def test_exact_test_is_right_where_the_depth_test_is_a_texel_off(renderer, make, elevation):
    scene, light = make(), scenes.sun(elevation, -70.0)
    depth, _ = misclassified(renderer, scene, settings(), light)
    exact, acne = misclassified(renderer, scene, settings(kind="triangle"), light)
    assert acne <= 2e-3
    assert exact <= max(0.35 * depth, 3e-3)


@pytest.mark.parametrize(("warp", "partition"), [("uniform", "none"), ("logpsm", "none"), ("lispsm-general", "z-adaptive")])
def test_outlines_find_wires_that_no_texel_shows(renderer, warp, partition):
    """Wires a fifth of a texel thick, each of eight triangles: most pixels' nine cells know none of them."""
    wires = [scenes.rod((x, -3.0, 1.5), (x + 1.0, 3.0, 1.7), 0.006, 4) for x in np.arange(-3.0, 3.0, 0.7)]
    scene, light = scenes.scene_of(scenes.floor(8.0), scenes.joined(*wires)), scenes.sun(30.0, 20.0)
    plain, _ = misclassified(renderer, scene, settings(warp, partition, size=64, kind="triangle"), light)
    outlined, acne = misclassified(renderer, scene, settings(warp, partition, size=64, kind="triangle", outlines=True), light)
    assert plain > 0.002
    assert outlined <= 0.1 * plain
    assert acne == 0.0


@pytest.mark.parametrize("warp", ["uniform", "lispsm-general", "logpsm"])
@pytest.mark.parametrize("partition", ["none", "z-adaptive", "faces"])
def test_exact_test_serves_every_warp_and_partition(renderer, warp, partition):
    exact, acne = misclassified(renderer, scenes.chair(), settings(warp, partition, kind="triangle"))
    assert exact < 0.004
    assert acne < 0.002


@pytest.mark.parametrize("past_px", [-1e-3, -3e-4, 1e-3])
def test_a_pixel_centre_just_past_a_crease_is_not_shadowed_by_the_face_behind_it(renderer, past_px):
    """The rasteriser rounds corners to 1/256 pixel, so the floor gets centres that lie inside the wall: a row of dark pixels otherwise."""
    floor, wall = scenes.sheet((-3, -3, 0), (3, -3, 0), (3, 0, 0), (-3, 0, 0)), scenes.sheet((-3, 0, 0), (3, 0, 0), (3, 0, 3), (-3, 0, 3))
    camera = scenes.look_at((0.0, -2.0, 1.5), (0.0, 0.0, 0.03 * past_px), near=0.3, far=20.0)
    chosen, passes = settings(size=256, kind="triangle"), ("shadow", "object")
    frame = run(
        Job(scenes.scene_of(scenes.joined(floor, wall)), camera, scenes.sun(40.0, -80.0), chosen, (160, 91), passes), on=renderer
    ).frame
    seen = frame.passes["object"] >= 0
    assert seen.sum() > 5000
    assert (frame.passes["shadow"][seen] == 1.0).all()


@pytest.mark.parametrize("kind", ["spot", "point"])
@pytest.mark.parametrize("test", ["depth", "triangle"])
def test_finite_lights_cast_right_shadows(renderer, kind, test):
    position = np.array([1.5, -1.0, 3.0])
    aim = position / np.linalg.norm(position)
    light = scenes.Light(kind, aim if kind == "spot" else None, position, 0.9)
    wrong, acne = misclassified(renderer, scenes.chair(), settings(kind=test, size=512), light)
    assert wrong < (0.02 if test == "depth" else 0.005)
    assert acne < 0.01


@pytest.mark.parametrize("kind", ["depth", "id-depth", "triangle"])
def test_coincident_and_two_sided_faces_do_not_shadow_themselves(renderer, kind):
    for make in (scenes.coincident_boxes, scenes.doubled_sheet, scenes.open_sheet):
        for elevation in (3.0, 35.0, 88.0):
            _, acne = misclassified(renderer, make(), settings(kind=kind, size=512), scenes.sun(elevation, 200.0))
            assert acne < 2e-3, (make.__name__, elevation)


@pytest.mark.parametrize("kind", TESTS)
def test_partition_borders_leave_no_lit_line(renderer, kind):
    """A floor wholly under a roof is dark everywhere the maps meet."""
    camera = scenes.look_at((0.0, 0.0, 1.7), (0.0, 60.0, 0.0), near=0.3, far=250.0)
    ground = scenes.sheet((-40.0, -5.0, 0.0), (40.0, -5.0, 0.0), (40.0, 200.0, 0.0), (-40.0, 200.0, 0.0))
    roof = scenes.sheet((-400.0, -400.0, 30.0), (400.0, -400.0, 30.0), (400.0, 600.0, 30.0), (-400.0, 600.0, 30.0))
    for partition in ("none", "z-adaptive", "z-log", "faces"):
        frame = render(renderer, scenes.scene_of(ground, roof), settings(partition=partition, size=64, kind=kind), scenes.sun(60.0), camera)
        floor = (frame.passes["object"] == 0) & (frame.passes["partition"] >= 0)
        assert floor.sum() > 1000
        assert (frame.passes["shadow"][floor] == 0.0).all()


def test_filter_in_pixels_and_metres_does_not_follow_the_warp(renderer):
    """The share of half-lit pixels stays within a quarter over warps; in texels it does not."""
    cover = scenes.sheet((-6.0, 0.0, 1.0), (6.0, 0.0, 1.0), (6.0, 6.0, 1.0), (-6.0, 6.0, 1.0))
    scene = scenes.scene_of(scenes.floor(6.0), cover)

    def soft(warp, **test):
        shadow = render(renderer, scene, settings(warp, size=1024, pcf=25, **test)).passes["shadow"]
        return ((shadow > 0.0) & (shadow < 1.0)).sum()

    for test in ({"filter_unit": "pixel", "filter_width": 12.0}, {"filter_unit": "metre", "filter_width": 0.4}):
        for kind in ("depth", "triangle"):
            widths = [soft(warp, kind=kind, **test) for warp in ("uniform", "lispsm-general", "logpsm")]
            assert min(widths) > 100
            assert max(widths) < 1.25 * min(widths)


def test_ids_are_per_object_or_per_object_and_material(renderer):
    frame = render(renderer, scenes.chair(), settings(kind="id-depth"))
    objects = np.unique(layers_of(renderer, "ids", 1))
    assert objects.min() == 0 and len(objects) == 1 + len(np.unique(frame.passes["object"])) - 1
    render(renderer, scenes.chair(), settings(kind="id-depth", id_per_material=True))
    assert len(np.unique(layers_of(renderer, "ids", 1))) == len(objects)


@given(st.integers(4, 8))
def test_neighbours_surround_the_centre_evenly(depths):
    cells = definition.spread_neighbours(depths)
    assert len({tuple(c) for c in cells.tolist()}) == depths - 1
    assert np.abs(cells).max() == 1 and (cells != 0).any(axis=1).all()
    turns = np.sort(np.arctan2(cells[:, 1], cells[:, 0]))
    assert np.diff(np.append(turns, turns[0] + 2.0 * np.pi)).max() < np.pi - 0.5  # a straight edge through the cell has one on either side


@given(st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=20), st.booleans(), st.floats(0.0, 0.5), st.floats(0.0, 1.0))
def test_idd_table(differences, same, near, beyond):
    d, far = np.array(differences), near + beyond
    dark = definition.is_dark_by_id(d, np.full(d.shape, same), near, far)
    assert dark[d > far].all()
    assert not dark[d <= near].any()
    middle = (d > near) & (d <= far)
    assert (dark[middle] == (not same)).all()


def test_settings_that_mean_nothing_are_refused():
    for wrong in (
        {"kind": "triangle", "depths": 2},
        {"pcf": 2},
        {"depths": 9},
        {"bias": float("nan")},
        {"epsilon": -1.0},
        {"filter_unit": "metre"},
        {"filter_width": 0.0},
        {"filter_unit": "inch"},
    ):
        with pytest.raises(SettingsError):
            ShadowTestChoice(**wrong)
    assert all(ShadowTestChoice(pcf=k).pcf == k for k in PCF_COUNTS)
