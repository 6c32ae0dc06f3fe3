"""`cad_shadow.advise`: search the best combination for this view or animation."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import bpy

from ..blender import session, sources
from ..blender.snapshot import camera_from_object
from ..errors import Cancelled, UserError
from ..studies.advice import Advice, Goal, SampledFrame, advice_report, advise
from ..studies.advice.goal import MOST_FRAMES, picked_frames
from ..studies.pending import Cancels, Chained, Pending, Progress
from .background import JobOperator, OnThread, view_read
from .row import OperatorRow

MEBI = 2**20
GOALS = (
    ("TEXELS", "Least Error", "The least error for a number of texels, shared by all shadow maps"),
    ("ERROR", "Fewest Texels", "The fewest texels with which 95 % of the pixels keep below an error"),
)


def searched(frames: list[SampledFrame], goal: Goal, seconds: float, say: Progress, is_given_up: Cancels) -> Advice:
    """The whole search, for a thread of its own. Raises `UserError`, `Cancelled` when it is given up."""
    steps = advise(frames, goal, seconds)
    while not is_given_up():
        try:
            step = next(steps)
        except StopIteration as stop:
            return stop.value
        say(step.fraction, step.text)
    raise Cancelled("Cancelled.")


class AnimationReading:
    """Frames of the animation being read one after another (a `Pending`). The scene's frame is put back."""

    def __init__(self, context: bpy.types.Context) -> None:
        self._scene = context.scene
        self._kept = self._scene.frame_current
        self._left = list(picked_frames(self._scene.frame_start, self._scene.frame_end))
        self._frames: list[SampledFrame] = []
        self._reading: sources.ViewReading | None = None

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the frame it is at."""
        return 0.0, f"reading frame {self._scene.frame_current}"

    def done(self) -> bool:
        """True when `result` will not wait. Goes on reading, a slice at a time."""
        if self._left:
            self._read(waits=False)
        return not self._left

    def cancel(self) -> None:
        """Give it up."""
        self._scene.frame_set(self._kept)

    def result(self, _timeout_s: float | None = None) -> list[SampledFrame]:
        """The frames; raises `UserError`."""
        while self._left:
            self._read(waits=True)
        return self._frames

    def _read(self, waits: bool) -> None:
        """One step: turn to the next frame, or go on reading it."""
        try:
            if self._reading is None:
                self._scene.frame_set(self._left[0])
                self._reading = sources.ViewReading()
            if waits or self._reading.done():
                self._frames.append(SampledFrame(camera_job(bpy.context, self._reading.job(bpy.context)), self._left.pop(0)))
                self._reading = None
        except UserError:
            self._scene.frame_set(self._kept)
            raise
        if not self._left:
            self._scene.frame_set(self._kept)


def camera_job(context: bpy.types.Context, job: sources.Job) -> sources.Job:
    """The job through the scene's camera, at the render's size (the view's own where there is no camera)."""
    camera = context.scene.camera
    if camera is None:
        return job
    depsgraph, size = context.evaluated_depsgraph_get(), sources.render_size(context.scene)
    return replace(job, camera=camera_from_object(camera.evaluated_get(depsgraph), depsgraph, size, job.scene.origin_ws), size=size)


class CAD_SHADOW_OT_advise(JobOperator, bpy.types.Operator):
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

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the goal first."""
        return context.window_manager.invoke_props_dialog(self) if context.window else super().execute(context)

    def draw(self, _context: bpy.types.Context) -> None:
        """The dialog: only the number that the goal needs."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "goal")
        layout.prop(self, "texels" if self.goal == "TEXELS" else "error")
        layout.prop(self, "use_animation")
        layout.prop(self, "seconds")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Search: beside the window when there is one, else at once."""
        is_window = context.window is not None and not bpy.app.background
        return super().invoke(context, None) if is_window else super().execute(context)

    def start(self, context: bpy.types.Context) -> Pending[Advice]:
        """Have the frames read, then the search begun."""
        goal = Goal(texels=round(self.texels * MEBI)) if self.goal == "TEXELS" else Goal(error=self.error)
        seconds = self.seconds

        def search(frames: list[SampledFrame]) -> OnThread:
            return OnThread(partial(searched, frames, goal, seconds))

        if self.use_animation:
            return Chained(AnimationReading(context), search)
        return view_read(context, lambda reading: search([SampledFrame(reading.job(bpy.context))]))

    def take(self, _context: bpy.types.Context, advice: Advice) -> None:
        """The panel shows it."""
        session.remember_advice(advice_report(advice))
        for note in advice.notes:
            self.report({"INFO"}, note)


ROW = OperatorRow("advise", 60, (CAD_SHADOW_OT_advise,), group="picture")
