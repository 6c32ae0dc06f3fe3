"""From surfaces and shadow maps to the images of a picture: one light at pixel centres, the mean of camera samples, the sum of many lights.
Worker thread only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..maths.shadow.projection import ShadowPlan
from ..maths.view import Camera
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
from .passes.shade import ShadeTarget
from .see_through import Seen
from .stages import Enter, ShadedPicture, draw_sample, look_of, shade_once, wants_data
from .summing import shade_many


def shade(
    device: Device, job: Job, draw_list: DrawList, plan: ShadowPlan | None, impostors: ImpostorFrame | None, enter: Enter, seen: Seen
) -> ShadedPicture:
    """The images of the picture, and its lights."""
    sources = sources_of(job)
    if sources:
        return shade_many(device, job, draw_list, plan, impostors, enter, sources, seen)
    has_data = wants_data(job)
    samples = job.settings.shading.samples if "combined" in job.passes else 1
    data = combined = None
    overlay = Overlay(device, job, draw_list)
    if has_data or samples == 1:
        target, wanted = device.shade_target(job.size, has_data), look_of(device, job, impostors)
        surfaces = device.gbuffer(job.size)
        picture = target if seen.whole is surfaces else device.shade_target(job.size, False)
        if wanted is None or target.holds != wanted or picture.holds != wanted:
            is_picture = samples == 1 and "combined" in job.passes
            plain = job if is_picture else replace(job, settings=job.settings.replaced(test={"smoothing": 1}))
            if has_data or picture is target:
                shade_once(device, plain, job.camera, draw_list, plan, target, surfaces, impostors)
            if samples == 1:
                if picture is not target:
                    shade_once(device, job, job.camera, draw_list, plan, picture, seen.whole, impostors)
                overlay.draw(job.camera, seen.whole, picture.textures[0])
                _lay_over(device, job, job.camera, draw_list, plan, picture, seen, overlay)
            target.holds = picture.holds = wanted
        data = [read_texture(t) for t in target.textures[1:]] if has_data else None
        combined = read_texture(picture.textures[0]) if samples == 1 and "combined" in job.passes else None
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
        seen, target = draw_sample(device, job, draw_list, camera, impostors, size), device.shade_target(size, False, "samples")
        shade_once(device, job, camera, draw_list, plan, target, seen.whole, impostors, side)
        overlay.draw(camera, seen.whole, target.textures[0], side, side * side / len(offsets))
        _lay_over(device, job, camera, draw_list, plan, target, seen, overlay, side, side * side / len(offsets))
        mean.add(device.programs, target.textures[0], side, len(offsets))
    mean.target.holds = wanted
    return read_texture(mean.target.textures[0])


def _lay_over(
    device: Device,
    job: Job,
    camera: Camera,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    target: ShadeTarget,
    seen: Seen,
    overlay: Overlay,
    side: int = 1,
    share: float = 1.0,
) -> None:
    """Lay what is see-through over the picture in `target`, the farthest first, each layer with its edges."""
    for layer in reversed(seen.layers):
        shade_once(device, job, camera, draw_list, plan, target, layer, None, side, is_layer=True)
        overlay.draw(camera, layer, target.textures[0], side, share)
