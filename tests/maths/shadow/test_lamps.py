"""The warp of finite lights: the least mean error of a brute search, never above the uniform map's, four maps never above one's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.maths.choices import FitChoice, PartitionChoice, WarpChoice
from addon.maths.error.measure import pixel_gradients
from addon.maths.shadow import fit, lookup
from addon.maths.shadow.crop import Receivers
from addon.maths.shadow.lamps import aimed, share_of
from addon.maths.view import Light
from tests.maths.shadow.fit_rigs import IMAGE, camera_at, casters_round, plan_of, receivers_on, unit

BOUNDS = np.array([[-20.0, -20.0, 0.0], [20.0, 20.0, 6.0]])
KINDS = ("lispsm-general", "lispsm", "psm", "tsm", "lloyd", "logpsm")


def _view(seed):
    """A camera over the ground and what it sees there."""
    rng = np.random.default_rng(seed)
    camera = camera_at(rng.uniform([-16, -30, 1.5], [16, -18, 8]), rng.uniform([-8, 0, 0], [8, 10, 2]))
    return camera, receivers_on(camera, BOUNDS, 6000, seed), rng


def _lamp(rng, kind, camera, near_the_camera):
    """A lamp over the scene, or beside the camera; a spot looks at the scene."""
    position = rng.uniform([-18, -18, 3], [18, 18, 12]) if not near_the_camera else camera.eye_ws + rng.uniform(-2.0, 2.0, 3) + [0, 0, 2]
    return Light(kind, unit(position - [0, 0, 1]) if kind == "spot" else None, position, cone_rad=rng.uniform(0.4, 1.2))


def _texels_px(camera, light, plan, points, size):
    """(Q,) mean of the two sides of a texel over a pixel's, on planes that face the eye, at the points that the light reaches."""
    if light.kind == "spot":
        points = points[lookup.towards_light(light, points) @ light.direction_ws > np.cos(light.cone_rad)]
    index = lookup.partition_index(plan, camera, points)
    out = np.full(len(points), np.nan)
    for i, p in enumerate(plan.projections):
        own = index == i
        if own.any():
            sides = np.linalg.norm(lookup.texel_footprint(p, points[own], light, size), axis=-1)
            out[own] = sides.mean(axis=-1) * np.linalg.norm(pixel_gradients(camera, points[own], IMAGE)[1], axis=-1)
    assert np.isfinite(out).all()
    return out


@pytest.mark.parametrize("light_kind", ["spot", "point"])
@given(seed=st.integers(0, 100_000), warp=st.sampled_from(KINDS), near_the_camera=st.booleans())
@settings(max_examples=20)
def test_a_warped_lamp_has_no_larger_texels_than_a_uniform_one(light_kind, seed, warp, near_the_camera):
    camera, points, rng = _view(seed)
    light = _lamp(rng, light_kind, camera, near_the_camera)
    none, warped = (_texels_px(camera, light, plan_of(camera, light, points, BOUNDS, w), points, 512) for w in ("uniform", warp))
    if len(none):
        assert warped.mean() <= 1.02 * none.mean()


@given(seed=st.integers(0, 100_000), near_the_camera=st.booleans())
@settings(max_examples=20)
def test_four_maps_of_a_spot_have_no_larger_texels_than_one_of_as_many(seed, near_the_camera):
    camera, points, rng = _view(seed)
    light = _lamp(rng, "spot", camera, near_the_camera)
    one = _texels_px(camera, light, plan_of(camera, light, points, BOUNDS, size=1024), points, 1024)
    four = _texels_px(camera, light, plan_of(camera, light, points, BOUNDS, partition="z-adaptive", size=512), points, 512)
    if len(one):
        assert four.mean() <= 1.03 * one.mean()


def test_a_warp_pays_where_a_lamp_hangs_over_a_floor_seen_aslant():
    camera = camera_at((0.0, -19.0, 1.7), (0.0, 10.0, 0.0))
    x, y = np.meshgrid(np.linspace(-0.99, 0.99, 80), np.linspace(-0.99, -0.1, 60))
    ray = np.stack([x.ravel(), y.ravel(), np.ones(x.size), np.ones(x.size)], axis=-1) @ np.linalg.inv(camera.clip_from_world).T
    ray = ray[:, :3] / ray[:, 3:] - camera.eye_ws
    points = camera.eye_ws - ray * (camera.eye_ws[2] / ray[:, 2:])
    points = points[(np.abs(points) <= 20.0).all(axis=1)]
    for kind, position in (("spot", (0.0, 0.0, 12.0)), ("point", (5.0, 5.0, 6.0))):
        light = Light(kind, unit([0.0, 0.0, 1.0]) if kind == "spot" else None, np.array(position), cone_rad=1.1)
        none, warped = (_texels_px(camera, light, plan_of(camera, light, points, BOUNDS, w), points, 512) for w in ("uniform", "lispsm"))
        assert warped.mean() < 0.7 * none.mean()


