"""What the GPU draws against numpy oracles, cell by cell."""

import numpy as np
import pytest

from addon.errors import SettingsError
from addon.images.exr import encode_exr
from addon.maths.error import measure
from addon.maths.shadow import lookup
from addon.pipeline.job import Job
from addon.pipeline.render_passes import DATA_PASSES, ENGINE_PASSES, PASSES, RENDER_PASSES
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes
from tests.pipeline import oracle

SIZE = (96, 64)
MAP = 64
EDGE_CELLS = 1.5 / 256  # GL snaps vertices to 1/256 of a cell: centres nearer to an edge may fall on either side of it
CAMERA = scenes.look_at((14.0, -16.0, 9.0), (0.0, 0.0, 0.7), fov_y_deg=35.0, near=1.0, far=80.0)
SUN = scenes.sun(40.0)
PLANS = [("uniform", "none"), ("lispsm-general", "none"), ("lispsm-general", "z-adaptive"), ("lispsm-general", "z-log")]
SCENES = [scenes.closed_box, scenes.railing, scenes.chair, scenes.staircase]


def settings(warp="lispsm-general", partition="none", fit="scene", size=MAP, **test):
    return Settings().replaced(
        warp={"kind": warp}, partition={"kind": partition}, fit={"kind": fit, "size": size}, test={"kind": "depth", **test}
    )


def render(renderer, scene, chosen, passes=DATA_PASSES, light=SUN, camera=CAMERA):
    return run(Job(scene, camera, light, chosen, SIZE, passes), on=renderer).frame


@pytest.mark.parametrize("make", SCENES)
def test_view_depth_is_the_nearest_surface_at_the_pixel_centre(renderer, make):
    scene = make()
    frame = render(renderer, scene, settings(), ("depth",))
    expected, margin = oracle.view_depth(scene, CAMERA, SIZE)
    clear = margin > EDGE_CELLS
    assert clear.mean() > 0.9
    assert np.array_equal(np.isfinite(frame.passes["depth"])[clear], np.isfinite(expected)[clear])
    both = clear & np.isfinite(expected)
    # float32 interpolation of 1/w over a triangle, plus the snapping (1/256 pixel) times the surface's slope
    assert np.median(np.abs(frame.passes["depth"][both] / expected[both] - 1.0)) < 2e-5
    assert np.max(np.abs(frame.passes["depth"][both] / expected[both] - 1.0)) < 5e-3


@pytest.mark.parametrize("make", SCENES)
@pytest.mark.parametrize(("warp", "partition"), PLANS)
def test_shadow_depth_is_the_nearest_caster_at_the_texel_centre(renderer, make, warp, partition):
    scene = make()
    frame = render(renderer, scene, settings(warp, partition), ("texel",))
    for layer, projection in enumerate(frame.plan.projections):
        expected, margin = oracle.shadow_depth(scene, projection, MAP)
        clear = margin > EDGE_CELLS
        difference = np.abs(frame.passes["shadow_depth"][layer] - expected)[clear]
        # depth is affine over a triangle in NDC: what is left is the snapping (1/256 texel) times the depth's slope per texel
        slope = np.abs(np.gradient(expected, axis=0)) + np.abs(np.gradient(expected, axis=1))
        assert np.mean(difference > 2e-6 + slope[clear] / 128.0) < 2e-3
        assert np.median(difference) < 1e-6


@pytest.mark.parametrize(("warp", "partition"), PLANS)
def test_the_shader_asks_the_partition_the_oracle_names(renderer, warp, partition):
    frame = render(renderer, scenes.border_floor(60.0, 12), settings(warp, partition), ("depth", "partition"))
    seen = np.isfinite(frame.passes["depth"])
    points = surface_points(frame.passes["depth"], CAMERA)
    expected = lookup.partition_index(frame.plan, CAMERA, points)
    wrong = frame.passes["partition"][seen] != expected
    assert wrong.mean() < 2e-3  # only pixels within float32 rounding of a border
    assert np.all(frame.passes["partition"][~seen] == -1)


@pytest.mark.parametrize("fit", ["scene", "samples", "frustum"])
@pytest.mark.parametrize(("warp", "partition"), PLANS)
def test_measured_errors_are_those_of_the_jacobian(renderer, warp, partition, fit):
    frame = render(renderer, scenes.closed_box(), settings(warp, partition, fit), ("depth", "normal", "aliasing", "partition"))
    seen = np.isfinite(frame.passes["depth"]) & (frame.passes["partition"] >= 0)
    points = surface_points(frame.passes["depth"], CAMERA)[seen[np.isfinite(frame.passes["depth"])]]
    expected = measure.aliasing(CAMERA, SUN, frame.plan, points, frame.passes["normal"][seen].astype(np.float64), SIZE, MAP)
    got = frame.passes["aliasing"][seen]
    agree = np.abs(got / expected - 1.0) < 2e-3
    assert agree.all(axis=1).mean() > 0.995  # the rest lies within rounding of a partition border
    assert np.isnan(frame.passes["aliasing"][~seen]).all()


