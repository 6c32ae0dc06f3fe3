"""The live view: what View3D's Rendered shading shows. The picture is made on the worker; the last one stays until the next is ready.

While the view moves, a coarser picture is asked for (fewer pixels, smaller maps); when it has been still for a moment, one sample for
every pixel, then all that the settings say, and at last its numbers, for the Quality panel. Until a picture of the view as it is now is
there, the last one is shown in its place in space (`reprojection.py`), so that it stays with Blender's grid and outlines. At most one
picture is in the making per view; the newest wish replaces all older ones. Nothing here waits for the worker.

A shaded picture is drawn by the engine and goes through the scene's view transform. A picture of data (shadow, error, maps) must not be
changed by it, since its legend's colours mean numbers: unless the view transform leaves colours alone, it is drawn after the scene and
Blender's overlays, which it covers. Blender offers no way to draw there beneath them.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from weakref import WeakSet

import bpy
import numpy as np

from ..errors import Cancelled, UserError
from ..maths.shadow.projection import ShadowPlan
from ..pipeline.frame import Frame
from ..pipeline.job import Job
from ..studies.error_graph import GRAPHED
from ..studies.pending import Pending
from ..studies.run import Outcome, libraries_ready, submit
from . import session
from .live_scene import LiveScene
from .render_wish import ENGINE
from .reprojection import DrawnPicture
from .view_border import only_in, shown_part

COARSER_BY = 2  # pixels and map texels per side are divided by this while the view moves
COARSE, ONE_SAMPLE, FULL, MEASURED = 3, 2, 1, 0
"""How coarse a picture is: fewer pixels; all pixels, a camera sample each; as the settings say; that, and what its numbers are."""
STILL_S = 0.25
BIG = 200_000  # triangles from which on also the first picture is a coarse one
POLL_S = 0.03

_views: WeakSet[LiveView] = WeakSet()
log = logging.getLogger(__name__)
_handlers: list[object] = []


@dataclass(frozen=True)
class Wish:
    """One picture of the live view: the job's identity and how coarse it is made."""

    key: tuple
    coarseness: int


