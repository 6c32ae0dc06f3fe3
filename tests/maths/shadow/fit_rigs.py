"""Views, lights and receivers for the tests of the fit: seeded, from ordinary to hostile."""

import numpy as np

from addon.maths import spaces
from addon.maths.choices import FitChoice, PartitionChoice, WarpChoice
from addon.maths.shadow import fit, lookup
from addon.maths.view import Camera, Light

IMAGE = (320, 180)


def unit(v):
    return np.asarray(v, float) / np.linalg.norm(v)


def camera_at(eye, target, near=0.5, far=200.0, phi_deg=22.5, up=(0.0, 0.0, 1.0), orthographic=None):
    """A camera; `orthographic` is the half height of a parallel one."""
    view = spaces.look_at(eye, target, up)
    aspect = IMAGE[0] / IMAGE[1]
    if orthographic is not None:
        return Camera(view, spaces.orthographic(orthographic, aspect, near, far), near, far)
    return Camera(view, spaces.perspective(np.radians(phi_deg), aspect, near, far), near, far)


def sun_at(camera, gamma_deg, azimuth_deg=90.0, ahead=False):
    """A sun at the angle γ from the view's line: behind the viewer, or ahead; azimuth 90° is in the camera's vertical plane."""
    right, up = camera.view_from_world[0, :3], camera.view_from_world[1, :3]
    g, a = np.radians(gamma_deg), np.radians(azimuth_deg)
    sign = 1.0 if ahead else -1.0
    return Light("sun", unit(sign * np.cos(g) * camera.direction_ws + np.sin(g) * (np.cos(a) * right + np.sin(a) * up)))


def receivers_on(camera, bounds, count=3000, seed=0):
    """(P, 3) points of a bumpy ground and of posts inside `bounds`, those that the camera's frustum holds."""
    rng = np.random.default_rng(seed)
    size = bounds[1] - bounds[0]
    p = rng.random((count, 3))
    p[: count // 2, 2] *= 0.05
    p = bounds[0] + p * size
    clip = spaces.transform(camera.clip_from_world, p)
    return p[(np.abs(clip[:, :3]) <= clip[:, 3:]).all(axis=1)]


def casters_round(points, seed=0, count=40, size=2.0):
    """(I, 2, 3) boxes round some of the points."""
    rng = np.random.default_rng(seed)
    if not len(points):
        return np.zeros((0, 2, 3))
    centre = points[rng.integers(0, len(points), count)]
    half = size * rng.random((count, 3))
    return np.stack([centre - half, centre + half], axis=1)


def plan_of(
    camera,
    light,
    points,
    bounds,
    warp="lispsm-general",
    partition="none",
    kind="samples",
    casters=None,
    size=512,
    margin=1.0,
    facets=None,
    **more,
):
    """`plan_shadows` with short names."""
    warp = warp if isinstance(warp, WarpChoice) else WarpChoice(warp)
    partition = partition if isinstance(partition, PartitionChoice) else PartitionChoice(partition, **more)
    casters = casters_round(points) if casters is None else casters
    choice = FitChoice(kind, size=size, margin_texels=margin)
    return fit.plan_shadows(
        camera,
        light,
        warp,
        partition,
        choice,
        receivers_ws=points,
        scene_bounds_ws=bounds,
        caster_bounds_ws=casters,
        image_size=IMAGE,
        facets=facets,
    )


def texel_sizes(plan, light, size=512):
    """Per projection (side of a square as large as the texel at the map's middle, its extent in s, in t); NaN where empty."""
    out = np.full((len(plan.projections), 3), np.nan)
    for i, p in enumerate(plan.projections):
        if not p.is_empty:
            middle = lookup.unproject(p, np.zeros(1), np.zeros(1), np.zeros(1))
            e = lookup.texel_footprint(p, middle, light, size)[0]
            out[i] = np.sqrt(np.linalg.norm(np.cross(*e))), *np.linalg.norm(e, axis=1)
    return out
