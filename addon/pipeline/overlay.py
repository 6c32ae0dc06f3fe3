"""What is laid over the shaded picture: caps of sections and feature edges. Worker thread only."""

from __future__ import annotations

from dataclasses import replace

import moderngl
import numpy as np

from ..maths.view import Camera
from .device import Device
from .geometry.draw_list import DrawList
from .gl.readback import read_texture
from .job import Job
from .passes.caps import draw_caps
from .passes.edges import blend_edges, draw_edges
from .passes.gbuffer import GBuffer


class Overlay:
    """Of one picture: drawn over every camera sample of it; the coverage of edges is averaged where their pass is wanted."""

    def __init__(self, device: Device, job: Job, draw_list: DrawList) -> None:
        self._device, self._job, self._draw_list = device, job, draw_list
        is_shaded = job.settings.shading.display == "shaded"
        self._has_caps = is_shaded and bool(job.settings.section.planes)
        self._has_edges = is_shaded and job.settings.edges.is_on
        self._is_asked = "edges" in job.passes
        self._coverage: np.ndarray | None = None

    def draw(self, camera: Camera, gbuffer: GBuffer, picture: moderngl.Texture, side: int = 1, share: float = 1.0) -> None:
        """Lay caps and edges of what `gbuffer` shows over `picture`, which has side² of its pixels, a `share` of the samples, in one."""
        device, settings = self._device, self._job.settings
        if self._has_caps:
            draw_caps(device.context, device.programs, gbuffer, self._draw_list, picture, settings.section, side)
        if not (self._has_edges or self._is_asked):
            return
        target, triangles = device.edge_target(gbuffer.size), device.triangles(linked=True)
        edges = replace(settings.edges, width=settings.edges.width or 1.0)
        draw_edges(device.context, device.programs, target, gbuffer, self._draw_list, triangles, camera, edges, side)
        if self._has_edges:
            blend_edges(device.context, device.programs, target, picture, edges)
        if self._is_asked:
            drawn = read_texture(target.coverage)
            height, width = drawn.shape
            drawn = share * drawn.reshape(height // side, side, width // side, side).mean(axis=(1, 3))
            self._coverage = drawn if self._coverage is None else self._coverage + drawn

    @property
    def coverage(self) -> np.ndarray | None:
        """(h, w) how much edges cover of each pixel, averaged over the camera samples; None where nobody asks."""
        return None if self._coverage is None else self._coverage.astype(np.float32)
