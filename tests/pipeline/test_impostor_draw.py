"""Captured and drawn relief impostors against the maths' warp, the captured texels and the true surfaces."""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from addon.errors import GpuError, SceneError
from addon.maths import spaces
from addon.maths.relief.frame import capture_frame
from addon.maths.relief.warp import relief_from_depth
from addon.pipeline.device import device_of
from addon.pipeline.gl.gl_raw import live_objects
from addon.pipeline.gl.readback import read_texture
from addon.pipeline.impostors.capture import capture, fingerprint
from addon.pipeline.impostors.draw import draw_impostor
from addon.pipeline.impostors.texels import kept_samples
from addon.pipeline.impostors.views import DrawnImpostor
from addon.pipeline.passes.gbuffer import FROM_TEXTURE, GBuffer, draw_gbuffer, pixel_rays
from tests import scenes
from tests.maths.relief.rigs import chosen, corners, project_texels

SIZE = (208, 117)
MIDDLE = np.array([0.0, 0.0, 0.5])
PARTS = (
    scenes.box((-0.6, -0.5, 0.0), (0.2, 0.3, 0.5)),
    scenes.ball((0.3, -0.3, 0.6), 0.3),
    scenes.rod((-0.5, 0.6, 0.0), (-0.5, 0.6, 1.1), 0.06),
)


def orbit(angle: float, distance: float = 5.0, height: float = 0.4, fov_y_deg: float = 22.0, ortho_height: float | None = None):
    """A camera round the parts."""
    flat = np.array([np.sin(angle), -np.cos(angle), 0.0]) * np.cos(height)
    eye = MIDDLE + distance * (flat + [0.0, 0.0, np.sin(height)])
    options = {"near": 0.1, "far": 30.0}
    camera = scenes.look_at(tuple(eye), tuple(MIDDLE), fov_y_deg=fov_y_deg, **options)
    if ortho_height is None:
        return camera
    return replace(camera, clip_from_view=spaces.orthographic(ortho_height / 2, 16.0 / 9.0, 0.1, 30.0))


class Rig:
    """One scene on the worker: captures, draws, reads back (row 0 at the top)."""

    def __init__(self, context, worker, scene=None):
        self.context, self.device = context, device_of(context, worker)
        self.scene = scene or scenes.scene_of(*PARTS)
        self.draw_list = self.device.store.sync(self.scene)
        self.rows = np.ones(len(self.scene.instances), bool)

    def hull(self, rows=None):
        bounds = self.scene.instance_bounds_ws()[self.rows if rows is None else rows]
        return corners(bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0))

    def capture(self, camera, rows=None, texels=2.0, perspective=True, **options):
        rows = self.rows if rows is None else rows
        frame = capture_frame(self.hull(rows), camera, SIZE, chosen(perspective=perspective, texels_per_pixel=texels, max_texels=4096))
        return capture(self.device, self.draw_list, rows, frame, **options)

    def direct(self, camera, rows=None):
        with self.target() as target:
            draw_gbuffer(self.context, self.device.programs, target, self.draw_list, camera, rows)
            return self.read(target)

    def draw(self, camera, *impostors, geometry=None, **options):
        with self.target() as target:
            draw_gbuffer(self.context, self.device.programs, target, self.draw_list, camera, ~self.rows if geometry is None else geometry)
            for impostor in impostors:
                draw_impostor(self.device, target, impostor, self.hull(), camera, **options)
            return self.read(target)

    def shown(self, camera, drawn):
        """(h, w) where a `DrawnImpostor` shows something."""
        with self.target() as target:
            draw_gbuffer(self.context, self.device.programs, target, self.draw_list, camera, ~self.rows)
            drawn.draw(self.device, target, camera)
            return self.read(target)[1][..., 0] > 0

    @contextmanager
    def target(self):
        target = GBuffer(self.context, SIZE)
        try:
            yield target
        finally:
            self.device.unbind()
            target.release()

    def read(self, target):
        return read_texture(target.view_depth), read_texture(target.ids) & ~np.uint32(FROM_TEXTURE)


