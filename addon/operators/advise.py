"""`cad_shadow.advise`: search the best combination for this view or animation; `cad_shadow.apply_advice` writes it into the settings."""

from __future__ import annotations

import time
from collections.abc import Generator
from dataclasses import replace

import bpy

from .. import session, sources
from ..advice import Advice, Goal, Shot, Step, advice_report, advise
from ..advice.goal import MOST_FRAMES, picked_frames
from ..errors import Cancelled, UserError
from ..properties import store
from ..redraw import redraw
from ..snapshot import camera_from_object
from .background import NeedsMeshes
from .ticking import Ticking

WORK_S = 0.1
MEBI = 2**20
GOALS = (
    ("TEXELS", "Least Error", "The least error for a number of texels, shared by all shadow maps"),
    ("ERROR", "Fewest Texels", "The fewest texels with which 95 % of the pixels keep below an error"),
)


class CAD_SHADOW_OT_advise(Ticking, NeedsMeshes, bpy.types.Operator):
    """Try warps, partitions, fits and map sizes on this view, measure them, and propose the best; Esc cancels"""

    bl_idname = "cad_shadow.advise"
    bl_label = "Advise"
    bl_options = {"REGISTER"}

    goal: bpy.props.EnumProperty(name="Find", items=GOALS)
    texels: bpy.props.FloatProperty(
        name="Texels (Mi)", description="Texels of all shadow maps together, in 1024 × 1024", default=4.0, min=0.001, soft_max=64.0
    )
    error: bpy.props.FloatProperty(
        name="Error m",
        description="Picture pixels per shadow-map texel that 95 % of the pixels keep below",
        default=1.0,
        min=0.001,
        soft_max=4.0,
    )
    use_animation: bpy.props.BoolProperty(
        name="Whole Animation", description=f"Look at {MOST_FRAMES} frames from the scene's first to its last, through its camera"
    )
    seconds: bpy.props.FloatProperty(
        name="Seconds", description="Decide after this time at the latest", default=60.0, min=1.0, soft_max=600.0
    )

    every_s = 0.02

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the goal first."""
        return context.window_manager.invoke_props_dialog(self) if context.window else self.execute(context)

    def draw(self, _context: bpy.types.Context) -> None:
        """The dialog: only the number that the goal needs."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "goal")
        layout.prop(self, "texels" if self.goal == "TEXELS" else "error")
        layout.prop(self, "use_animation")
        layout.prop(self, "seconds")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Search: bit by bit on a timer when there is a window, else at once."""
        self._search = self._steps(context)
        if context.window is None or bpy.app.background:
            while (done := self._work(context, float("inf"))) is None:
                pass
            return done
        return self.begin(context)

    def tick(self, context: bpy.types.Context) -> set[str] | None:
        """Search a little."""
        return self._work(context, WORK_S)

    def give_up(self, _context: bpy.types.Context) -> None:
        """Stop the search: the scene's frame is put back."""
        self._search.close()

    def _work(self, context: bpy.types.Context, seconds: float) -> set[str] | None:
        """Steps of the search for about so long; the operator's result when it is over, else None."""
        end = time.monotonic() + seconds
        try:
            while time.monotonic() < end:
                step = next(self._search)
                context.window_manager.progress_update(100 * step.fraction)
        except StopIteration as stop:
            return self._finish(context, stop.value)
        except Cancelled:
            return {"CANCELLED"}
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return None

    def _steps(self, context: bpy.types.Context) -> Generator[Step, None, Advice]:
        """Read the frames, then search."""
        goal = Goal(texels=round(self.texels * MEBI)) if self.goal == "TEXELS" else Goal(error=self.error)
        scene = context.scene
        if not self.use_animation:
            yield Step(0.0, "reading the scene")
            return (yield from advise([Shot(sources.job_for_view(context))], goal, self.seconds))
        kept, shots = scene.frame_current, []
        try:
            for frame in picked_frames(scene.frame_start, scene.frame_end):
                scene.frame_set(frame)
                shots.append(Shot(self._camera_job(context), frame))
                yield Step(0.0, f"reading frame {frame}")
        finally:
            scene.frame_set(kept)
        return (yield from advise(shots, goal, self.seconds))

    def _camera_job(self, context: bpy.types.Context) -> sources.Job:
        """The job of the scene's camera, at the render's size (the view's own where there is no camera)."""
        job, camera = sources.job_for_view(context), context.scene.camera
        if camera is None:
            return job
        depsgraph, size = context.evaluated_depsgraph_get(), sources.render_size(context.scene)
        return replace(job, camera=camera_from_object(camera.evaluated_get(depsgraph), depsgraph, size, job.scene.origin_ws), size=size)

    def _finish(self, context: bpy.types.Context, advice: Advice) -> set[str]:
        session.remember_advice(advice_report(advice))
        for note in advice.notes:
            self.report({"INFO"}, note)
        redraw(context)
        return {"FINISHED"}


class CAD_SHADOW_OT_apply_advice(bpy.types.Operator):
    """Write the proposed warp, partition, fit and map size into the scene's settings"""

    bl_idname = "cad_shadow.apply_advice"
    bl_label = "Apply"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Grey until there is a proposal."""
        advice = session.last_advice()
        if advice is None or advice["proposal"] is None:
            cls.poll_message_set("There is no proposal yet: press Advise first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write it; a warp set by hand is given up."""
        store(context.scene.cad_shadow, {"eta": None, "warp_parameter": None, **session.last_advice()["proposal"]["options"]})
        return {"FINISHED"}


OPERATOR = CAD_SHADOW_OT_advise
ALSO = (CAD_SHADOW_OT_apply_advice,)
