"""`cad_shadow.impostor_report`: the warping error of every impostor in numbers, and the critical points over the texture of one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import bpy

from ..blender import image_editor, session
from ..blender.impostors.marks import active_mark
from ..errors import SceneError
from ..pipeline.frame import Frame
from ..pipeline.job import Job
from ..studies.impostors.asked import shaded_texture
from ..studies.impostors.states import annotated
from ..studies.pending import Chained, Pending, ready
from ..studies.run import Outcome, submit
from .background import JobOperator, view_read
from .impostors import HIDDEN, NeedsImpostors
from .row import OperatorRow

if TYPE_CHECKING:
    from ..pipeline.frame import ImpostorReport

TITLE = f"{image_editor.NAME}: critical points"


def by_error(reports: tuple[ImpostorReport, ...]) -> list[ImpostorReport]:
    """The largest predicted error first, those without a texture last."""
    return sorted(reports, key=lambda report: 1.0 if report.error is None else -report.error)


@dataclass(frozen=True, eq=False)
class Found:
    """A picture with every predictor; the impostor that is looked at and its colours, where one has a texture."""

    outcome: Outcome
    looked_at: ImpostorReport | None = None
    texture: Frame | None = None


def with_texture(outcome: Outcome, wanted: tuple[str, int] | None) -> Pending[Found]:
    """Ask for the colours of the impostor wanted, else of the one with the largest error."""
    ranked = [r for r in by_error(outcome.frame.impostors) if r.edges is not None]
    chosen = [r for r in ranked if (r.key.kind, r.key.uid) == wanted] or ranked
    if not chosen:
        return ready(Found(outcome))
    group = next(g for g in outcome.job.impostors.groups if g.key == chosen[0].key)
    texture = shaded_texture(outcome.job, group, chosen[0].edges.frame)
    return Chained(texture, lambda drawn: ready(Found(outcome, chosen[0], drawn.frame)))


class CAD_SHADOW_OT_impostor_report(NeedsImpostors, JobOperator, bpy.types.Operator):
    """Predict the warping error of every impostor for this view, mark the critical points in the viewport, and show them over the texture
    of the impostor chosen in the list"""

    bl_idname = "cad_shadow.impostor_report"
    bl_label = "Impostor Report"
    bl_options = {"REGISTER"}

    def start(self, context: bpy.types.Context) -> Pending[Found]:
        """Ask for a picture with all predictors, then the texture."""
        return view_read(context, lambda reading: self._ask(reading.job(bpy.context)))

    def _ask(self, job: Job) -> Pending[Found]:
        if job.impostors is None:
            raise SceneError(HIDDEN)
        mark = active_mark()
        wanted = None if mark is None else (mark.kind, mark.uid)
        exact = replace(job, impostors=replace(job.impostors, exact=True))
        return Chained(submit(exact), lambda outcome: with_texture(outcome, wanted))

    def take(self, context: bpy.types.Context, found: Found) -> None:
        """Remember the picture, show the critical points."""
        super().take(context, found.outcome)
        if found.texture is not None:
            regions = found.outcome.job.impostors.edges.regions
            picture = annotated(found.texture.passes["combined"], found.looked_at.edges, regions)
            image_editor.show(context, image_editor.to_image(picture, TITLE))

    def finish(self, context: bpy.types.Context, _outcome: Outcome) -> None:
        """Mark the critical points in the viewport, say the numbers."""
        context.window_manager.cad_shadow_impostor_points = True
        for report in by_error(session.impostors()):
            self.report({"INFO"}, line(report))


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


ROW = OperatorRow("impostor_report", 320, (CAD_SHADOW_OT_impostor_report,), group="impostors")
