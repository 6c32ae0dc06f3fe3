"""Job → Frame. Callable from any thread; all GL happens on the worker.

The order is the method's: G-buffer → receivers → shadow projections → shadow maps → deferred shading → read-back. What the GPU still
holds from the frame before (surfaces, projections, maps) is not made again.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace

import moderngl
import numpy as np

from ..errors import Cancelled, GpuError
from ..maths.error.aliasing import aliasing_statistics
from ..maths.error.precision import Loss, precision_loss
from ..maths.shadow.projection import ShadowPlan
from .device import Device, device_of
from .frame import Frame
from .geometry.draw_list import DrawList
from .gl.allocation import check_memory
from .gl.context import GpuWorker, shared_worker
from .gl.gl_raw import finish
from .gl.machine import check_picture
from .gl.readback import read_texture
from .impostors.life import ImpostorFrame, library_of
from .job import Job
from .many_lights import sources_of
from .passes.gbuffer import surface_points_ws
from .render_passes import made_passes
from .render_passes.row import ShadedImages
from .see_through import unlike_impostors, warnings_of
from .shading import shade
from .sky import AO, ambient_occlusion, sky_light
from .stages import ShadedPicture, cast, coarse_casters, draw_seen, plan_of, shadow_maps_of, wants_data

Task = Callable[..., object]
"""What the worker can be asked: a function of a module, called with (device, job, ticket, …); `render_frame` is one."""
STAGES = ("sync", "upload", "gbuffer", "shadow", "shade", "readback")
PRECISION_PLACES = 4096


@dataclass
class Ticket:
    """What a caller and the worker share while a frame is made: how far it is, and whether to give up."""

    fraction: float = 0.0
    stage: str = "waiting"
    is_cancelled: bool = False
    timing_ms: dict[str, float | None] = field(default_factory=lambda: dict.fromkeys((*STAGES, "total")))

    def enter(self, fraction: float, stage: str) -> None:
        """Note the stage that begins; raises `Cancelled` when the caller has given up."""
        self.fraction, self.stage = fraction, stage
        if self.is_cancelled:
            raise Cancelled("Cancelled.")

    def give_up(self) -> None:
        """Have it stop at the next stage; from any thread."""
        self.is_cancelled = True


class Renderer:
    """Renders on a `GpuWorker`; holds no GL object itself (they live in the worker's `Device`)."""

    def __init__(self, worker: GpuWorker | None = None) -> None:
        self._worker = worker

    @property
    def worker(self) -> GpuWorker:
        """The worker used: its own, or the add-on's shared one."""
        return self._worker or shared_worker()

    def submit(self, job: Job, task: Task | None = None, *arguments: object) -> tuple[Future, Ticket]:
        """Queue a frame, or another task about one; set `ticket.is_cancelled` to give it up between stages."""
        ticket = Ticket()
        return self.queue(job, ticket, task, *arguments), ticket

    def queue(self, job: Job, ticket: Ticket, task: Task | None = None, *arguments: object) -> Future:
        """Queue a frame, or another task, with a ticket of the caller's own."""
        work = task or render_frame

        def checked(context: moderngl.Context) -> object:
            result = work(device_of(context, self.worker), job, ticket, *arguments)
            check_memory(context)
            return result

        return self.worker.submit(checked, ticket.give_up)


def render_frame(device: Device, job: Job, ticket: Ticket) -> Frame:
    """Make one frame on the worker thread."""
    clock = _Clock(device.context, ticket)
    check_size(device.context, job.size)
    check_picture(job.size, wants_data(job))
    scene_bounds = job.scene.bounds_ws()
    ticket.enter(0.05, "upload")
    draw_list = device.store.sync(job.scene)
    clock.lap("upload")
    ticket.enter(0.2, "gbuffer")
    impostors, choice = None, job.impostors
    if choice is not None:
        library, samples = library_of(device, choice.alone), job.settings.shading.samples
        impostors = library.update(job.scene, draw_list, job.camera, job.size, choice, samples)
    seen = draw_seen(device, job, draw_list, impostors)
    clock.lap("gbuffer")
    ticket.enter(0.4, "shadow")
    plan = plan_of(device, job, scene_bounds, seen)
    device.coarse = coarse_casters(device, job, draw_list, lambda: ticket.enter(0.4, "coarser casters")) if plan is not None else None
    if plan is not None and (wants_data(job) or not sources_of(job)):
        cast(device, job, draw_list, plan, impostors)
    clock.lap("shadow")
    device.sky = sky_light(device, job, draw_list, lambda part, stage: ticket.enter(0.4 + 0.3 * part, f"sky, {stage}"))
    ticket.enter(0.7, "shade")
    shaded = shade(device, job, draw_list, plan, impostors, ticket.enter, seen)
    clock.lap("shade")
    ticket.enter(0.95, "readback")
    frame = _frame(device, job, draw_list, plan, impostors, shaded)
    clock.lap("readback")
    clock.total()
    said = *frame.warnings, *warnings_of(seen), *unlike_impostors(job.scene, job.impostors)
    return replace(frame, timing_ms=dict(ticket.timing_ms), warnings=said)


def _frame(
    device: Device,
    job: Job,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    impostors: ImpostorFrame | None,
    shaded: ShadedPicture,
) -> Frame:
    data = shaded.data
    errors, normals, ids = data if data is not None else (None, None, None)
    ao = ambient_occlusion(device.sky, job.size) if AO in job.passes else None
    read_maps = shadow_maps_of(device, job, plan).read if plan is not None and "texel" in job.passes else None
    passes, loss = made_passes(ShadedImages(job, shaded.combined, errors, normals, ids, read_maps, shaded.edges, ao)), Loss()
    measured, warnings = None, plan.warnings if plan is not None else ()
    if job.measure and errors is not None:
        seen = errors[..., 0] >= 0.0
        measured = aliasing_statistics(errors[..., 0][seen], errors[..., 1][seen], errors[..., 2][seen])
        loss = _precision(job, plan, draw_list, data)
        measured["precision"] = loss.as_dict()
    info = device.context.info
    geometry = {"meshes": len(job.scene.meshes), "instances": len(job.scene.instances), "triangles": job.scene.triangle_count}
    if device.coarse is not None and (maps := shadow_maps_of(device, job, plan)).caster_error:
        geometry |= {"caster_triangles": maps.sent, "caster_error_texels": maps.caster_error}
    if impostors is not None:
        geometry["triangles_saved"] = impostors.triangles_saved
    return Frame(
        passes,
        plan,
        {},
        geometry,
        {"renderer": info["GL_RENDERER"], "version": info["GL_VERSION"]},
        measured,
        (*warnings, loss.warning) if loss.warning else warnings,
        impostors.reports if impostors is not None else (),
        read_texture(device.gbuffer(job.size).view_depth) if job.keeps_depth else None,
        shaded.lights,
    )


def _precision(job: Job, plan: ShadowPlan | None, draw_list: DrawList, data: list[np.ndarray]) -> Loss:
    """What float32 loses in the maps, at some thousand of the places that the picture shows."""
    if plan is None:
        return Loss()
    step = max(1, int((job.size[0] * job.size[1] / PRECISION_PLACES) ** 0.5))
    places = np.zeros(data[2].shape[:2], np.float32)
    places[::step, ::step] = np.where(data[2][::step, ::step, 1] >= 0, data[1][::step, ::step, 3], 0.0)
    places, index = places[::-1], data[2][::-1, :, 1]  # rows from the bottom up
    points = surface_points_ws(places, job.camera, np.float64)
    return precision_loss(
        plan, job.camera, job.light, points, index[places != 0.0], job.settings.fit.size, job.size, draw_list.longest_edge_m
    )


def check_size(context: moderngl.Context, size: tuple[int, int]) -> None:
    """Raise `GpuError` for a picture that the driver cannot hold."""
    limit = context.info["GL_MAX_TEXTURE_SIZE"]
    if not (1 <= size[0] <= limit and 1 <= size[1] <= limit):
        raise GpuError(
            f"A picture of {size[0]}×{size[1]} pixels is outside this driver's limits (1 to {limit} per side): choose another size."
        )


class _Clock:
    """Stage times in milliseconds, the GPU's work included (finish)."""

    def __init__(self, context: moderngl.Context, ticket: Ticket) -> None:
        self._context, self._ticket = context, ticket
        self._begin = self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        """End a stage."""
        finish(self._context)
        now = time.perf_counter()
        self._ticket.timing_ms[stage] = (now - self._last) * 1e3
        self._last = now

    def total(self) -> None:
        """End the frame."""
        self._ticket.timing_ms["total"] = (self._last - self._begin) * 1e3


_renderer: Renderer | None = None


def shared_renderer() -> Renderer:
    """The renderer on the add-on's shared worker."""
    global _renderer
    if _renderer is None:
        _renderer = Renderer()
    return _renderer
