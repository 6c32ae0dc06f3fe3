"""`cad_shadow.impostor_report`: the warping error of every impostor in numbers, and the critical points over the texture of one."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from ..blender import image_editor, session
from ..blender.impostors.marks import active_mark
from ..errors import SceneError
from ..pipeline.frame import Frame
from ..pipeline.job import Job
from ..studies.impostors.asked import shaded_texture
from ..studies.impostors.states import annotated
from ..studies.run import Outcome, Pending
from .background import JobOperator, PendingView
from .impostors import HIDDEN, NeedsImpostors

if TYPE_CHECKING:
    from ..pipeline.frame import ImpostorReport

TITLE = f"{image_editor.NAME}: critical points"


def by_error(reports: tuple[ImpostorReport, ...]) -> list[ImpostorReport]:
    """The largest predicted error first, those without a texture last."""
    return sorted(reports, key=lambda report: 1.0 if report.error is None else -report.error)


class PendingReport:
    """A picture with every predictor, then the texture of the impostor that is looked at. Like `Pending`, nothing of it waits."""

    def __init__(self, job: Job, wanted: tuple[str, int] | None) -> None:
        self.job, self.looked_at = job, None
        self.texture: Future[Frame] | None = None
        self._first, self._wanted = Pending(job), wanted

    @property
    def progress(self) -> tuple[float, str]:
        """How far it is, 0…1, and the stage it is in."""
        return self._first.progress if self.texture is None else (0.95, "texture")

    def done(self) -> bool:
        """True when `result` will not wait."""
        if not self._first.done():
            return False
        if self.texture is None and self.looked_at is None:
            self._look()
        return self.texture is None or self.texture.done()

    def cancel(self) -> None:
        """Give it up."""
        self._first.cancel()
        if self.texture is not None:
            self.texture.cancel()

    def result(self) -> Outcome:
        """The outcome of the picture; `looked_at` and `texture` are there afterwards. Raises as `Pending.result` does."""
        outcome = self._first.result()
        if self.texture is None and self.looked_at is None:
            self._look()
        if self.texture is not None:
            self.texture.result()
        return outcome

    def _look(self) -> None:
        """Ask for the colours of the impostor wanted, else of the one with the largest error."""
        try:
            reports = self._first.result().frame.impostors
        except Exception:  # raised again by `result`
            return
        ranked = by_error(reports)
        with_texture = [r for r in ranked if r.edges is not None]
        chosen = [r for r in with_texture if (r.key.kind, r.key.uid) == self._wanted] or with_texture
        if chosen:
            self.looked_at = chosen[0]
            group = next(g for g in self.job.impostors.groups if g.key == self.looked_at.key)
            self.texture = shaded_texture(self.job, group, self.looked_at.edges.frame)


class CAD_SHADOW_OT_impostor_report(NeedsImpostors, JobOperator, bpy.types.Operator):
    """Predict the warping error of every impostor for this view, mark the critical points in the viewport, and show them over the texture
    of the impostor chosen in the list"""

    bl_idname = "cad_shadow.impostor_report"
    bl_label = "Impostor Report"
    bl_options = {"REGISTER"}

    def start(self, context: bpy.types.Context) -> PendingView:
        """Ask for a picture with all predictors."""
        return PendingView(context, lambda reading: self._ask(reading.job(bpy.context)))

    def _ask(self, job: Job) -> PendingReport:
        if job.impostors is None:
            raise SceneError(HIDDEN)
        mark = active_mark()
        wanted = None if mark is None else (mark.kind, mark.uid)
        self._asked = PendingReport(replace(job, impostors=replace(job.impostors, exact=True)), wanted)
        return self._asked

    def finish(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Show the critical points, say the numbers."""
        context.window_manager.cad_shadow_impostor_points = True
        for report in by_error(session.impostors()):
            self.report({"INFO"}, line(report))
        looked_at, texture = self._asked.looked_at, self._asked.texture
        if texture is not None:
            picture = annotated(texture.result().passes["combined"], looked_at.edges, outcome.job.impostors.edges.regions)
            image_editor.show(context, image_editor.to_image(picture, TITLE))


def line(report: ImpostorReport) -> str:
    """One impostor in a line: its state, its error against the limit, what the texts' critical point and the edge sum say."""
    if not report.errors:
        return f"{report.name}: {report.stage}, {report.reason or 'nothing captured'}"
    texts = ", ".join(
        f"{label} {report.errors[name]:.3g}"
        for name, label in (("critical", "critical point"), ("critical_px", "corrected (px)"), ("edge_sum_px", "edge sum (px)"))
    )
    error = f", {report.error / report.limit:.0%} of the limit" if report.error is not None else ""
    return f"{report.name}: {report.stage}{error}; {texts}"


OPERATORS = (CAD_SHADOW_OT_impostor_report,)
