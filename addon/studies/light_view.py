"""The light's-eye view: the scene as the light sees it, each place in the colour of the shadow map that serves it, over the view frustum.

Inside the frustum a surface is coloured by its map, outside it is grey. The outlines of the maps and of the frustum are drawn on top: how
well the one fills the other is how well the texels are spent. No bpy.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..images.passes import id_colors
from ..maths.frusta import box_corners, frustum_corners
from ..maths.shadow.lookup import partition_index
from ..maths.shadow.projection import ShadowPlan
from ..maths.spaces import look_at, orthographic, perspective, transform
from ..maths.view import Camera
from ..pipeline.job import Job
from .map_outlines import frustum_sides, map_color, map_volumes, part_edges, section
from .run import run

BACKGROUND, FRUSTUM_INK = (46, 46, 50), (250, 250, 250)
FRAME_MARGIN = 1.06
NEAREST = 1e-4  # near distance of a finite light's eye, of its far distance
SIZE = (960, 720)
WIDEST_RAD = 1.3  # half the field of view of a finite light's eye


def light_camera(job: Job, plan: ShadowPlan, aspect: float) -> Camera:
    """A camera in the light that frames what the maps cover, and under a sun the view frustum as far as they reach; the view points up.

    The sun's is orthographic. A spot looks along its axis, a point light at the middle of the scene.
    """
    points = _covered(job, plan)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    light, up = job.light, job.camera.direction_ws
    if light.kind == "sun":
        view = look_at(middle + light.direction_ws, middle, up)
        p = transform(view, points)[:, :3]
        centre = 0.5 * (p.min(axis=0) + p.max(axis=0))
        half = 0.5 * FRAME_MARGIN * np.ptp(p, axis=0)
        bounds = transform(view, box_corners(job.scene.bounds_ws()))[:, 2]
        near, far = -max(bounds.max(), p[:, 2].max()) - 1.0, -min(bounds.min(), p[:, 2].min()) + 1.0
        view[:2, 3] -= centre[:2]
        return Camera(view, orthographic(max(half[1], half[0] / aspect, 1e-6), aspect, near, far), near, far, "light")
    target = light.position_ws - light.direction_ws if light.kind == "spot" else job.scene.bounds_ws().mean(axis=0)
    view = look_at(light.position_ws, target, up)
    p = transform(view, points)[:, :3]
    ahead = p[p[:, 2] < -1e-6]
    slope = np.abs(ahead[:, :2] / ahead[:, 2:]).max(axis=0) if len(ahead) else np.ones(2)
    half_rad = min(float(np.arctan(FRAME_MARGIN * max(slope[1], slope[0] / aspect))), WIDEST_RAD)
    far = 1.1 * float(np.linalg.norm(box_corners(job.scene.bounds_ws()) - light.position_ws, axis=1).max())
    return Camera(view, perspective(half_rad, aspect, NEAREST * far, far), NEAREST * far, far, "light")


def light_picture(job: Job, plan: ShadowPlan, size: tuple[int, int]) -> np.ndarray:
    """(h, w, 3) uint8: the light's view of `job`, whose shadow maps are `plan`'s. Raises as `run.run` does."""
    from ..pipeline.passes.gbuffer import seen_surface  # loads OpenGL

    eye = light_camera(job, plan, size[0] / size[1])
    shown = replace(job, camera=eye, light=None, size=size, settings=job.settings.replaced(shading={"samples": 1}), measure=False)
    passes = run(replace(shown, passes=("depth", "normal"))).frame.passes
    image = np.full((size[1], size[0], 3), BACKGROUND, np.uint8)
    seen, points = seen_surface(passes["depth"], eye, np.float64)
    clip = transform(job.camera.clip_from_world, points)
    inside = (np.abs(clip[:, :3]) <= clip[:, 3:]).all(axis=1)
    index = np.where(inside, partition_index(plan, job.camera, points), -1)
    shade = 0.35 + 0.65 * np.abs(passes["normal"][::-1][seen] @ eye.direction_ws.astype(np.float32))
    image[::-1][seen] = np.rint(id_colors(index) * shade[:, None]).astype(np.uint8)
    _draw_outlines(image, job, plan, eye)
    return image


def _covered(job: Job, plan: ShadowPlan) -> np.ndarray:
    """(P, 3) corners of what the maps cover; for a sun (or without a map in use) also of the view frustum as far as they reach."""
    corners = [segments.reshape(-1, 3) for _, segments in map_volumes(plan)]
    if job.light.kind == "sun" or not corners:
        corners.append(frustum_corners(job.camera, *_reach(job, plan)) + job.camera.eye_ws)
    return np.concatenate(corners)


def _reach(job: Job, plan: ShadowPlan) -> tuple[float, float]:
    """The view depths between which there are maps."""
    served = [p for p in plan.projections if not p.is_empty] or plan.projections
    near = max(min(p.near for p in served), job.camera.near)
    return near, max(min(max(p.far for p in served), job.camera.far), near * 1.001 if near > 0.0 else near + 1e-3)


def _draw_outlines(image: np.ndarray, job: Job, plan: ShadowPlan, eye: Camera) -> None:
    near, far = _reach(job, plan)
    for index, segments in map_volumes(plan):
        _draw(image, segments, eye, tuple(round(255 * c) for c in map_color(index)))
    for p in plan.projections:
        if not p.is_empty:
            _draw(image, part_edges(job.camera, p, max(p.near, near), min(p.far, far)), eye, FRUSTUM_INK)
    for segments in (section(job.camera, near), section(job.camera, far), frustum_sides(job.camera, near, far)):
        _draw(image, segments, eye, FRUSTUM_INK)


def _draw(image: np.ndarray, segments: np.ndarray, eye: Camera, color: tuple[int, ...]) -> None:
    """Draw (S, 2, 3) world segments, one pixel wide, those before the eye."""
    height, width = image.shape[:2]
    for a, b in transform(eye.clip_from_world, segments):
        if min(a[3], b[3]) <= 0.0:
            continue
        ends = [((v[0] / v[3] + 1.0) * width / 2.0, (1.0 - v[1] / v[3]) * height / 2.0) for v in (a, b)]
        steps = int(min(max(abs(ends[1][0] - ends[0][0]), abs(ends[1][1] - ends[0][1])), 8.0 * max(width, height))) + 2
        x, y = (np.floor(np.linspace(ends[0][k], ends[1][k], steps)).astype(int) for k in (0, 1))
        on = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        image[y[on], x[on]] = color
