"""What the worker can be asked about many lights: their sums at places given by hand, and at what the camera sees. Worker thread only."""

from __future__ import annotations

import numpy as np

from ..maths.light_set import LightSet
from ..maths.shadow.light_set_plan import hull_points
from ..scene.looks import HIDDEN
from .device import Device
from .gl.machine import check_picture
from .gl.readback import read_texture
from .job import Job
from .passes.gbuffer import draw_gbuffer
from .reach import add_lights, seen_places
from .reach_choice import ReachChoice
from .renderer import Ticket, check_size
from .stages import both

ROW = 1024  # places given by hand in a row of their texture


def sums_at_places(
    device: Device, job: Job, ticket: Ticket, points_ws: np.ndarray, normals_ws: np.ndarray, lights: LightSet, choice: ReachChoice
) -> np.ndarray:
    """(P, 4) float32 sums at places (P, 3) on surfaces of the job's scene with unit normals (P, 3)."""
    ticket.enter(0.0, "upload")
    if not len(points_ws) or not len(lights):
        return np.zeros((len(points_ws), 4), np.float32)
    size = min(ROW, len(points_ws)), -(-len(points_ws) // ROW)
    check_size(device.context, size)
    draw_list, hull = device.store.sync(job.scene), hull_points(points_ws)
    origin = hull.mean(axis=0).astype(np.float32).astype(np.float64)
    places, sums = device.surface_places(size), device.reach_sums(size)
    places.take(points_ws, normals_ws, origin)
    sums.clear()
    add_lights(device, draw_list, places, sums, lights, choice, origin, hull, ticket.enter)
    ticket.enter(1.0, "readback")
    return read_texture(sums.texture, flip=False).reshape(-1, 4)[: len(points_ws)]


def sums_of_pixels(device: Device, job: Job, ticket: Ticket, lights: LightSet, choice: ReachChoice) -> np.ndarray:
    """(h, w, 4) float32 sums at what the job's camera sees at pixel centres, 0 where it sees nothing; impostors are drawn as geometry."""
    ticket.enter(0.0, "upload")
    check_size(device.context, job.size)
    check_picture(job.size, True)
    draw_list, gbuffer = device.store.sync(job.scene), device.gbuffer(job.size)
    draw_gbuffer(device.context, device.programs, gbuffer, draw_list, job.camera, both(job.shown, job.scene.instances.without(HIDDEN)))
    seen = seen_places(device, job.camera, draw_list, gbuffer)
    if seen is None or not len(lights):
        return np.zeros((job.size[1], job.size[0], 4), np.float32)
    places, origin, hull = seen
    sums = device.reach_sums(job.size)
    sums.clear()
    add_lights(device, draw_list, places, sums, lights, choice, origin, hull, ticket.enter)
    ticket.enter(1.0, "readback")
    return read_texture(sums.texture)
