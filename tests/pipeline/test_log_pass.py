"""LogPSM's maps on stock OpenGL against rays through their texel centres."""

import numpy as np
import pytest
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.spatial import Delaunay

from addon.maths.shadow.lookup import unproject
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.pipeline.passes import log_map
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes
from tests.pipeline.oracle import world_corners

SIZE, MAP = (96, 64), 128
CAMERA = scenes.look_at((0.5, -9.0, 1.7), (0.0, 10.0, 0.5), fov_y_deg=50.0, near=0.2, far=60.0)
SUN = scenes.sun(50.0, 100.0)


def ray_depth(scene, projection, size):
    """(N, N) depth 0…1 of the first triangle met by the light's ray through each texel centre, float64; 1 where none; and its runner-up."""
    centre = (np.arange(size) + 0.5) * 2.0 / size - 1.0
    s, t = np.meshgrid(centre, centre)
    near, far = (unproject(projection, s, t, np.full_like(s, d)).reshape(-1, 3) for d in (-1.0, 1.0))
    origin, ray = near, far - near
    depth = np.full(len(origin), np.inf)
    for a, b, c in world_corners(scene):
        e1, e2 = b - a, c - a
        h = np.cross(ray, e2)
        det = h @ e1
        safe = np.where(np.abs(det) > 1e-300, det, 1.0)
        q = origin - a
        u = (q * h).sum(axis=1) / safe
        k = np.cross(q, e1)
        v = (ray * k).sum(axis=1) / safe
        x = (k @ e2) / safe
        hit = (np.abs(det) > 1e-300) & (u >= 0) & (v >= 0) & (u + v <= 1)
        depth = np.where(hit, np.minimum(depth, x), depth)
    return np.where(np.isfinite(depth), np.clip(depth, 0.0, 1.0), 1.0).reshape(size, size)


BENT = [{"kind": "logpsm", "log_bend": bend} for bend in (-0.9, 3.0, 30.0)]


@pytest.mark.parametrize("warp", ["logpsm", "log", *BENT], ids=str)
@pytest.mark.parametrize("make", [scenes.railing, scenes.chair, scenes.border_floor])
def test_the_map_holds_what_rays_through_its_texel_centres_meet(renderer, make, warp):
    scene = make()
    frame = log_frame(renderer, scene, warp)
    projection = frame.plan.projections[0]
    assert projection.log is not None
    expected = ray_depth(scene, projection, MAP)
    wrong = np.abs(frame.passes["shadow_depth"][0] - expected) > 1e-3
    assert (expected < 1.0).mean() > 0.2
    assert wrong.mean() <= 1e-3


def log_frame(renderer, scene, warp="logpsm", **test):
    """A frame with one logarithmic map of MAP² texels."""
    kind = warp if isinstance(warp, dict) else {"kind": warp}
    chosen = Settings().replaced(warp=kind, partition={"kind": "none"}, fit={"kind": "scene", "size": MAP}, test={"kind": "depth", **test})
    return run(Job(scene, CAMERA, SUN, chosen, SIZE, ("texel", "shadow")), on=renderer).frame


def test_without_cuts_edges_stay_straight_and_the_cuts_bend_them(renderer, monkeypatch):
    """The cuts matter: with them switched off a long floor is visibly wrong in the map. (What is drawn between has the map drawn anew.)"""
    exact = log_frame(renderer, scenes.border_floor())
    log_frame(renderer, scenes.closed_box())
    monkeypatch.setattr(log_map, "BEND_TEXELS", 1e9)
    bent = log_frame(renderer, scenes.border_floor())
    expected = ray_depth(scenes.border_floor(), exact.plan.projections[0], MAP)
    error = [np.mean(np.abs(f.passes["shadow_depth"][0] - expected) > 1e-3) for f in (exact, bent)]
    assert error[0] < 0.1 * error[1]


@pytest.mark.parametrize("warp", ["logpsm", "log", *BENT], ids=str)
def test_a_map_drawn_in_many_turns_is_the_map_drawn_in_one(renderer, monkeypatch, warp):
    """However few slabs a draw may emit of a triangle, the same pieces arrive, with the same ids. (A new scene each, as above.)"""
    frames = []
    for most in (2, 7, 48):
        monkeypatch.setattr(log_map, "MOST_SLABS", most)
        frames.append(log_frame(renderer, scenes.border_floor(), warp, kind="triangle"))
    assert (frames[0].passes["shadow_depth"] < 1.0).mean() > 0.2
    for other in frames[:2]:
        np.testing.assert_allclose(other.passes["shadow_depth"], frames[2].passes["shadow_depth"], atol=1e-6)
        assert np.array_equal(other.passes["shadow"], frames[2].passes["shadow"])


@pytest.mark.parametrize("warp", ["logpsm", "log"])
def test_no_crack_opens_between_triangles_that_share_an_edge(renderer, warp):
    """A level floor in triangles of every size and slope: between its texels none is empty, and its depth is level to float32."""
    rng = np.random.default_rng(3)
    corners = np.array([[-15.0, -5.0], [15.0, -5.0], [15.0, 60.0], [-15.0, 60.0]])
    points = np.concatenate([corners, rng.uniform([-15.0, -5.0], [15.0, 60.0], (300, 2))])
    triangles = Delaunay(points).simplices
    scene = scenes.scene_of((np.c_[points, np.zeros(len(points))], triangles))
    sun = Light("sun", np.array([0.0, 0.0, 1.0]))
    chosen = Settings().replaced(
        warp={"kind": warp}, partition={"kind": "none"}, fit={"kind": "scene", "size": 1024}, test={"kind": "depth"}
    )
    frame = run(Job(scene, CAMERA, sun, chosen, SIZE, ("texel",)), on=renderer).frame
    depth, projection = frame.passes["shadow_depth"][0], frame.plan.projections[0]
    expected = ray_depth(scenes.scene_of(scenes.sheet(*(tuple(c) + (0.0,) for c in corners))), projection, 1024)
    inside = minimum_filter(expected, 5) == maximum_filter(expected, 5)
    covered = inside & (expected < 1.0)
    assert covered.mean() > 0.3
    assert (depth[covered] < 1.0).all()
    assert np.ptp(depth[covered]) < 1e-5
