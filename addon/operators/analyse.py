"""`cad_shadow.analyse`: the error report of the current view, without a picture."""

from __future__ import annotations

import bpy

from ..studies.run import Outcome
from .background import JobOperator
from .row import OperatorRow


class CAD_SHADOW_OT_analyse(JobOperator, bpy.types.Operator):
    """Measure how sharp the shadows of the current view are; the Quality panel lists the result"""

    bl_idname = "cad_shadow.analyse"
    bl_label = "Analyse CAD Shadows"
    bl_options = {"REGISTER"}

    def finish(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Say the most telling number; the panel has the rest."""
        measured = outcome.report["measured"]
        if measured and measured["m_p95"] is not None:
            self.report({"INFO"}, f"95 % of the pixels have an error m below {measured['m_p95']:.2f} pixels per texel")


ROW = OperatorRow("analyse", 20, (CAD_SHADOW_OT_analyse,), group="picture")