def _brute(space, receivers, angle, strengths, apexes):
    """The least mean of (m_x + m_z) N over many maps, each from the definition: differences of (S, T) at every receiver."""
    x, _, z = receivers.rows
    half = receivers.radius * (1.0 + x * x + z * z) ** 0.25
    u, v = x * np.cos(angle) - z * np.sin(angle), z * np.cos(angle) + x * np.sin(angle)
    middle, reach, least = 0.5 * (u.max() + u.min()), 0.5 * np.ptp(u), np.inf

    def placed(a, b, kappa, apex):
        w = 1.0 + kappa * (b - v.min())
        return np.stack([(a - apex) / w, (b - v.min()) / w], axis=-1)

    for kappa in np.expm1(strengths) / np.ptp(v):
        for apex in middle + reach * apexes:
            own = placed(u, v, kappa, apex)
            moved = [(placed(u + a, v + b, kappa, apex) - own) / 1e-6 for a, b in ((1e-6, 0.0), (0.0, 1e-6))]
            texel = np.linalg.inv(np.stack(moved, axis=-1) / np.ptp(own, axis=0)[:, None])  # columns: its sides in the light's picture, × N
            least = min(least, float((np.linalg.norm(texel, axis=1).sum(axis=-1) / (2.0 * half)).mean()))
    return least


@pytest.mark.parametrize("seed", range(4))
def test_the_balanced_warp_is_the_best_of_a_brute_search(seed):
    camera, points, rng = _view(seed)
    light = _lamp(rng, "spot", camera, seed % 2 == 1)
    view = fit.view_to_fit(camera, WarpChoice(), FitChoice("samples"), points, BOUNDS, casters_round(points), IMAGE)
    (_, space), *_ = fit._spaces(view, light, PartitionChoice("none"), BOUNDS)
    rows, depths = fit._light_rows(view, space)
    receivers = Receivers(rows.astype(np.float64), depths * view.pixel * rows[1])
    aim = aimed(space, receivers, 1.0)
    angle = float(np.arctan2(aim.space.from_eye[2] @ space.from_eye[0], aim.space.from_eye[2] @ space.from_eye[2]))
    brute = _brute(space, receivers, angle, np.linspace(0.0, 6.0, 31), np.linspace(-3.0, 3.0, 13))
    assert sum(aim.error) <= 1.03 * brute
    uniform = _brute(space, receivers, angle, np.zeros(1), np.zeros(1))
    assert sum(aim.error) <= uniform * (1.0 + 1e-3)


def test_strengths_keep_the_methods_order_and_uniform_is_none():
    uniform, lispsm, tsm, psm = (share_of(WarpChoice(kind), 1.0, 50.0, 0.4) for kind in ("uniform", "lispsm-general", "tsm", "psm"))
    assert uniform == 0.0 and lispsm == pytest.approx(1.0) and lispsm < tsm <= psm
    assert share_of(WarpChoice(eta=-1.0 + 1e-9), 1.0, 50.0, 0.4) < 1e-6 < share_of(WarpChoice(eta=-0.5), 1.0, 50.0, 0.4) < 1.0


def test_what_lies_outside_a_spots_cone_takes_no_texels():
    camera, points, _ = _view(5)
    light = Light("spot", unit([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 15.0]), cone_rad=0.5)
    inside = points[lookup.towards_light(light, points) @ light.direction_ws > np.cos(light.cone_rad)]
    whole, lit = (plan_of(camera, light, p, BOUNDS, casters=casters_round(points)).projections[0] for p in (points, inside))
    assert np.allclose(
        whole.clip_from_world / whole.clip_from_world[3, 3], lit.clip_from_world / lit.clip_from_world[3, 3], rtol=1e-3, atol=1e-3
    )