@pytest.fixture
def on_gl(worker):
    """Runs a function of a `Rig` on the worker; no GL error and no leaked raw object afterwards."""

    def run(job, scene=None):
        def on_worker(context):
            rig = Rig(context, worker, scene)
            kept_samples(rig.device).release()
            before = live_objects(context)
            out = job(rig)
            kept_samples(rig.device).release()
            assert live_objects(context) == before
            assert context.error == "GL_NO_ERROR"
            return out

        return worker.call(on_worker)

    return run


def points_of(camera, depth):
    """(P, 3) world points of the pixels that hold something, and their pixel centres (P, 2) from the top left."""
    row, column = np.nonzero(depth)
    along, start = pixel_rays(camera, SIZE)
    pixel = np.stack([column + 0.5, SIZE[1] - row - 0.5, np.ones(len(row))], axis=-1)
    return pixel @ start.T + depth[row, column, None] * (pixel @ along.T), np.stack([column + 0.5, row + 0.5], axis=-1)


@pytest.mark.parametrize("method", ["inverse", "forward"])
@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("camera", [orbit(0.5), orbit(0.2, 4.0, 0.6), orbit(0.45, ortho_height=2.2)])
def test_every_pixel_lies_within_half_a_pixel_of_where_the_warp_sends_its_texel(on_gl, method, perspective, camera):
    """The pixel's point names a texel; that texel's captured point, warped and projected in float64, falls into the pixel (or the texel's
    back does: a wall). With four texels a pixel, the texel itself is at most 0.18 pixel from its centre."""

    def job(rig):
        impostor = rig.capture(orbit(0.3), texels=4.0, perspective=perspective)
        depth, ids = rig.draw(camera, impostor, method=method)
        impostor.release()
        return impostor, depth, ids

    impostor, depth, ids = on_gl(job)
    points, pixels = points_of(camera, depth)
    assert len(points) == (ids[..., 0] > 0).sum() > 1000
    uv, relief = impostor.frame.texels(points)
    cell = np.clip(np.floor(uv).astype(int), 0, [impostor.frame.width - 1, impostor.frame.height - 1])
    held = impostor.mask[cell[:, 1], cell[:, 0]]
    distance = np.full(len(points), np.inf)
    for layer in (impostor.depth_m, impostor.back_m):
        captured = relief_from_depth(impostor.frame.source, np.where(held, layer[cell[:, 1], cell[:, 0]], 0.0))
        expected = project_texels(impostor.frame, camera, SIZE, cell + 0.5, captured)
        distance = np.minimum(distance, np.where(held, np.abs(expected - pixels).max(axis=1), np.inf))
    assert np.mean(distance <= 0.5) > (0.97 if method == "inverse" else 0.9)
    assert np.median(distance) < 0.25


@pytest.mark.parametrize("method", ["inverse", "sprite"])
@pytest.mark.parametrize(
    "camera",
    [orbit(0.3), scenes.look_at((1.0, -4.0, 1.5), (0.6, 0.0, 0.9), fov_y_deg=30.0, near=0.1, far=30.0), orbit(0.3, ortho_height=2.2)],
)
def test_at_the_captures_eye_one_texel_a_pixel_is_the_picture_itself(on_gl, method, camera):
    """Also for an object beside the middle of the picture."""

    def job(rig):
        impostor = rig.capture(camera, texels=1.0)
        out = rig.direct(camera), rig.draw(camera, impostor, method=method), impostor.frame.texel_m
        impostor.release()
        return out

    (depth, ids), (drawn_depth, drawn_ids), texel_m = on_gl(job)
    there = ids[..., 0] > 0
    assert np.mean((ids == drawn_ids)[..., 0][there | (drawn_ids[..., 0] > 0)]) > 0.998
    apart = np.abs(drawn_depth - depth)[there] / texel_m
    assert np.quantile(apart, 0.9) < 0.02
    assert np.quantile(apart, 0.995) < 0.5


def test_the_inverse_warp_beats_the_sprite_and_the_forward_warp_away_from_the_capture(on_gl):
    def job(rig):
        camera = orbit(0.65)
        impostor = rig.capture(orbit(0.3))
        out = rig.direct(camera)[1], {m: rig.draw(camera, impostor, method=m)[1] for m in ("inverse", "forward", "sprite")}
        impostor.release()
        return out

    ids, drawn = on_gl(job)
    overlap = {m: ((i[..., 0] > 0) & (ids[..., 0] > 0)).sum() / ((i[..., 0] > 0) | (ids[..., 0] > 0)).sum() for m, i in drawn.items()}
    assert overlap["inverse"] > 0.96
    assert overlap["inverse"] > overlap["forward"] > overlap["sprite"]


