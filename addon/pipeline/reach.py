"""Sums over many lights at infinity: the hours of a sun's day, light from all round. Worker thread only.

Each light has a uniform map of its own, fitted to the receivers; some maps are drawn, looked up by all receivers at once, and given up for
the next. What a surface is to many lights does not depend on how it is seen: pixels and places given by hand go the same way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..maths.choices import FitChoice
from ..maths.light_set import LightSet
from ..maths.shadow.light_set_plan import hull_points, plan_light_set
from ..maths.view import Camera
from .device import Device
from .geometry.draw_list import DrawList
from .gl.gl_raw import finish
from .gl.machine import MEBI, chosen
from .gl.readback import read_texture
from .passes.gbuffer import GBuffer, surface_points_ws
from .passes.reach_sums import ReachSums, SurfacePlaces, walks
from .passes.shadow import MAX_MAPS, draw_shadow_maps
from .reach_choice import ReachChoice

BATCH_BYTES = 192 << 20  # of maps that are drawn before they are looked up


def batch_of(choice: ReachChoice) -> int:
    """Maps that are there at once: as many as fit into `BATCH_BYTES`, or half of what the machine may use."""
    limit = chosen().memory_mib * MEBI // 2
    room = min(BATCH_BYTES, limit) if limit else BATCH_BYTES
    numbers = (3 if walks(choice.test) else 1) * (2 if choice.test.has_outlines else 1)
    return max(1, min(MAX_MAPS, room // (choice.size * choice.size * 4 * numbers)))


def add_lights(
    device: Device,
    draw_list: DrawList,
    places: SurfacePlaces,
    sums: ReachSums,
    lights: LightSet,
    choice: ReachChoice,
    origin_ws: np.ndarray,
    hull_ws: np.ndarray,
    enter: Callable[[float, str], None],
) -> None:
    """Add every light to `sums` at `places`, which count from `origin_ws` and lie in the hull of `hull_ws` (H, 3).

    `enter(fraction, stage)` is told how far it is, and may raise to end it.
    """
    scene, batch = draw_list.scene, batch_of(choice)
    bounds, casters, rows = scene.bounds_ws(), scene.caster_bounds_ws(), scene.blocking()
    for start in range(0, len(lights), batch):
        enter(start / len(lights), f"light {start + 1} of {len(lights)}")
        some = part(lights, start, start + batch)
        plan = plan_light_set(some.directions_ws, hull_ws, origin_ws, FitChoice(size=choice.size), bounds, casters)
        maps = device.reach_maps(choice.size, len(some), choice.test)
        draw_shadow_maps(device.context, device.programs, maps, draw_list, plan, choice.test, rows)
        triangles = device.triangles(linked=walks(choice.test))
        sums.add(device.programs, places, maps, draw_list, triangles, plan, some, choice.test, choice.sums)
        finish(device.context)


def part(lights: LightSet, start: int, end: int) -> LightSet:
    """The lights from `start` to before `end`."""
    return LightSet(lights.directions_ws[start:end], lights.weights[start:end], lights.brightness[start:end])


def seen_places(
    device: Device, camera: Camera, draw_list: DrawList, gbuffer: GBuffer
) -> tuple[SurfacePlaces, np.ndarray, np.ndarray] | None:
    """What a G-buffer shows as receivers, the place that they count from, points whose hull holds them; None where it shows nothing."""
    scene, depth = draw_list.scene, read_texture(gbuffer.view_depth, flip=False)
    seen = depth[depth != 0.0]
    if not len(seen):
        return None
    hull, nearest = hull_points(surface_points_ws(depth, camera)), float(seen.min())
    origin = camera.anchor_ws(nearest)
    plan = plan_light_set(np.array([[0.0, 0.0, 1.0]]), hull, origin, FitChoice(), scene.bounds_ws(), scene.caster_bounds_ws())
    large = device.large_planes(draw_list, camera, replace(plan, nearest=nearest))
    places = device.surface_places(gbuffer.size)
    places.see(device.programs, gbuffer, draw_list, device.triangles(), camera, origin, large)
    return places, origin, hull
