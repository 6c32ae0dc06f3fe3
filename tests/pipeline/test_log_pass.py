"""LogPSM's maps on stock OpenGL against rays through their texel centres (issue 3)."""

from dataclasses import replace

import numpy as np
import pytest

from addon.maths.lookup import unproject
from addon.pipeline import log_pass
from addon.pipeline.settings import Settings
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


@pytest.mark.parametrize("warp", ["logpsm", "log"])
@pytest.mark.parametrize("make", [scenes.railing, scenes.chair, scenes.border_floor])
def test_the_map_holds_what_rays_through_its_texel_centres_meet(renderer, make, warp):
    scene = make()
    chosen = Settings().replaced(warp={"kind": warp}, partition={"kind": "none"}, fit={"kind": "scene", "size": MAP})
    frame = renderer.render(scene, CAMERA, SUN, chosen, SIZE, ("texel",))
    projection = frame.plan.projections[0]
    assert projection.log is not None
    expected = ray_depth(scene, projection, MAP)
    wrong = np.abs(frame.passes["shadow_depth"][0] - expected) > 1e-3
    assert (expected < 1.0).mean() > 0.2
    assert wrong.mean() <= 1e-3


def test_the_vertex_path_alone_bends_edges_and_the_exact_path_mends_them(renderer, monkeypatch):
    """The choice matters: with the exact path switched off a long floor is visibly wrong in the map."""
    scene = scenes.border_floor()
    chosen = Settings().replaced(warp={"kind": "logpsm"}, partition={"kind": "none"}, fit={"kind": "scene", "size": MAP})
    exact = renderer.render(scene, CAMERA, SUN, chosen, SIZE, ("texel",))
    monkeypatch.setattr(log_pass, "BEND_TEXELS", 1e9)
    bent = renderer.render(replace(scene), CAMERA, SUN, chosen, SIZE, ("texel",))
    expected = ray_depth(scene, exact.plan.projections[0], MAP)
    error = [np.mean(np.abs(f.passes["shadow_depth"][0] - expected) > 1e-3) for f in (exact, bent)]
    assert error[0] < 0.1 * error[1]
