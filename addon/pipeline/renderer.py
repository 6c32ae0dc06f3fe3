"""Job → Frame. Callable from any thread; all GL happens on the worker.

The order is the method's: G-buffer → receivers → shadow projections → shadow maps → deferred shading → read-back. What the GPU still
holds from the frame before (surfaces, projections, maps) is not made again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace

import moderngl
import numpy as np

from ..errors import Cancelled, GpuError
from ..maths.error.aliasing import aliasing_statistics
from ..maths.error.precision import Loss, precision_loss
from ..maths.shadow.fit import plan_shadows
from ..maths.shadow.projection import ShadowPlan
from ..maths.view import Camera
from ..scene.looks import HIDDEN, NO_SHADOW
from ..settings.shadowing import SHADOW_TESTS
from .device import Device, device_of
from .frame import Frame
from .geometry.draw_list import DrawList
from .gl.context import GpuWorker, shared_worker
from .gl.gl_raw import finish
from .gl.machine import check_picture, spare_bytes
from .gl.readback import read_texture
from .impostors.life import ImpostorFrame, library_of
from .impostors.shadows import casters_of
from .job import Job
from .overlay import Overlay
from .passes.gbuffer import GBuffer, draw_gbuffer, surface_points_ws
from .passes.samples import pictures, regular_grid
from .passes.shade import ShadeTarget
from .passes.shadow import ShadowMaps, draw_shadow_maps
from .render_passes import DATA_PASSES, made_passes
from .render_passes.row import ShadedImages

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
        return self.worker.submit(lambda context: work(device_of(context, self.worker), job, ticket, *arguments), ticket.give_up)


def render_frame(device: Device, job: Job, ticket: Ticket) -> Frame:
    """Make one frame on the worker thread."""
    clock = _Clock(device.context, ticket)
    check_size(device.context, job.size)
    check_picture(job.size, _wants_data(job))
    scene_bounds = job.scene.bounds_ws()
    ticket.enter(0.05, "upload")
    draw_list = device.store.sync(job.scene)
    clock.lap("upload")
    ticket.enter(0.2, "gbuffer")
    impostors, choice = None, job.impostors
    if choice is not None:
        library, samples = library_of(device, choice.alone), job.settings.shading.samples
        impostors = library.update(job.scene, draw_list, job.camera, job.size, choice, samples)
    _draw_surfaces(device, job, draw_list, job.camera, impostors, device.gbuffer(job.size))
    clock.lap("gbuffer")
    ticket.enter(0.4, "shadow")
    plan = _plan(device, job, scene_bounds)
    if plan is not None:
        _cast(device, job, draw_list, plan, impostors)
    clock.lap("shadow")
    ticket.enter(0.7, "shade")
    combined, data, edges = _shade(device, job, draw_list, plan, impostors, ticket)
    clock.lap("shade")
    ticket.enter(0.95, "readback")
    frame = _frame(device, job, draw_list, plan, impostors, combined, data, edges)
    clock.lap("readback")
    clock.total()
    return replace(frame, timing_ms=dict(ticket.timing_ms))


def _draw_surfaces(
    device: Device, job: Job, draw_list: DrawList, camera: Camera, impostors: ImpostorFrame | None, gbuffer: GBuffer
) -> None:
    """What the camera sees: geometry, and impostors instead of the objects they stand for. Without impostors it may be there already."""
    rows = both(impostors.geometry_rows if impostors is not None else job.shown, job.scene.instances.without(HIDDEN))
    wanted = (device.store.state, camera.key, None if rows is None else rows.tobytes()) if impostors is None else None
    if wanted is not None and gbuffer.holds == wanted:
        return
    draw_gbuffer(device.context, device.programs, gbuffer, draw_list, camera, rows)
    for drawn in impostors.drawn if impostors is not None else ():
        drawn.draw(device, gbuffer, camera)
    gbuffer.holds = wanted


def both(rows: np.ndarray | None, others: np.ndarray | None) -> np.ndarray | None:
    """(I,) bool: the instance rows that are in both; None is all."""
    return others if rows is None else rows if others is None else rows & others


def _plan(device: Device, job: Job, scene_bounds: np.ndarray) -> ShadowPlan | None:
    """The shadow projections for what this camera really sees; those of the frame before where nothing they depend on has changed."""
    if job.light is None or not job.light.casts:
        return None
    s, surfaces = job.settings, device.gbuffer(job.size).holds
    wanted = (surfaces, job.size, job.light.key, s.warp, s.partition, s.fit) if surfaces is not None else None
    if wanted is None or device.plan is None or device.plan[0] != wanted:
        device.plan = wanted, _fitted(device, job, scene_bounds)
    return device.plan[1]


def _fitted(device: Device, job: Job, scene_bounds: np.ndarray) -> ShadowPlan:
    s, receivers = job.settings, None
    if s.fit.kind == "samples":
        receivers = surface_points_ws(read_texture(device.gbuffer(job.size).view_depth, flip=False), job.camera)
    return plan_shadows(
        job.camera,
        job.light,
        s.warp,
        s.partition,
        s.fit,
        receivers_ws=receivers,
        scene_bounds_ws=scene_bounds,
        caster_bounds_ws=job.scene.caster_bounds_ws(),
        image_size=job.size,
    )


def _shadow_maps(device: Device, job: Job, plan: ShadowPlan) -> ShadowMaps:
    return device.shadow_maps(job.settings.fit.size, len(plan.projections), job.settings.test)


def _cast(device: Device, job: Job, draw_list: DrawList, plan: ShadowPlan, impostors: ImpostorFrame | None) -> None:
    """Fill the shadow maps: triangles, and impostors where they are chosen as casters. Without impostors they may be full already."""
    maps, choice = _shadow_maps(device, job, plan), job.impostors
    wanted = (device.plan[0], job.settings.test.id_per_material) if impostors is None else None
    if wanted is not None and maps.holds == wanted:
        return
    casters = None
    if impostors is not None and choice.settings.casters == "impostor":
        casters = casters_of(device).update(job.scene, draw_list, job.light, maps, plan, choice, impostors)
    rows = both(casters.rows if casters is not None and casters.textures else None, job.scene.instances.without(NO_SHADOW))
    draw_shadow_maps(device.context, device.programs, maps, draw_list, plan, job.settings.test, rows)
    if casters is not None:
        casters.draw(device, maps, plan)
    maps.holds = wanted


def _wants_data(job: Job) -> bool:
    return job.measure or any(name in DATA_PASSES for name in job.passes)


def _shade(
    device: Device, job: Job, draw_list: DrawList, plan: ShadowPlan | None, impostors: ImpostorFrame | None, ticket: Ticket
) -> tuple[np.ndarray | None, list[np.ndarray] | None, np.ndarray | None]:
    """The combined image (averaged over the camera samples), the data images at pixel centres, and the edges (None: nobody wants them)."""
    wants_data = _wants_data(job)
    samples = job.settings.shading.samples if "combined" in job.passes else 1
    data = combined = None
    overlay = Overlay(device, job, draw_list)
    if wants_data or samples == 1:
        target, wanted = device.shade_target(job.size, wants_data), _look(device, job, impostors)
        if wanted is None or target.holds != wanted:
            _shade_once(device, job, job.camera, draw_list, plan, target, device.gbuffer(job.size), impostors)
            if samples == 1:
                overlay.draw(job.camera, device.gbuffer(job.size), target.textures[0])
            target.holds = wanted
        data = [read_texture(t) for t in target.textures[1:]] if wants_data else None
        combined = read_texture(target.textures[0]) if samples == 1 and "combined" in job.passes else None
    if samples > 1:
        combined = _mean_of_samples(device, job, draw_list, plan, impostors, ticket, overlay)
    return combined, data, overlay.coverage


def _mean_of_samples(
    device: Device,
    job: Job,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    impostors: ImpostorFrame | None,
    ticket: Ticket,
    overlay: Overlay,
) -> np.ndarray:
    """The combined image as the mean of several camera samples a pixel."""
    offsets = regular_grid(job.settings.shading.samples)
    shots = pictures(job.camera, job.size, offsets, device.context.info["GL_MAX_TEXTURE_SIZE"], spare_bytes(job.size, _wants_data(job)))
    mean, wanted = device.mean(job.size), _look(device, job, impostors)
    if wanted is not None and mean.target.holds == wanted:
        return read_texture(mean.target.textures[0])
    mean.clear()
    for i, (camera, side) in enumerate(shots):
        ticket.enter(0.7 + 0.25 * i / len(shots), "shade")
        size = job.size[0] * side, job.size[1] * side
        gbuffer, target = device.gbuffer(size, "samples"), device.shade_target(size, False, "samples")
        _draw_surfaces(device, job, draw_list, camera, impostors, gbuffer)
        _shade_once(device, job, camera, draw_list, plan, target, gbuffer, impostors, side)
        overlay.draw(camera, gbuffer, target.textures[0], side, side * side / len(offsets))
        mean.add(device.programs, target.textures[0], side, len(offsets))
    mean.target.holds = wanted
    return read_texture(mean.target.textures[0])


def _look(device: Device, job: Job, impostors: ImpostorFrame | None) -> Hashable:
    """What a shaded picture of the job's size depends on; None where that cannot be said, impostors having a life of
    their own, or where edges are read as they are drawn."""
    if impostors is not None or "edges" in job.passes:
        return None
    store, shown = device.store, None if job.shown is None else job.shown.tobytes()
    return store.state, store.colors, job.camera.key, shown, None if job.light is None else job.light.key, job.settings


def _shade_once(
    device: Device,
    job: Job,
    camera: Camera,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    target: ShadeTarget,
    gbuffer: GBuffer,
    impostors: ImpostorFrame | None,
    side: int = 1,
) -> None:
    maps = _shadow_maps(device, job, plan) if plan is not None else None
    holds_impostors = impostors is not None and bool(impostors.drawn)
    walks = holds_impostors or (maps is not None and SHADOW_TESTS[job.settings.test.kind].walks_surfaces)
    triangles = device.triangles(linked=walks, normals=holds_impostors)
    large = device.large_planes(draw_list, job.camera, plan) if plan is not None else None
    device.shade_pass.draw(target, gbuffer, maps, draw_list, triangles, camera, job.light, plan, job.settings, large, holds_impostors, side)


def _frame(
    device: Device,
    job: Job,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    impostors: ImpostorFrame | None,
    combined: np.ndarray | None,
    data: list[np.ndarray] | None,
    edges: np.ndarray | None,
) -> Frame:
    errors, normals, ids = data if data is not None else (None, None, None)
    read_maps = _shadow_maps(device, job, plan).read if plan is not None else None
    passes, loss = made_passes(ShadedImages(job, combined, errors, normals, ids, read_maps, edges)), Loss()
    measured, warnings = None, plan.warnings if plan is not None else ()
    if job.measure and errors is not None:
        seen = errors[..., 0] >= 0.0
        measured = aliasing_statistics(errors[..., 0][seen], errors[..., 1][seen], errors[..., 2][seen])
        loss = _precision(job, plan, draw_list, data)
        measured["precision"] = loss.as_dict()
    info = device.context.info
    geometry = {"meshes": len(job.scene.meshes), "instances": len(job.scene.instances), "triangles": job.scene.triangle_count}
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