@pytest.mark.parametrize(("warp", "partition"), PLANS)
@pytest.mark.parametrize("make", SCENES)
def test_light_is_what_the_stored_depth_says_of_the_receiver_plane(renderer, make, warp, partition):
    """Shadow iff the cell's occluder stands above the receiver's plane; heights near the bias are left out. (The automatic test asks four
    cells: test_shadow_tests.py.)"""
    chosen = settings(warp, partition, bias_strategy="receiver-plane", bias=0.5)
    frame = render(renderer, make(), chosen, ("depth", "normal", "shadow", "partition", "texel"))
    seen = np.isfinite(frame.passes["depth"]) & (frame.passes["partition"] >= 0)
    points = surface_points(frame.passes["depth"], CAMERA)[seen[np.isfinite(frame.passes["depth"])]]
    normals = frame.passes["normal"][seen].astype(np.float64)
    heights, high = occluder_heights(frame, points, normals, frame.passes["partition"][seen])
    faces = normals @ SUN.direction_ws > 1e-3
    shadow = frame.passes["shadow"][seen]
    assert np.all(shadow[normals @ SUN.direction_ws < -1e-3] == 0.0)
    far_above, below = faces & (heights > high), faces & (heights < 1e-4)
    assert far_above.sum() + below.sum() > 0.2 * faces.sum()
    assert not far_above.any() or np.mean(shadow[far_above] == 0.0) > 0.99
    assert np.mean(shadow[below] == 1.0) > 0.995


def surface_points(depth, camera):
    """(P, 3) float64 surface points of the pixels with a surface, row by row."""
    y, x = np.nonzero(np.isfinite(depth))
    h, w = depth.shape
    p = camera.clip_from_view
    ndc = np.stack([(x + 0.5) * 2 / w - 1, 1 - (y + 0.5) * 2 / h], axis=-1)
    z = depth[y, x].astype(np.float64)
    view = np.stack([(ndc[:, 0] + p[0, 2]) / p[0, 0] * z, (ndc[:, 1] + p[1, 2]) / p[1, 1] * z, -z, np.ones_like(z)], axis=-1)
    return (view @ camera.world_from_view.T)[:, :3]


def occluder_heights(frame, points, normals, index):
    """(P,) metres the occluder in each point's own cell stands above the point's plane, and (P,) metres far above any bias."""
    out, high = np.empty(len(points)), np.empty(len(points))
    for i, projection in enumerate(frame.plan.projections):
        here = index == i
        s, t, _, _ = lookup.project(projection, points[here])
        cell = np.clip(np.floor((np.stack([s, t], -1) * 0.5 + 0.5) * MAP).astype(int), 0, MAP - 1)
        stored = frame.passes["shadow_depth"][i][cell[:, 1], cell[:, 0]] * 2.0 - 1.0
        centre = (cell + 0.5) * 2.0 / MAP - 1.0
        occluder = lookup.unproject(projection, centre[:, 0], centre[:, 1], stored.astype(np.float64))
        out[here] = ((occluder - points[here]) * normals[here]).sum(axis=1)
        steps = lookup.texel_footprint(projection, points[here], SUN, MAP)
        high[here] = np.linalg.norm(steps, axis=-1).max(axis=-1)
    return out, high


def test_every_pass_is_written_and_shown(renderer):
    frame = render(renderer, scenes.chair(), settings(), PASSES)
    assert set(frame.passes) == {row.array for row in RENDER_PASSES.values()}
    for row in RENDER_PASSES.values():
        image = frame.passes[row.array]
        assert row.picture(frame.passes).dtype in (np.uint8, np.uint16), row.name
        planes = row.channels(image)
        assert sum(plane.size for plane in planes.values()) == image.size, row.name
        assert encode_exr(planes)
        if row.blender is not None:
            shown = row.blender.shown(image)
            assert np.isfinite(shown).all() and shown.size == SIZE[0] * SIZE[1] * len(row.blender.channels), row.name


def test_blenders_passes_start_with_combined_and_each_has_its_place():
    assert ENGINE_PASSES[0] == "combined"
    assert len({RENDER_PASSES[name].blender.place for name in ENGINE_PASSES}) == len(ENGINE_PASSES)


def test_a_pass_that_there_is_not_is_refused(renderer):
    with pytest.raises(SettingsError, match="Pass is 'colour': choose one of combined, "):
        render(renderer, scenes.chair(), settings(), ("combined", "colour"))