def test_the_back_layer_shows_the_walls_that_the_front_alone_leaves_open(on_gl):
    def job(rig):
        camera = orbit(0.7, height=0.1)
        both, sheet = rig.capture(orbit(0.0, height=0.1)), rig.capture(orbit(0.0, height=0.1), with_back=False)
        out = [(i[..., 0] > 0) for _, i in (rig.direct(camera), rig.draw(camera, both), rig.draw(camera, sheet))]
        both.release()
        sheet.release()
        return out

    truth, both, sheet = on_gl(job)
    missing = [(truth & ~m).sum() / truth.sum() for m in (both, sheet)]
    assert missing[0] < 0.02
    assert missing[1] > 3 * missing[0]
    assert (both & ~truth).sum() / truth.sum() < 0.04


def test_no_rubber_sheet_spans_a_depth_step(on_gl):
    """A rod before a wall: from the side, what shows between them is neither. Every point drawn lies near a true surface."""
    scene = scenes.scene_of(scenes.box((-1.0, 0.8, 0.0), (1.0, 0.9, 1.0)), scenes.rod((0.0, -0.9, 0.0), (0.0, -0.9, 1.0), 0.05))
    camera = orbit(0.35, height=0.05)

    def job(rig):
        impostor = rig.capture(orbit(0.0, height=0.05), texels=4.0)
        depth, _ = rig.draw(camera, impostor)
        impostor.release()
        return depth

    points, _ = points_of(camera, on_gl(job, scene))
    to_wall = np.linalg.norm(points - np.clip(points, [-1.0, 0.8, 0.0], [1.0, 0.9, 1.0]), axis=1)
    to_rod = np.abs(np.hypot(points[:, 0], points[:, 1] + 0.9) - 0.05)
    assert np.minimum(to_wall, to_rod).max() < 0.03
    assert (to_rod < 0.03).sum() > 100


def test_a_face_seen_at_a_slant_does_not_grow_beyond_the_outline(on_gl):
    """Its planes are so steep that a texel's would reach far out where the eye turns away from the face."""

    def job(rig):
        impostor = rig.capture(eye(0.0), texels=1.0)
        pictures = [(rig.draw(eye(turn), impostor)[1], rig.direct(eye(turn))[1]) for turn in (0.04, 0.09)]
        impostor.release()
        return pictures

    def eye(turn):
        return orbit(0.05 - turn, distance=4.0, height=0.25)

    slab = scenes.box((-0.5, -0.8, 0.1), (0.13, 0.8, 0.8))
    for ids, truth in on_gl(job, scene=scenes.scene_of(slab)):
        shown, seen = ids[..., 0] > 0, truth[..., 0] > 0
        assert (shown & ~seen).sum() < 0.01 * seen.sum()


@pytest.mark.parametrize("perspective", [True, False])
def test_leaping_over_tiles_leaving_out_blocks_and_taking_smooth_ones_apart_changes_no_picture(on_gl, perspective):
    """Against the walk through every texel from the plane to the bounds' back."""

    def job(rig):
        impostor = rig.capture(orbit(0.4), perspective=perspective)
        impostor.content_uv = np.array([[0.0, 0.0], [impostor.frame.width, impostor.frame.height]])
        eyes = [orbit(0.4 + turn, height=0.4 + turn / 3) for turn in (0.0, 0.1, -0.3, 0.7)]
        leapt = [rig.draw(eye, impostor) for eye in eyes]
        for grid, anything in ((impostor.tiles, [0.0, 1e9, 0.0]), *((grid, [0.0, 1e9, 1e9, 0.0]) for grid in impostor.windows)):
            grid.write(np.tile(np.float32(anything), (*grid.size[::-1], 1)).tobytes())
        impostor.nearest = 0.0
        walked = [rig.draw(eye, impostor) for eye in eyes]
        impostor.release()
        return leapt, walked

    for (depth, ids), (true_depth, true_ids) in zip(*on_gl(job), strict=True):
        assert (true_ids[..., 0] > 0).sum() > 2000
        assert ((ids != true_ids).any(axis=-1) | (np.abs(depth - true_depth) > 1e-4)).sum() <= 3