def coarser(job: Job, coarseness: int) -> Job:
    """The job as coarse as that: with pictures and maps smaller per side, with one camera sample per pixel, few of the sky and hard
    shadows, as it is, or measured."""
    if coarseness == MEASURED:
        return replace(job, measure=True, passes=tuple(dict.fromkeys((*job.passes, *GRAPHED))))
    if coarseness == FULL:
        return job
    settings = replace(job.settings.replaced(shading={"samples": 1}, lights={"samples": 0}), sky=job.settings.sky.quick)
    if coarseness == ONE_SAMPLE:
        return replace(job, settings=settings)
    size = tuple(max(1, n // COARSER_BY) for n in job.size)
    return replace(job, size=size, settings=settings.replaced(fit={"size": max(settings.fit.size // COARSER_BY, 64)}))


class LiveView:
    """The pictures of one viewport. Lives as long as Blender's engine object; used on the main thread only."""

    def __init__(self) -> None:
        self.message = ""
        self._scene = LiveScene()
        self._pending: tuple[Wish, Pending[Outcome]] | None = None
        self._shown: Wish | None = None
        self._image: np.ndarray | None = None
        self._drawn: DrawnPicture | None = None
        self._taken_from: tuple | None = None  # the view that the image is of, and the view as it is now
        self._camera: tuple | None = None
        self._outcome: Outcome | None = None
        self._measured: Outcome | None = None  # to be told of
        self._is_drawn_late = False
        self._shows: tuple[str, ShadowPlan | None] = ("shaded", None)  # the display and the maps of the image
        self.region = 0  # the pointer of the region it was drawn in last
        self._is_waiting = False  # for the libraries
        self._wants_more, self._repeats = False, 0  # impostors wait to be captured by another picture of this view
        self._wanted: tuple | None = None
        self._moved_at = 0.0
        _views.add(self)
        _ensure_timer()

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """The scene changed: read it again (unchanged meshes are not)."""
        self._scene.mark_changed()

    def draw(self, engine: bpy.types.RenderEngine, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Ask for the picture of this very view when it is not there yet, and draw the newest one there is."""
        self._is_waiting = not libraries_ready()
        if not self._is_waiting:
            self._look(context, depsgraph)
        engine.update_stats("", self.message)
        self._take_place(context.region.as_pointer())
        self._is_drawn_late = self._shows[0] != "shaded" and not leaves_colours(depsgraph.scene)
        if not self._is_drawn_late:
            size = context.region.width, context.region.height
            with only_in(shown_part(context.space_data, context.region_data, depsgraph.scene, size)):
                self._draw_picture(context.region_data)

    def _take_place(self, region: int) -> None:
        """This view is what the region shows. Another one there is of an engine object that Blender has dropped, but Python not yet."""
        self.region = region
        for other in list(_views):
            if other is not self and other.region == region:
                other.close()

    def _look(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Ask for the picture of this view. Where there can be none (an emptied scene), nothing is shown but the reason."""
        try:
            self._ask(self._scene.job(context, depsgraph))
            self._tell(context)
        except Exception as error:
            if self._pending is not None:
                self._pending[1].cancel()
            self._pending = self._wanted = None
            self._blank(_words(error))

    def _blank(self, message: str) -> None:
        """Show no picture: that of another scene or of other settings would be taken for this one's."""
        self.message, self._shown, self._wants_more = message, None, False
        self._image = self._drawn = self._outcome = self._measured = None
        self._shows = ("shaded", None)
        session.clear_impostors()

    def _ask(self, job: Job | None) -> None:
        """Start the next picture if none is in the making and the newest one shown is not the one wanted.

        A full one in the making that is no longer wanted is given up. Without a job (the scene is being read) nothing is asked for.
        """
        self.collect()
        if job is None:
            return
        key, self._camera = job.key, (job.camera.key, job.scene.origin_ws.tobytes())
        now = time.monotonic()
        if key != self._wanted:
            starts_full = self._wanted is None and job.scene.triangle_count < BIG
            self._wanted, self._moved_at = key, 0.0 if starts_full else now
        if self._pending is not None:
            wish, pending = self._pending
            if wish.coarseness <= ONE_SAMPLE and wish.key != key:
                pending.cancel()
            return
        wish = Wish(key, COARSE if now - self._moved_at < STILL_S else self._finer(job))
        if self._shown is not None and self._shown.key == key and self._shown.coarseness <= wish.coarseness and not self._wants_more:
            return
        self._pending = (wish, submit(coarser(job, wish.coarseness)))

    def _finer(self, job: Job) -> int:
        """How coarse the next picture of a view is that stands still: one step finer than what is shown of it.

        With impostors there are no numbers: each picture may capture them anew.
        """
        if self._shown is None or self._shown.key != job.key or self._shown.coarseness > ONE_SAMPLE:
            return ONE_SAMPLE if job.settings.shading.samples > 1 or job.settings.lights.samples > 0 else FULL
        if self._shown.coarseness > FULL or self._wants_more or job.impostors is not None:
            return FULL
        return MEASURED

    def _tell(self, context: bpy.types.Context) -> None:
        """Have the Quality panel list the numbers of the finished picture."""
        if self._measured is None:
            return
        session.remember(self._measured, context.scene)
        self._measured = None
        for region in context.area.regions:
            if region.type == "UI":
                region.tag_redraw()

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
            self._count_repeats(wish, outcome.frame)
            self._shown, self._drawn, self.message = wish, None, ""
            self._outcome, self._measured = outcome, outcome if wish.coarseness == MEASURED else None
            self._taken_from = outcome.job.camera.key, outcome.job.scene.origin_ws.tobytes()
            session.remember_impostors(outcome)
        except Cancelled:
            return False
        except Exception as error:
            self._fail(wish, _words(error))
        return True

    def _fail(self, wish: Wish, message: str) -> None:
        """Do not ask for this picture again. A coarse one of the same view stays."""
        if self._shown is None or self._shown.key != wish.key:
            self._blank(message)
        self._shown, self.message, self._wants_more = Wish(wish.key, MEASURED), message, False

    def _count_repeats(self, wish: Wish, frame: Frame) -> None:
        """Whether the view needs another picture, because it has impostors that wait; at most one for each."""
        self._repeats = self._repeats + 1 if self._shown == wish else 0
        self._wants_more = wish.coarseness == FULL and any(r.waits for r in frame.impostors) and self._repeats < len(frame.impostors)

    @property
    def needs_redraw(self) -> bool:
        """True when a picture is waiting to be shown, or the coarse one shown may now be refined."""
        if self._is_waiting or self._scene.is_read or self._scene.is_unfinished or self._scene.is_newly_staged:
            return not self._is_waiting or libraries_ready()
        if self._pending is not None:
            return self._pending[1].done()
        if self._wants_more:
            return True
        last = FULL if self._outcome is None or self._outcome.job.impostors is not None else MEASURED
        return self._shown is not None and self._shown.coarseness > last and time.monotonic() - self._moved_at >= STILL_S

    @property
    def shows(self) -> tuple[str, ShadowPlan | None]:
        """The display (settings.DISPLAYS) of the picture shown, and the shadow maps it was made with."""
        return self._shows

    def draw_late(self) -> None:
        """Draw a picture of data over what Blender has drawn so far, its colours as they are."""
        import gpu

        if not self._is_drawn_late:
            return
        gpu.state.depth_test_set("NONE")
        self._draw_picture(bpy.context.region_data)

    def _draw_picture(self, rv3d: bpy.types.RegionView3D) -> None:
        """The picture over the whole region; one of another view where it lies in space."""
        if self._image is None:
            return
        if self._drawn is None:
            self._drawn = DrawnPicture(self._image)
        if self._taken_from == self._camera or self._outcome.frame.view_depth is None:
            self._drawn.draw_flat()
        else:
            self._drawn.draw_in_space(self._outcome, np.array(rv3d.perspective_matrix, np.float64))

    def close(self) -> None:
        """Give up the picture in the making and free the texture."""
        if self._pending is not None:
            self._pending[1].cancel()
        self._pending = self._drawn = self._image = self._outcome = self._measured = None
        _views.discard(self)


def _words(error: Exception) -> str:
    """What the viewport says of it. A defect's traceback goes to the console: raised in a draw call it would come with every redraw."""
    if isinstance(error, UserError):
        log.info("live view: %s", error)
        return str(error)
    log.error("live view", exc_info=error)
    return f"The picture failed ({type(error).__name__}: {error}): please report this."


def live_view_in(region: bpy.types.Region) -> LiveView | None:
    """The live view that was drawn in this region last; None when there is none."""
    pointer = region.as_pointer()
    return next((view for view in list(_views) if view.region == pointer), None)


def leaves_colours(scene: bpy.types.Scene) -> bool:
    """True when the scene's colour management shows linear sRGB colours as they are."""
    view = scene.view_settings
    changes = view.use_curve_mapping or getattr(view, "use_white_balance", False) or view.exposure != 0.0 or view.gamma != 1.0
    return view.view_transform == "Standard" and view.look == "None" and not changes


def _draw_late() -> None:
    """Blender calls this for every 3D viewport, after the scene."""
    context = bpy.context
    view = live_view_in(context.region) if is_live(context) else None
    if view is not None:
        view.draw_late()


def is_live(context: bpy.types.Context) -> bool:
    """True while the viewport that is being drawn shows this engine's pictures."""
    return context.space_data.shading.type == "RENDERED" and context.engine == ENGINE


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
    """Where there are windows, be called after the scene is drawn."""
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw_late, (), "WINDOW", "POST_VIEW"))


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
    """Close every live view, leave Rendered shading, stop the timer and the drawing."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    for view in list(_views):
        view.close()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    _leave_rendered()
