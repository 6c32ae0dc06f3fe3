"""The stages of a picture, a function each: surfaces, shadow plan, shadow maps, shading. What the GPU still holds is not made again.
Worker thread only."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import NamedTuple

import numpy as np

from ..maths.shadow.fit import plan_shadows
from ..maths.shadow.projection import ShadowPlan
from ..maths.shadow.suited_cut import Facets
from ..maths.view import Camera
from ..scene.looks import HIDDEN, NO_SHADOW
from ..settings.shadowing import SHADOW_TESTS
from .detail.drawn import CoarseCasters
from .detail.making import CoarseMaker
from .device import Device
from .frame import LightReport
from .geometry.draw_list import DrawList
from .geometry.octahedral import from_octahedral
from .gl.readback import read_texture
from .impostors.life import ImpostorFrame
from .impostors.shadows import casters_of
from .job import Job
from .passes.gbuffer import GBuffer, draw_gbuffer
from .passes.light_sums import LightSums
from .passes.shade import ShadeTarget
from .passes.shadow import ShadowMaps, draw_shadow_maps
from .render_passes import DATA_PASSES
from .see_through import Seen, layers_before, panes_of, shown_through

FACETS = 3000
"""Visible places at most by which the cut 'auto' chooses."""
Enter = Callable[[float, str], None]
"""Told how far the picture is; raises where it is given up."""


class ShadedPicture(NamedTuple):
    """What shading gives back: the combined image (averaged over the camera samples), the data images at pixel centres, how much edges
    cover, each None where nobody wants it; and what to say of the lights."""

    combined: np.ndarray | None
    data: list[np.ndarray] | None
    edges: np.ndarray | None
    lights: tuple[LightReport, ...]


def draw_surfaces(
    device: Device,
    job: Job,
    draw_list: DrawList,
    camera: Camera,
    impostors: ImpostorFrame | None,
    gbuffer: GBuffer,
    without: np.ndarray | None = None,
) -> None:
    """What the camera sees, but for the rows `without` (I,): geometry, and impostors instead of the objects they stand for. Without
    impostors it may be there already."""
    rows = both(_shown(job, impostors), None if without is None else ~without)
    wanted = (device.store.state, camera.key, None if rows is None else rows.tobytes()) if impostors is None else None
    if wanted is not None and gbuffer.holds == wanted:
        return
    draw_gbuffer(device.context, device.programs, gbuffer, draw_list, camera, rows)
    for drawn in impostors.drawn if impostors is not None else ():
        drawn.draw(device, gbuffer, camera)
    gbuffer.holds = wanted


def _shown(job: Job, impostors: ImpostorFrame | None) -> np.ndarray | None:
    """(I,) bool: the rows that the camera sees as triangles; None is all."""
    return both(impostors.geometry_rows if impostors is not None else job.shown, job.scene.instances.without(HIDDEN))


def draw_seen(device: Device, job: Job, draw_list: DrawList, impostors: ImpostorFrame | None) -> Seen:
    """Draw what pixels' centres show: the surfaces that data images are of, and what the picture is of, where that is something else."""
    surfaces, thin = device.gbuffer(job.size), job.scene.thin
    draw_surfaces(device, job, draw_list, job.camera, impostors, surfaces, thin)
    rows = shown_through(job)
    if rows is None:
        return Seen(job.camera, surfaces)
    if not np.array_equal(rows, thin):
        surfaces = device.gbuffer(job.size, "whole")
        draw_surfaces(device, job, draw_list, job.camera, impostors, surfaces, rows)
    return Seen(job.camera, surfaces, layers_before(device, surfaces, draw_list, job.camera, both(_shown(job, impostors), rows)))


def draw_sample(
    device: Device, job: Job, draw_list: DrawList, camera: Camera, impostors: ImpostorFrame | None, size: tuple[int, int]
) -> Seen:
    """Draw what one of the camera's samples shows."""
    surfaces, rows = device.gbuffer(size, "samples"), shown_through(job)
    without = job.scene.thin if rows is None else rows
    draw_surfaces(device, job, draw_list, camera, impostors, surfaces, without)
    if rows is None:
        return Seen(camera, surfaces)
    return Seen(camera, surfaces, layers_before(device, surfaces, draw_list, camera, both(_shown(job, impostors), rows), "samples"))


def both(rows: np.ndarray | None, others: np.ndarray | None) -> np.ndarray | None:
    """(I,) bool: the instance rows that are in both; None is all."""
    return others if rows is None else rows if others is None else rows & others


def plan_of(device: Device, job: Job, scene_bounds: np.ndarray, seen: Seen) -> ShadowPlan | None:
    """The shadow projections for what is really `seen`; those of the frame before where nothing they depend on has changed."""
    if job.light is None or not job.light.casts:
        return None
    s, surfaces = job.settings, device.gbuffer(job.size).holds
    wanted = (surfaces, job.size, job.light.shadow_key, s.warp, s.partition, s.fit) if surfaces is not None else None
    if wanted is None or device.plan is None or device.plan[0] != wanted:
        device.plan = wanted, _fitted(job, scene_bounds, seen)
    return device.plan[1]


