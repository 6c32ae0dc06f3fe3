"""The shadow maps of many lights at infinity over the same receivers: one each, uniform. Pure numpy.

What a map is cropped to is the box of the receivers in its own light space (`fit.py`); here the receivers are few points whose hull holds
all of them, so that a plan costs the same for a thousand and for a million.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..choices import FitChoice, PartitionChoice, WarpChoice
from ..spaces import look_at, orthographic
from ..view import Camera, Light
from .fit import plan_shadows
from .projection import ShadowPlan

COLUMNS = 24
"""Cells of the longest side that receivers are counted in: their hull grows by less than one."""
UNIFORM, WHOLE = WarpChoice(kind="uniform"), PartitionChoice(kind="none")


def hull_points(points_ws: np.ndarray, columns: int = COLUMNS) -> np.ndarray:
    """(H, 3) points whose convex hull holds `points_ws` (P, 3) and is larger by less than a cell of `columns` in the longest side.

    Corners of the lowest and the highest cell of each column of a grid: what lies between them in a column is no corner of the hull.
    """
    points = np.asarray(points_ws, np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    cell = max(float((high - low).max()) / columns, 1e-9)
    place = np.minimum(((points - low) / cell).astype(np.int64), columns - 1)
    column = place[:, 0] * columns + place[:, 1]
    lowest, highest = np.full(columns * columns, columns), np.full(columns * columns, -1)
    np.minimum.at(lowest, column, place[:, 2])
    np.maximum.at(highest, column, place[:, 2])
    used = np.flatnonzero(highest >= 0)
    flat = np.stack([used // columns, used % columns], axis=-1)
    corners = [
        np.column_stack([flat + (dx, dy), height[used] + dz])
        for height, dz in ((lowest, 0), (highest, 1))
        for dx in (0, 1)
        for dy in (0, 1)
    ]
    return np.clip(low + cell * np.concatenate(corners), low, high)


def overseer(points_ws: np.ndarray) -> Camera:
    """A parallel view from above that sees all of `points_ws` (P, 3): uniform maps are the same for every view."""
    low, high = points_ws.min(axis=0), points_ws.max(axis=0)
    middle, size = 0.5 * (low + high), max(float(np.linalg.norm(high - low)), 1e-6)
    view = look_at(middle + [0.0, 0.0, size], middle)
    return Camera(view, orthographic(size, 1.0, 0.0, 2.0 * size), 0.0, 2.0 * size)


def plan_light_set(
    directions_ws: np.ndarray,
    hull_ws: np.ndarray,
    origin_ws: np.ndarray,
    fit: FitChoice,
    scene_bounds_ws: np.ndarray,
    caster_bounds_ws: np.ndarray,
) -> ShadowPlan:
    """One uniform map for each of the unit directions (N, 3), over the receivers in the hull of `hull_ws` (H, 3), counted from `origin_ws`
    (3,), which float32 holds exactly."""
    camera, asked = overseer(hull_ws), replace(fit, kind="samples")
    plans = [
        plan_shadows(
            camera,
            Light("sun", direction),
            UNIFORM,
            WHOLE,
            asked,
            receivers_ws=hull_ws,
            scene_bounds_ws=scene_bounds_ws,
            caster_bounds_ws=caster_bounds_ws,
            image_size=(fit.size, fit.size),
        )
        for direction in directions_ws
    ]
    return replace(plans[0], projections=tuple(plan.projections[0] for plan in plans), origin_ws=origin_ws, warnings=())
