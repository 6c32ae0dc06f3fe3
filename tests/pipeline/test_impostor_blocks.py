"""How an impostor's picture is divided: blocks of pixels, smooth ones apart, and the grids that say so."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.relief.frame import capture_frame
from addon.pipeline.device import device_of
from addon.pipeline.gl.readback import read_texture
from addon.pipeline.impostors.capture import capture
from addon.pipeline.impostors.draw import draw_impostor
from addon.pipeline.impostors.texels import EMPTY
from addon.pipeline.impostors.tiles import OVERLAP, STRIDES, TILE, tiles_and_windows
from addon.pipeline.passes.gbuffer import GBuffer, draw_gbuffer
from tests import scenes
from tests.margins import agree
from tests.maths.relief.rigs import chosen, corners

CONTINUOUS = 0.25
MARGIN = (OVERLAP + 1) * STRIDES[-1]


def _layers(rng, height, width):
    """Texels of a bumpy surface with holes, edges and steps."""
    layers = np.zeros((height, width, 4), np.float32)
    layers[..., 0] = rng.uniform(1.0, 1.1, (height, width))
    layers[..., 1:3] = rng.normal(0.0, 0.05, (height, width, 2))
    layers[..., 3] = layers[..., 0] + rng.uniform(0.0, 2.0, (height, width))
    layers[rng.random((height, width)) < 0.002, 0] *= -1.0
    layers[rng.random((height, width)) < 0.002, 0] += 2.0
    layers[rng.random((height, width)) < 0.002] = (EMPTY, 0.0, 0.0, -1.0)
    return layers


def _grown(image, empty):
    """(h, w) the largest of every texel and the eight round it."""
    padded = np.pad(image, 1, constant_values=empty)
    return np.max([padded[j : j + image.shape[0], i : i + image.shape[1]] for j in range(3) for i in range(3)], axis=0)


def _smooth(layers):
    """(h, w) whether a texel is whole, and its plane meets those of the next ones at their common borders."""
    a, du, dv = layers[..., 0], layers[..., 1], layers[..., 2]
    smooth = (a >= 0.0) & (a < EMPTY)
    for j, i in np.argwhere(smooth):
        if i + 1 < a.shape[1]:
            smooth[j, i] &= abs((a[j, i] + 0.5 * du[j, i]) - (a[j, i + 1] - 0.5 * du[j, i + 1])) <= CONTINUOUS
        if j + 1 < a.shape[0]:
            smooth[j, i] &= abs((a[j, i] + 0.5 * dv[j, i]) - (a[j + 1, i] - 0.5 * dv[j + 1, i])) <= CONTINUOUS
    return smooth


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 45), st.integers(1, 45))
def test_the_grids_bound_what_their_squares_of_texels_hold(seed, height, width):
    rng = np.random.default_rng(seed)
    layers = _layers(rng, height, width)
    tiles, windows = tiles_and_windows(layers, CONTINUOUS)
    assert tiles.shape == (-(-height // TILE) + 2, -(-width // TILE) + 2, 3)
    for stride, grid in zip(STRIDES, windows, strict=True):
        assert grid.shape == (-(-height // stride) + OVERLAP + 1, -(-width // stride) + OVERLAP + 1, 4)
    front, slopes = np.abs(layers[..., 0]), np.abs(layers[..., 1:3]).sum(axis=-1)
    behind = np.where(front < EMPTY, np.maximum(layers[..., 3], front + 2.0 * slopes + CONTINUOUS), -1.0)
    far = np.where(_smooth(layers), front + 0.5 * slopes, EMPTY)
    near, behind, far, slopes = (
        np.pad(image, MARGIN, constant_values=empty)
        for image, empty in ((front - 0.5 * slopes, EMPTY), (behind, -1.0), (far, EMPTY), (slopes, 0.0))
    )
    about, around = -_grown(-near, -EMPTY), _grown(behind, -1.0)
    behind = np.where(np.pad(np.ones((height, width), bool), MARGIN), around, -1.0)

    def square(image, first, side):
        top, left = MARGIN + first
        return image[top : top + side, left : left + side]

    for _ in range(12):
        place = rng.integers(tiles.shape[:2] - np.array([2, 2])) + 1
        at = TILE * (place - 1), TILE
        agree(tiles[*place][[0, 2]], [square(about, *at).min(), square(near, *at).min()], rel=1e-6)
        assert square(behind, *at).max() - 1e-5 <= tiles[*place][1] <= square(around, *at).max() + 1e-5
        for stride, grid in zip(STRIDES, windows, strict=True):
            place = rng.integers(grid.shape[:2])
            at = stride * (place - OVERLAP), stride * OVERLAP
            expected = [square(near, *at).min(), square(far, *at).max(), square(slopes, *at).max()]
            agree(grid[*place][[0, 2, 3]], expected, rel=1e-5)
            assert square(behind, *at).max() - 1e-5 <= grid[*place][1] <= square(around, *at).max() + 1e-5


def _taken(context, worker, scene, camera, size):
    """A capture of all of a scene, two texels a pixel, its bounds' corners, and a function that draws it: (h, w) ids."""
    device = device_of(context, worker)
    draw_list, rows = device.store.sync(scene), np.ones(len(scene.instances), bool)
    bounds = scene.instance_bounds_ws()
    hull = corners(bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0))
    frame = capture_frame(hull, camera, size, chosen(texels_per_pixel=1.0, max_texels=2048))
    impostor = capture(device, draw_list, rows, frame)

    def draw(eye, picture):
        target = GBuffer(context, picture)
        draw_gbuffer(context, device.programs, target, draw_list, eye, ~rows)
        draw_impostor(device, target, impostor, hull, eye)
        ids = read_texture(target.ids)
        device.unbind()
        target.release()
        return ids

    return impostor, draw


