"""The live view: what View3D's Rendered shading shows. The picture is made on the worker; the last one stays until the next is ready.

While the view moves, a coarser picture is asked for (fewer pixels, smaller maps); when it has been still for a moment, the full one.
At most one picture is in the making per view; the newest wish replaces all older ones. Nothing here waits for the worker.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from weakref import WeakSet

import bpy
import numpy as np

from . import sources
from .errors import Cancelled, UserError
from .hud.canvas import texture_of
from .hud.legend import LiveLegend
from .job import Job, Pending
from .maths.projection import ShadowPlan
from .rendering import ENGINE

COARSE = 2  # pixels and map texels per side are divided by this while the view moves
STILL_S = 0.25
POLL_S = 0.03

_views: WeakSet[LiveView] = WeakSet()


@dataclass(frozen=True)
class Wish:
    """One picture of the live view: the job's identity and how coarse it is made."""

    key: tuple
    coarseness: int


def coarser(job: Job, factor: int) -> Job:
    """The job with pictures and maps `factor` times smaller per side, one camera sample per pixel."""
    if factor == 1:
        return job
    settings = job.settings
    size = tuple(max(1, n // factor) for n in job.size)
    return replace(job, size=size, settings=settings.replaced(fit={"size": max(settings.fit.size // factor, 64)}, shading={"samples": 1}))


class LiveView:
    """The pictures of one viewport. Lives as long as Blender's engine object; used on the main thread only."""

    def __init__(self) -> None:
        self.message = ""
        self._scene = sources.LiveScene()
        self._pending: tuple[Wish, Pending] | None = None
        self._shown: Wish | None = None
        self._image: np.ndarray | None = None
        self._texture: object | None = None
        self._shows: tuple[str, ShadowPlan | None] = ("shaded", None)  # the display and the maps of the image
        self._legend = LiveLegend()
        self._wanted: tuple | None = None
        self._moved_at = 0.0
        _views.add(self)
        _ensure_timer()

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """The scene changed: read it again (unchanged meshes are not)."""
        self._scene.mark_changed()

    def draw(self, engine: bpy.types.RenderEngine, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Ask for the picture of this very view when it is not there yet, and draw the newest one there is."""
        try:
            self._ask(self._scene.job(context, depsgraph))
        except UserError as error:
            self.message = str(error)
        engine.update_stats("", self.message)
        self._draw_texture(engine, depsgraph.scene, context.region)
        self._legend.draw_colors(context, *self._shows)

    def _ask(self, job: Job) -> None:
        """Start the next picture if none is in the making and the newest one shown is not the one wanted."""
        key = job.key
        now = time.monotonic()
        if key != self._wanted:
            is_first = self._wanted is None
            self._wanted, self._moved_at = key, 0.0 if is_first else now
        self.collect()
        if self._pending is not None:
            return
        wish = Wish(key, COARSE if now - self._moved_at < STILL_S else 1)
        if self._shown is not None and self._shown.key == key and self._shown.coarseness <= wish.coarseness:
            return
        self._pending = (wish, Pending(coarser(job, wish.coarseness)))

    def collect(self) -> bool:
        """Take over the picture in the making if it is done; True when there is a new one to show."""
        if self._pending is None or not self._pending[1].done():
            return False
        wish, pending = self._pending
        self._pending = None
        try:
            outcome = pending.result()
            self._image = outcome.frame.passes["combined"]
            self._shows = outcome.job.settings.shading.display, outcome.frame.plan
            self._shown, self._texture, self.message = wish, None, ""
        except Cancelled:
            return False
        except UserError as error:
            self._shown, self.message = Wish(wish.key, 1), str(error)
        return True

    @property
    def needs_redraw(self) -> bool:
        """True when a picture is waiting to be shown, or the coarse one shown may now be refined."""
        if self._pending is not None:
            return self._pending[1].done()
        return self._shown is not None and self._shown.coarseness > 1 and time.monotonic() - self._moved_at >= STILL_S

    def _draw_texture(self, engine: bpy.types.RenderEngine, scene: bpy.types.Scene, region: bpy.types.Region) -> None:
        import gpu  # gpu and gpu_extras are not there without a window
        from gpu_extras.presets import draw_texture_2d

        if self._image is None:
            return
        if self._texture is None:
            self._texture = texture_of(self._image)
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (0, 0), region.width, region.height)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")

    def close(self) -> None:
        """Give up the picture in the making and free the texture."""
        if self._pending is not None:
            self._pending[1].cancel()
        self._pending = self._texture = self._image = None
        self._legend.close()
        _views.discard(self)


def _tick() -> float | None:
    """Blender's timer, on the main thread: redraw the viewports whose picture is ready."""
    if not _views:
        return None
    if any(view.needs_redraw for view in list(_views)):
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D" and area.spaces.active.shading.type == "RENDERED":
                    area.tag_redraw()
    return POLL_S


def _ensure_timer() -> None:
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=POLL_S, persistent=True)


def register() -> None:
    """Nothing to do before the first viewport shows Rendered shading."""


def _leave_rendered() -> None:
    """Every viewport that shows this engine goes to Solid. Blender would go on with EEVEE, whose shaders may take a minute to compile."""
    shown = {window.screen: window.scene for window in bpy.context.window_manager.windows}
    engines = {scene.render.engine for scene in shown.values()}
    for screen in bpy.data.screens:
        if (shown[screen].render.engine == ENGINE) if screen in shown else (ENGINE in engines):
            for area in screen.areas:
                for space in area.spaces:
                    if space.type == "VIEW_3D" and space.shading.type == "RENDERED":
                        space.shading.type = "SOLID"


def unregister() -> None:
    """Close every live view, leave Rendered shading and stop the timer."""
    for view in list(_views):
        view.close()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    _leave_rendered()
