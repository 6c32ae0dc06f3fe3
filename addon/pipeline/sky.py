"""Ambient light from the whole sky with what stands in its way, near and far: a shadow map for every direction. Worker thread only.

It does not depend on the view: what is off the picture, or behind what it shows, shades too. It is counted at the pixels' centres; camera
samples look it up (`passes/sky_light.py`). Each direction brings 1/n of the light, so that its shadow's edge may be out of place by more
than a hard shadow's: a texel covers about √n / 4 pixels (an error m of √n / 4, as `maths/error/theory.py` counts it).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..maths.light_set import all_round
from ..settings.groups import ShadowTestChoice
from ..settings.sky import SkyChoice
from .device import Device
from .geometry.draw_list import DrawList
from .gl.readback import read_texture
from .job import Job
from .passes.sky_light import SkyLight
from .reach import add_lights, seen_places
from .reach_choice import COSINES, ReachChoice

SMOOTH = ShadowTestChoice(kind="depth")  # edges out of place by a texel do not show; the exact test takes three times as long
LEAST_SIZE, MOST_SIZE = 1024, 2048  # below, thin parts far away would stop nothing
AO = "ao"


def sky_map_size(samples: int, size: tuple[int, int]) -> int:
    """Texels a side of each of so many maps for a picture of `size`: twice as many as pixels on its longer side over the fourth root of
    the number, in steps of 64."""
    wanted = 2.0 * max(size) * samples**-0.25
    return int(np.clip(64 * round(wanted / 64), LEAST_SIZE, MOST_SIZE))


def sky_wanted(job: Job) -> SkyChoice | None:
    """The sky that a picture needs: its own, or, for the pass alone, a uniform one."""
    if job.settings.sky.kind != "off":
        return job.settings.sky.quick if job.rounds == 1 else job.settings.sky
    return SkyChoice("uniform", job.settings.sky.samples) if AO in job.passes else None


def sky_light(device: Device, job: Job, draw_list: DrawList, enter: Callable[[float, str], None]) -> SkyLight | None:
    """The sky at what the G-buffer of the job's size shows; None where none is wanted or nothing seen. Kept until something changes.

    `enter(fraction, stage)` may raise to end it.
    """
    choice, gbuffer = sky_wanted(job), device.gbuffer(job.size)
    if choice is None:
        return None
    sun = job.light.direction_ws if job.light is not None and job.light.kind == "sun" else None
    lights = all_round(choice.samples, choice.luminance, sun)
    sums = device.reach_sums(job.size)
    reach = ReachChoice(sky_map_size(len(lights), job.size), SMOOTH, COSINES)
    wanted = (gbuffer.holds, lights.key, reach) if gbuffer.holds is not None else None
    if wanted is None or sums.holds is None or sums.holds[0] != wanted:
        sums.holds = None
        seen = seen_places(device, job.camera, draw_list, gbuffer)
        if seen is None:
            return None
        places, origin, hull = seen
        sums.clear()
        add_lights(device, draw_list, places, sums, lights, reach, origin, hull, enter)
        sums.holds = (wanted, origin) if wanted is not None else None
        made_from = origin
    else:
        made_from = sums.holds[1]
    places = device.surface_places(job.size)
    return SkyLight(sums.texture, places.place, places.plane, job.camera, job.size, made_from)


def ambient_occlusion(sky: SkyLight | None, size: tuple[int, int]) -> np.ndarray:
    """(h, w) the share of the light from all round, weighted by the cosine, that nothing stops; 1 where there is no surface."""
    if sky is None:
        return np.ones((size[1], size[0]), np.float32)
    sums = read_texture(sky.sums)
    return np.where(sums[..., 3] > 0.0, sums[..., 0] / np.maximum(sums[..., 3], 1e-9), np.float32(1.0))