@pytest.mark.parametrize("picture", [(5, 3), (8, 8), (13, 50), (20, 11), (100, 4)])
def test_the_blocks_cover_a_picture_of_any_size_to_its_last_pixel(worker, picture):
    """A wall that fills more than the picture."""
    scene = scenes.scene_of(scenes.box((-60.0, 0.0, -60.0), (60.0, 0.5, 60.0)))
    camera = scenes.look_at((0.0, -30.0, 0.0), (0.0, 0.0, 0.0), fov_y_deg=20.0, near=0.1, far=100.0)
    aside = scenes.look_at((3.0, -30.0, 1.0), (0.0, 0.0, 0.0), fov_y_deg=20.0, near=0.1, far=100.0)

    def job(context):
        impostor, draw = _taken(context, worker, scene, camera, (64, 64))
        ids = [draw(eye, picture) for eye in (camera, aside)]
        impostor.release()
        return ids

    for ids in worker.call(job):
        assert ids.shape[:2] == picture[::-1]
        assert (ids[..., 0] > 0).all()


def test_what_is_smooth_is_drawn_without_the_walk_and_is_the_same(worker):
    """With its tiles emptied the walk finds nothing: what is still drawn are the smooth blocks, most of a ball and none of its outline."""
    scene = scenes.scene_of(scenes.ball((0.0, 0.0, 0.0), 1.0))
    first, eye = (scenes.look_at((x, -6.0, 0.5), (0.0, 0.0, 0.0), fov_y_deg=22.0, near=0.1, far=30.0) for x in (0.0, 0.5))

    def job(context):
        impostor, draw = _taken(context, worker, scene, first, (400, 400))
        whole = draw(eye, (400, 400))
        impostor.tiles.write(np.tile(np.float32([EMPTY, -1.0, EMPTY]), (*impostor.tiles.size[::-1], 1)).tobytes())
        smooth = draw(eye, (400, 400))
        impostor.release()
        return whole, smooth

    whole, smooth = worker.call(job)
    shown, drawn = whole[..., 0] > 0, smooth[..., 0] > 0
    assert not (drawn & ~shown).any()
    assert 0.6 * shown.sum() < drawn.sum() < 0.97 * shown.sum()
    assert (whole == smooth)[drawn].all()
