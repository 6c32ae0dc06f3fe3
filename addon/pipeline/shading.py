"""From surfaces and shadow maps to the images of a picture: one light at pixel centres, the mean of camera samples, the sum of many lights.
Worker thread only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..maths.shadow.projection import ShadowPlan
from .device import Device
from .geometry.draw_list import DrawList
from .gl.machine import spare_bytes
from .gl.readback import read_texture
from .impostors.life import ImpostorFrame
from .job import Job
from .light_batches import alone
from .many_lights import sources_of
from .overlay import Overlay
from .passes.samples import pictures, regular_grid
from .stages import Enter, ShadedPicture, draw_surfaces, look_of, shade_once, wants_data
from .summing import shade_many


def shade(
    device: Device, job: Job, draw_list: DrawList, plan: ShadowPlan | None, impostors: ImpostorFrame | None, enter: Enter
) -> ShadedPicture:
    """The images of the picture, and its lights."""
    sources = sources_of(job)
    if sources:
        return shade_many(device, job, draw_list, plan, impostors, enter, sources)
    has_data = wants_data(job)
    samples = job.settings.shading.samples if "combined" in job.passes else 1
    data = combined = None
    overlay = Overlay(device, job, draw_list)
    if has_data or samples == 1:
        target, wanted = device.shade_target(job.size, has_data), look_of(device, job, impostors)
        if wanted is None or target.holds != wanted:
            is_picture = samples == 1 and "combined" in job.passes
            plain = job if is_picture else replace(job, settings=job.settings.replaced(test={"smoothing": 1}))
            shade_once(device, plain, job.camera, draw_list, plan, target, device.gbuffer(job.size), impostors)
            if samples == 1:
                overlay.draw(job.camera, device.gbuffer(job.size), target.textures[0])
            target.holds = wanted
        data = [read_texture(t) for t in target.textures[1:]] if has_data else None
        combined = read_texture(target.textures[0]) if samples == 1 and "combined" in job.passes else None
    if samples > 1:
        combined = _mean_of_samples(device, job, draw_list, plan, impostors, enter, overlay)
    return ShadedPicture(combined, data, overlay.coverage, alone(job.light))


def _mean_of_samples(
    device: Device,
    job: Job,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    impostors: ImpostorFrame | None,
    enter: Enter,
    overlay: Overlay,
) -> np.ndarray:
    """The combined image as the mean of several camera samples a pixel."""
    offsets = regular_grid(job.settings.shading.samples)
    shots = pictures(job.camera, job.size, offsets, device.context.info["GL_MAX_TEXTURE_SIZE"], spare_bytes(job.size, wants_data(job)))
    mean, wanted = device.mean(job.size), look_of(device, job, impostors)
    if wanted is not None and mean.target.holds == wanted:
        return read_texture(mean.target.textures[0])
    mean.clear()
    for i, (camera, side) in enumerate(shots):
        enter(0.7 + 0.25 * i / len(shots), "shade")
        size = job.size[0] * side, job.size[1] * side
        gbuffer, target = device.gbuffer(size, "samples"), device.shade_target(size, False, "samples")
        draw_surfaces(device, job, draw_list, camera, impostors, gbuffer)
        shade_once(device, job, camera, draw_list, plan, target, gbuffer, impostors, side)
        overlay.draw(camera, gbuffer, target.textures[0], side, side * side / len(offsets))
        mean.add(device.programs, target.textures[0], side, len(offsets))
    mean.target.holds = wanted
    return read_texture(mean.target.textures[0])
