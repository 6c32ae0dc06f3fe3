"""Which lights of a scene light the picture: by what reaches the surfaces that the camera sees. No bpy, no GL."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..maths.view import Camera, Light

FAINTEST = 0.05
"""Irradiance, mean of the channels in W/m², below which a light hardly lights a surface: that of a sun of this strength."""
LEAST_SHARE = 0.02
"""Of the rays through the picture that a lamp must reach."""
RAYS = (16, 12)
MOST_BOXES = 4096
UNSEEN = 0.002
"""Irradiance, mean of the channels in W/m², that a white surface shows as less than a sixth of the smallest step of an 8-bit picture."""
SOFT_SUN_RAD, SOFT_RADIUS_M = 0.01, 0.11
"""Half angle and radius up to which nobody wishes soft shadows: those of new lights."""


def strength(light: Light) -> float:
    """Sum of the colour's channels: what 'the strongest' compares."""
    return sum(light.color)


def best_light(lights: Sequence[Light], camera: Camera, boxes_ws: np.ndarray) -> Light | None:
    """The strongest sun that is not faint, else the lamp that lights most of what is seen, else the strongest sun that shines at all.

    `boxes_ws` (I, 2, 3) bounds of what stands in the scene. None: no light reaches what is seen.
    """
    suns = [light for light in lights if light.kind == "sun" and strength(light) > 0.0]
    bright = [light for light in suns if strength(light) / 3.0 >= FAINTEST]
    if bright:
        return max(bright, key=strength)
    lamps = [light for light in lights if light.kind != "sun" and strength(light) > 0.0]
    if lamps:
        eyes, directions, ends, is_open = seen_places(camera, boxes_ws)
        found = {light: irradiance(light, eyes, directions, ends, is_open) for light in lamps}
        reaching = [light for light in lamps if (found[light] >= FAINTEST).mean() >= LEAST_SHARE]
        if reaching:
            return max(reaching, key=lambda light: float(np.minimum(found[light], 1.0).mean()))
    return max(suns, key=strength, default=None)


def lighting(lights: Sequence[Light], boxes_ws: np.ndarray) -> tuple[int, ...]:
    """Which of the lights can be seen anywhere: all but those that give less than `UNSEEN` at the nearest place of what stands in the scene
    (`boxes_ws` (I, 2, 3)), however it is turned. The strongest there come first."""
    nearest = {i: _nearest(light, boxes_ws) for i, light in enumerate(lights)}
    return tuple(sorted((i for i, found in nearest.items() if found >= UNSEEN), key=lambda i: -nearest[i]))


def _nearest(light: Light, boxes_ws: np.ndarray) -> float:
    """The most irradiance that a light gives within the boxes: a sun its own, a lamp at the nearest place of any of its parts."""
    mean = strength(light) / 3.0
    if light.kind == "sun" or not len(boxes_ws):
        return mean
    reach = light.radius + (0.0 if light.half_axes_ws is None else float(np.linalg.norm(light.half_axes_ws, axis=1).sum()))
    gaps = np.maximum(np.maximum(boxes_ws[:, 0] - light.position_ws, light.position_ws - boxes_ws[:, 1]), 0.0)
    away = max(float(np.linalg.norm(gaps, axis=1).min()) - reach, 1e-3)
    return mean / away**2


def is_notably_soft(light: Light) -> bool:
    """Whether somebody has made a light softer than new ones are."""
    return light.half_axes_ws is not None or light.half_angle_rad > SOFT_SUN_RAD or light.radius > SOFT_RADIUS_M


def seen_places(camera: Camera, boxes_ws: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rays over the picture: origins (R, 3), unit directions (R, 3), metres (R,) to the first box that the eye stands outside, else to the
    far side of one it stands in, where a surface may lie anywhere on the way (R,) bool; inf where there is none."""
    x, y = (2.0 * (np.arange(n) + 0.5) / n - 1.0 for n in RAYS)
    ndc = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    world_from_clip = np.linalg.inv(camera.clip_from_world)
    middle = ndc @ world_from_clip[:, :2].T + world_from_clip[:, 3]
    near, far = middle - world_from_clip[:, 2], middle + world_from_clip[:, 2]
    origins = near[:, :3] / near[:, 3:]
    directions = far[:, :3] / far[:, 3:] - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    if len(boxes_ws) > MOST_BOXES:
        boxes_ws = boxes_ws[np.argsort(-np.ptp(boxes_ws, axis=1).max(axis=1), kind="stable")[:MOST_BOXES]]
    enter, leave = np.full((2, len(origins)), np.inf)
    safe = np.where(np.abs(directions) < 1e-12, 1e-12, directions)
    for origin, direction, i in zip(origins, safe, range(len(origins)), strict=True):
        a, b = (boxes_ws[:, 0] - origin) / direction, (boxes_ws[:, 1] - origin) / direction
        first, last = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
        hit = (last >= first) & (last > 0.0)
        outside = hit & (first > 0.0)
        enter[i] = first[outside].min(initial=np.inf)
        leave[i] = last[hit & ~outside].max(initial=-np.inf) if (hit & ~outside).any() else np.inf
    is_open = np.isinf(enter) & np.isfinite(leave)
    return origins, directions, np.where(is_open, leave, enter), is_open


def irradiance(light: Light, origins: np.ndarray, directions: np.ndarray, ends: np.ndarray, is_open: np.ndarray) -> np.ndarray:
    """(R,) mean of the channels that a lamp gives a surface turned to it at the ends of the rays, on open ones where it comes nearest."""
    there = np.isfinite(ends)
    towards = light.position_ws - origins
    along = np.einsum("ij,ij->i", towards, directions)
    distance = np.where(is_open, np.clip(along, 0.0, np.where(there, ends, 0.0)), np.where(there, ends, 0.0))
    away = light.position_ws - (origins + directions * distance[:, None])
    squared = np.maximum(np.einsum("ij,ij->i", away, away), 1e-6)
    lit = there & light.lights_towards(away / np.sqrt(squared)[:, None])
    return np.where(lit, strength(light) / 3.0 / squared, 0.0)
