"""The images of a picture that many hard lights add up to: several lights, and lights with a size. Worker thread only.

The surfaces are drawn once; every light draws its maps once and shades all views of it: the pixels' centres, where data passes are asked
for, and the camera's samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..maths.shadow.projection import ShadowPlan
from ..maths.view import Camera, LightSource
from ..settings.groups import DISPLAYS, ShadingWorld
from .device import Device
from .geometry.draw_list import DrawList
from .gl.gl_raw import finish
from .gl.machine import check_layers, spare_bytes
from .gl.readback import read_texture
from .impostors.life import ImpostorFrame
from .job import Job
from .light_batches import LightBatches, probe_size, unmeasured
from .many_lights import HardLight, SummedView, add_up, begin_or_go_on, rounds_of
from .overlay import Overlay
from .passes.light_sums import BYTES_A_PIXEL
from .passes.samples import BYTES_A_SAMPLE, pictures, regular_grid
from .passes.shade import ShadeTarget
from .see_through import Seen
from .stages import Enter, ShadedPicture, cast, draw_sample, draw_surfaces, look_of, plan_of, shade_once, wants_data


def shade_many(
    device: Device,
    job: Job,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    impostors: ImpostorFrame | None,
    enter: Enter,
    sources: Sequence[LightSource],
    seen: Seen,
) -> ShadedPicture:
    """As `shading.shade`. The data images are those of the main light, but for the shadow, which is of all."""
    notes = LightBatches(sources, rounds_of(job, sources), None) if job.measure and not job.is_live else None
    summing = Summing(device, job, draw_list, impostors, sources, Overlay(device, job, draw_list), enter, notes, seen)
    summing.watch()
    has_data, is_shown = wants_data(job), "combined" in job.passes
    data = summing.data_images(plan) if has_data else None
    centre = at_surfaces = summing.view_of(seen, job.camera)
    if seen.whole is not device.gbuffer(job.size):
        at_surfaces = SummedView(job.camera, device.gbuffer(job.size), device.light_sums(job.size, "surfaces"))
    if not is_shown or job.settings.shading.samples == 1:
        picture = device.shade_target(job.size, False)
        summing.add(
            [centre] if at_surfaces is centre or not has_data else [centre, at_surfaces], look_of(device, summing.countless, impostors)
        )
        if is_shown:
            summing.resolve(centre, picture)
    else:
        picture = summing.mean_of_samples([at_surfaces] if has_data else [])
    summing.leave(plan)
    if data is not None:
        arriving = at_surfaces.sums.shares()
        data[0][..., 3] = np.where(np.isnan(arriving), data[0][..., 3], arriving)
    lights = notes.reports() if notes is not None else unmeasured(sources, rounds_of(job, sources))
    return ShadedPicture(read_texture(picture.textures[0]) if is_shown else None, data, summing.overlay.coverage, lights)


@dataclass(frozen=True, eq=False)
class Summing:
    """One picture being added up."""

    device: Device
    job: Job
    draw_list: DrawList
    impostors: ImpostorFrame | None
    sources: Sequence[LightSource]
    overlay: Overlay
    enter: Enter
    notes: LightBatches | None
    seen: Seen

    def watch(self) -> None:
        """Where it is measured and something is soft, see how far the samples differ, in a small picture of the view."""
        if self.notes is None or not any(source.is_soft for source in self.sources):
            return
        size, device = probe_size(self.job.size), self.device
        gbuffer = device.gbuffer(size, "probe")
        draw_surfaces(device, self.job, self.draw_list, self.job.camera, self.impostors, gbuffer)
        self.notes.probe = SummedView(self.job.camera, gbuffer, device.light_sums(size, "probe"))

    @property
    def countless(self) -> Job:
        """The job whatever its number of light samples: what is added up of one is added up of the other."""
        lights = replace(self.job.settings.lights, samples=min(self.job.settings.lights.samples, 1))
        return replace(self.job, settings=replace(self.job.settings, lights=lights))

    def data_images(self, plan: ShadowPlan | None) -> list[np.ndarray]:
        """Errors, normals and numbers at pixel centres, of the main light."""
        device, job = self.device, replace(self.job, settings=self.job.settings.replaced(test={"smoothing": 1}))
        lit = job.scene if job.light is None else job.scene.lit_by(job.light)
        target, draw_list = device.shade_target(job.size, True), device.store.sync(lit)
        if plan is not None and lit is not job.scene:
            cast(device, replace(job, scene=lit), draw_list, plan, self.impostors)
        shade_once(device, job, job.camera, draw_list, plan, target, device.gbuffer(job.size), self.impostors)
        device.store.sync(job.scene)
        return [read_texture(texture) for texture in target.textures[1:]]

    def add(self, views: Sequence[SummedView], holds: object, done: float = 0.0, share: float = 1.0) -> None:
        """Bring the sums of the views to the job's rounds; they hold `holds` then, and may do so already with fewer rounds."""
        views = [one for view in views for one in view.all]
        begin_or_go_on(views, holds if self.notes is None else None, self.job, self.sources)
        add_up(self.job, views, self.sources, self._add_light, lambda part: self.enter(0.7 + 0.25 * (done + share * part), "shade"))

    def _add_light(self, lit: Job, views: Sequence[SummedView], step: HardLight) -> None:
        device, notes = self.device, self.notes
        if notes is not None:
            notes.begin(step.source)
        draw_list, plan = device.store.sync(lit.scene), plan_of(device, lit, lit.scene.bounds_ws(), self.seen)
        if plan is not None:
            cast(device, lit, draw_list, plan, self.impostors, in_turn=True)
        for view in [*views, notes.probe] if notes is not None and notes.probe is not None else views:
            shade_once(device, lit, view.camera, draw_list, plan, view.sums, view.gbuffer, self.impostors, view.side, step.part)
        if notes is not None:
            finish(device.context)
            notes.end(step.part)

    def mean_of_samples(self, beside: list[SummedView]) -> ShadeTarget:
        """The mean of several camera samples a pixel; the first pictures of them are added up together with the views `beside`."""
        device, job, size = self.device, self.job, self.job.size
        offsets, look = regular_grid(job.settings.shading.samples), look_of(device, self.countless, self.impostors)
        spare = spare_bytes(size, wants_data(job)) * BYTES_A_SAMPLE // (BYTES_A_SAMPLE + BYTES_A_PIXEL)
        shots = pictures(job.camera, size, offsets, device.context.info["GL_MAX_TEXTURE_SIZE"], spare)
        mean = device.mean(size)
        mean.clear()
        for i, (camera, side) in enumerate(shots):
            draw_list = device.store.sync(job.scene)
            view, target = self._view(camera, side, draw_list), device.shade_target((size[0] * side, size[1] * side), False, "samples")
            self.add([*beside, view] if i == 0 else [view], look if len(shots) == 1 else None, i / len(shots), 1.0 / len(shots))
            self.resolve(view, target, side * side / len(offsets))
            mean.add(device.programs, target.textures[0], side, len(offsets))
        return mean.target

    def _view(self, camera: Camera, side: int, draw_list: DrawList) -> SummedView:
        size = self.job.size[0] * side, self.job.size[1] * side
        return self.view_of(draw_sample(self.device, self.job, draw_list, camera, self.impostors, size), camera, side, "samples")

    def view_of(self, seen: Seen, camera: Camera, side: int = 1, of: str = "pixels") -> SummedView:
        """The sums of what is seen, and of its layers."""
        size, sums = seen.whole.size, self.device.light_sums
        check_layers(size, len(seen.layers), BYTES_A_PIXEL)
        layers = tuple(SummedView(camera, layer, sums(size, f"{of}, layer {i}"), side) for i, layer in enumerate(seen.layers))
        return SummedView(camera, seen.whole, sums(size, of), side, layers)

    def resolve(self, view: SummedView, target: ShadeTarget, share: float = 1.0) -> None:
        """Make the picture of a view's sums, a `share` of the camera's samples, with what is laid over it."""
        shading = self.job.settings.shading.under(ShadingWorld())
        target.holds = None
        view.sums.resolve(self.device.programs, target.framebuffer, shading.background, DISPLAYS.index(shading.display))
        self.overlay.draw(view.camera, view.gbuffer, target.textures[0], view.side, share)
        for layer in reversed(view.layers):
            self.device.shade_pass.lay_sums_over(target, layer.gbuffer, layer.sums, self.device.store.sync(self.job.scene))
            self.overlay.draw(view.camera, layer.gbuffer, target.textures[0], view.side, share)

    def leave(self, plan: ShadowPlan | None) -> None:
        """The scene as the main light sees it again, and its maps where somebody will read them."""
        draw_list = self.device.store.sync(self.job.scene)
        if plan is not None and "texel" in self.job.passes:
            cast(self.device, self.job, draw_list, plan_of(self.device, self.job, self.job.scene.bounds_ws(), self.seen), self.impostors)