def test_impostors_and_geometry_hide_each_other_by_depth(on_gl):
    def job(rig):
        rows = np.array([True, False, False])
        impostor = rig.capture(orbit(0.3), rows, texels=4.0)
        out = []
        for angle in (0.3, 0.6, -0.1):
            camera = orbit(angle)
            out.append((rig.direct(camera), rig.draw(camera, impostor, geometry=~rows)))
        impostor.release()
        return out

    for (depth, ids), (mixed_depth, mixed_ids) in on_gl(job):
        both = (ids[..., 0] > 0) & (mixed_ids[..., 0] > 0)
        assert np.mean((ids[..., 0] == mixed_ids[..., 0])[both]) > 0.985
        assert np.quantile(np.abs(depth - mixed_depth)[both], 0.95) < 5e-3


def test_a_crossfade_shares_the_pixels_between_old_and_new(on_gl):
    def job(rig):
        camera = orbit(0.3)
        impostor = rig.capture(camera)
        whole = rig.draw(camera, impostor)[1][..., 0] > 0
        parts = [(rig.draw(camera, impostor, fade=0.4, fade_rest=rest)[1][..., 0] > 0) for rest in (False, True)]
        impostor.release()
        return whole, parts

    whole, (new, old) = on_gl(job)
    assert not (new & old).any()
    np.testing.assert_array_equal(new | old, whole)
    assert new.sum() / whole.sum() == pytest.approx(0.4, abs=0.05)


def test_a_crossfade_shows_no_hole_where_the_new_texture_has_a_surface(on_gl):
    def job(rig):
        camera = orbit(0.6)
        old, new = rig.capture(orbit(0.0)), rig.capture(orbit(0.55))
        shown = [rig.shown(camera, DrawnImpostor(new, rig.hull(), False, "inverse", *fade)) for fade in ((1.0, None), (0.3, old))]
        alone = rig.draw(camera, old)[1][..., 0] > 0
        for impostor in (old, new):
            impostor.release()
        return *shown, alone

    new, fading, old = on_gl(job)
    assert (new & ~old).sum() >= 10
    assert not (new & ~fading).any()


def test_an_impostor_seen_from_behind_its_plane_is_refused_and_an_empty_or_too_large_one_never_made(on_gl):
    def job(rig):
        impostor = rig.capture(orbit(0.3))
        with pytest.raises(SceneError, match="before the impostor's plane"):
            rig.draw(orbit(0.3 + np.pi), impostor)
        impostor.release()
        impostor.release()
        frame = capture_frame(rig.hull() + [0.0, 0.0, 50.0], scenes.look_at((0, -5, 50), (0, 0, 50), near=0.1, far=30.0), SIZE)
        with pytest.raises(SceneError, match="empty"):
            capture(rig.device, rig.draw_list, rig.rows, frame)
        huge = capture_frame(rig.hull(), orbit(0.3), SIZE)
        object.__setattr__(huge, "width", rig.context.info["GL_MAX_TEXTURE_SIZE"] + 1)
        with pytest.raises(GpuError, match="limit"):
            capture(rig.device, rig.draw_list, rig.rows, huge)

    on_gl(job)


def test_the_fingerprint_follows_the_captured_objects_and_nothing_else(on_gl):
    first = scenes.scene_of(*PARTS)
    moved = [np.eye(4) for _ in PARTS]
    moved[2] = moved[2].copy()
    moved[2][0, 3] = 0.4
    rows = np.array([True, True, False])

    def job(rig):
        prints = []
        for scene in (first, scenes.scene_of(*PARTS, matrices=moved), scenes.scene_of(scenes.box((0, 0, 0), (1, 1, 1)), *PARTS[1:])):
            draw_list = rig.device.store.sync(scene)
            prints.append((fingerprint(draw_list, rows), fingerprint(draw_list, ~rows)))
        return prints

    (a, a_rest), (b, b_rest), (c, _) = on_gl(job, first)
    assert a == b != c
    assert a_rest != b_rest
