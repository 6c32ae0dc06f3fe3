"""All that lives on the GPU between frames: pools, programs, targets. One per context, on the worker; released before the context."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from contextlib import ExitStack
from functools import partial
from typing import TypeVar

import moderngl

from ..maths.shadow.projection import ShadowPlan
from ..maths.view import Camera
from ..settings.groups import ShadowTestChoice
from .detail.drawn import CoarseCasters
from .geometry.draw_list import DrawList
from .geometry.store import GeometryStore
from .gl.allocation import allocating, freed_with
from .gl.context import GpuWorker
from .gl.gl_raw import BufferTexture, raw_gl
from .gl.programs import Programs
from .passes.edges import EdgeTarget
from .passes.gbuffer import GBuffer
from .passes.large_receivers import STEPS, LargePlanes, large_planes
from .passes.light_sums import LightSums
from .passes.panes import PaneMaps
from .passes.reach_sums import ReachSums, SurfacePlaces
from .passes.samples import Mean
from .passes.shade import ShadePass, ShadeTarget
from .passes.shadow import ShadowMaps
from .passes.sky_light import SkyLight

PLAIN = ShadowTestChoice()
_PICTURE = "a picture of this size", "choose a smaller one"
_WANTED = dict.fromkeys(("shadow", "reach shadow", "panes"), ("these shadow maps", "lower Map Size or Partitions"))

Attached = TypeVar("Attached")


class Device:
    """Keeps the last target of each kind; asking for another size frees it and makes a new one. `plan`: the last one, and of what.
    `sky`: what reaches the pixels of the picture that is being made; `coarse`: the coarser meshes that its maps may be drawn with."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        raw_gl(context)
        self.programs = Programs(context)
        self.store = GeometryStore(context)
        self.shade_pass = ShadePass(context, self.programs)
        self.plan: tuple[Hashable, ShadowPlan] | None = None
        self.sky: SkyLight | None = None
        self.coarse: CoarseCasters | None = None
        self._kept: dict[str, tuple[tuple, object]] = {}
        self._idle_target = context.renderbuffer((1, 1))
        self._idle = context.framebuffer([self._idle_target])

    def gbuffer(self, size: tuple[int, int], of: str = "pixels") -> GBuffer:
        """The camera targets of that size; one for the pixels' centres, one for their 'samples'."""
        return self._keep(f"gbuffer {of}", size, lambda: GBuffer(self.context, size))

    def shadow_maps(self, size: int, layers: int, test: ShadowTestChoice = PLAIN, roomy: bool = False) -> ShadowMaps:
        """The shadow maps of that size and count, with what the test needs beside the depth; `roomy`: or more maps, if they are there."""
        key = (size, layers, test.kind, test.depths, test.has_outlines)
        kept = self._kept.get("shadow")
        if roomy and kept is not None and kept[0][1] > layers and (size, layers, *kept[0][2:]) == key:
            return kept[1]
        return self._keep("shadow", key, lambda: ShadowMaps(self.context, size, layers, test))

    def pane_maps(self, side: int, maps: int, layers: int) -> PaneMaps:
        """The layers of what tints the light before so many shadow maps, or before more if they are there."""
        kept = self._kept.get("panes")
        if kept is not None and kept[0][1] > maps and (side, layers) == (kept[0][0], kept[0][2]):
            return kept[1]
        return self._keep("panes", (side, maps, layers), lambda: PaneMaps(self.context, side, maps, layers))

    def shade_target(self, size: tuple[int, int], data: bool, of: str = "pixels") -> ShadeTarget:
        """The picture's targets, with or without the data images; of the pixels' centres or their 'samples'."""
        return self._keep(f"shade {of} {int(data)}", size, lambda: ShadeTarget(self.context, size, data))

    def light_sums(self, size: tuple[int, int], of: str = "pixels") -> LightSums:
        """What many lights' pictures of that size are added up in; of the pixels' centres or their 'samples'."""
        return self._keep(f"sums {of}", size, lambda: LightSums(self.context, size))

    def mean(self, size: tuple[int, int]) -> Mean:
        """The picture that samples are added up in."""
        return self._keep("mean", size, lambda: Mean(self.context, size))

    def reach_maps(self, size: int, layers: int, test: ShadowTestChoice) -> ShadowMaps:
        """The maps of many lights that are there at once, beside those of a picture's own light."""
        key = (size, layers, test.kind, test.depths, test.has_outlines)
        return self._keep("reach shadow", key, lambda: ShadowMaps(self.context, size, layers, test))

    def surface_places(self, size: tuple[int, int]) -> SurfacePlaces:
        """The receivers that many lights are counted at."""
        return self._keep("places", size, lambda: SurfacePlaces(self.context, size))

    def reach_sums(self, size: tuple[int, int]) -> ReachSums:
        """The sums over many lights."""
        return self._keep("reach sums", size, lambda: ReachSums(self.context, size))

    def edge_target(self, size: tuple[int, int]) -> EdgeTarget:
        """The targets of feature edges of that size."""
        return self._keep("edges", size, lambda: EdgeTarget(self.context, size))

    def triangles(self, linked: bool = False, normals: bool = False) -> dict[str, BufferTexture]:
        """The pools as buffer textures by sampler name: positions, indices, what lies across the edges if `linked`, and `normals`."""
        store = self.store
        pools = {"u_positions": (store.positions, "r32f"), "u_indices": (store.indices, "r32ui")}
        if linked:
            pools["u_links"] = (store.linked(), "r32ui")
        if normals:
            pools["u_normals"] = (store.normals, "r32ui")
        return {
            name: self._keep(name, (pool.glo, pool.size, store.pools), partial(BufferTexture, self.context, pool, kind))
            for name, (pool, kind) in pools.items()
        }

    def large_planes(self, draw_list: DrawList, camera: Camera, plan: ShadowPlan) -> LargePlanes | None:
        """The planes of what that camera may see that float32 cannot hold, relative to the plan's origin; None where there is nothing."""
        nearest = 2.0 / float(camera.clip_from_view[1, 1]) if camera.is_orthographic else plan.nearest
        if not draw_list.longest_edge_m > STEPS * nearest:
            return None
        key = self.store.state, camera.key, nearest, plan.origin_ws.tobytes()
        made = self._keep("large planes", key, lambda: LargePlanes(self.context, *large_planes(draw_list, camera, plan.origin_ws, nearest)))
        return made if made.count else None

    def unbind(self) -> None:
        """Bind an idle framebuffer. Called before a framebuffer is released: moderngl binds the last one again when it makes another."""
        self._idle.use()

    def attached(self, kind: str, make: Callable[[], Attached]) -> Attached:
        """The thing of that kind that lives as long as the device, made on first use; it is released with the device."""
        return self._keep(kind, (), make)

    def _keep(self, kind: str, key: tuple, make: object) -> object:
        kept = self._kept.get(kind)
        if kept is None or kept[0] != key:
            if kept is not None:
                self.unbind()
                kept[1].release()
                del self._kept[kind]
            with ExitStack() as made:
                made.callback(self.unbind)  # what fails may have bound what is freed now
                with allocating(self.context, *_WANTED.get(kind, _PICTURE)):
                    thing = freed_with(made, make())
                made.pop_all()
            self._kept[kind] = (key, thing)
        return self._kept[kind][1]

    def release(self) -> None:
        """Free everything."""
        self.unbind()
        for _, thing in self._kept.values():
            thing.release()
        self._kept.clear()
        self.shade_pass.release()
        self.store.release()
        self.programs.release()
        self._idle.release()
        self._idle_target.release()


def device_of(context: moderngl.Context, worker: GpuWorker) -> Device:
    """The device of that context, made on first use and released when the worker closes."""
    if "device" not in (context.extra or {}):
        raw_gl(context)
        context.extra["device"] = Device(context)
        worker.at_close(context.extra["device"].release)
    return context.extra["device"]