def _fitted(job: Job, scene_bounds: np.ndarray, seen: Seen) -> ShadowPlan:
    s, receivers, facets = job.settings, None, None
    if s.fit.kind == "samples":
        receivers = seen.receivers_ws
        facets = _facets(seen) if s.partition.cut == "auto" and s.partition.z_count > 1 else None
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
        facets=facets,
    )


def _facets(seen: Seen) -> Facets:
    """Some of the receivers, evenly picked, and the normals that are seen there."""
    step = max(-(-len(seen.whole_ws) // FACETS), 1)
    folded = read_texture(seen.whole.normal, flip=False).reshape(-1, 2)
    normals = from_octahedral(folded[np.flatnonzero(seen.depth)[::step]].astype(np.float64))
    return seen.whole_ws[::step].astype(np.float64), normals


def shadow_maps_of(device: Device, job: Job, plan: ShadowPlan, in_turn: bool = False) -> ShadowMaps:
    """`in_turn`: those that lights take turns in, of which there may be more than this one needs."""
    return device.shadow_maps(job.settings.fit.size, len(plan.projections), job.settings.test, roomy=in_turn)


def cast(device: Device, job: Job, draw_list: DrawList, plan: ShadowPlan, impostors: ImpostorFrame | None, in_turn: bool = False) -> None:
    """Fill the shadow maps: triangles, and impostors where they are chosen as casters. Without impostors they may be full already."""
    maps, choice = shadow_maps_of(device, job, plan, in_turn), job.impostors
    coarse, test = device.coarse, job.settings.test
    detail = coarse and (coarse.holds, test.caster_error)
    clear = job.scene.shines_through
    state = device.store.state, None if clear is None else clear.tobytes()
    wanted = (device.plan[0], *state, test.id_per_material, detail) if impostors is None else None
    if wanted is not None and maps.holds == wanted:
        return
    casters = None
    if impostors is not None and choice.settings.casters == "impostor":
        casters = casters_of(device).update(job.scene, draw_list, job.light, maps, plan, choice, impostors)
    rows = both(casters.rows if casters is not None and casters.textures else None, job.scene.instances.without(NO_SHADOW))
    rows = both(rows, None if clear is None else ~clear)
    draw_shadow_maps(device.context, device.programs, maps, draw_list, plan, test, rows, coarse, job.light.kind == "sun")
    if casters is not None:
        casters.draw(device, maps, plan)
    maps.holds = wanted


def coarse_casters(device: Device, job: Job, draw_list: DrawList, check: Callable[[], None]) -> CoarseCasters | None:
    """The coarser meshes that maps may be drawn with: a picture waits until they are made, `check()` being called now and then, the live
    view does without them till then."""
    if not job.settings.test.has_coarse_casters(job.is_live) or job.settings.section.planes:
        return None
    maker = device.attached("caster maker", CoarseMaker)
    levels = maker.levels(job.scene) if job.is_live else maker.wait(job.scene, check)
    if not levels:
        return None
    casters = device.attached("coarse casters", lambda: CoarseCasters(device.context))
    return casters if casters.update(job.scene, draw_list, levels, (device.store.state, maker.version)) else None


def shade_once(
    device: Device,
    job: Job,
    camera: Camera,
    draw_list: DrawList,
    plan: ShadowPlan | None,
    target: ShadeTarget | LightSums,
    gbuffer: GBuffer,
    impostors: ImpostorFrame | None,
    side: int = 1,
    part: float | None = None,
    is_layer: bool = False,
) -> None:
    """Shade into a target, add a part of the picture to sums, or lay a layer of what is see-through over a target."""
    maps = shadow_maps_of(device, job, plan, in_turn=part is not None) if plan is not None else None
    holds_impostors = impostors is not None and bool(impostors.drawn)
    walks = holds_impostors or (maps is not None and SHADOW_TESTS[job.settings.test.kind].walks_surfaces)
    triangles = device.triangles(linked=walks, normals=holds_impostors)
    large = device.large_planes(draw_list, job.camera, plan) if plan is not None else None
    panes, sky = panes_of(device, job, draw_list, plan), device.sky if job.settings.sky.kind != "off" else None
    inputs = job.light, plan, job.settings, large, holds_impostors, side, part, sky, panes, is_layer
    device.shade_pass.draw(target, gbuffer, maps, draw_list, triangles, camera, *inputs)


def wants_data(job: Job) -> bool:
    """Whether images at pixel centres are made beside the picture."""
    return job.measure or any(name in DATA_PASSES for name in job.passes)


def look_of(device: Device, job: Job, impostors: ImpostorFrame | None) -> Hashable:
    """What a shaded picture of the job's size depends on; None where that cannot be said, impostors having a life of
    their own, or where edges are read as they are drawn."""
    if impostors is not None or "edges" in job.passes:
        return None
    store, shown = device.store, None if job.shown is None else job.shown.tobytes()
    lights = tuple(one.key for one in (job.light, *job.others) if one is not None)
    return store.state, store.colors, job.camera.key, shown, lights, job.settings
