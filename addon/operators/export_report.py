"""`cad_shadow.export_report`: write the last report as JSON."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper

from ..blender import session
from ..errors import UserError
from ..studies import outputs
from .row import OperatorRow
from .ticking import refused


class CAD_SHADOW_OT_export_report(ExportHelper, bpy.types.Operator):
    """Write the last report (error, partitions, times, settings) to a JSON file"""

    bl_idname = "cad_shadow.export_report"
    bl_label = "Export CAD Shadow Report"
    bl_options = {"REGISTER"}

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Grey until there is a report."""
        if session.last() is None:
            cls.poll_message_set("There is no report yet: press Preview or Analyse first")
            return False
        return True

    def execute(self, _context: bpy.types.Context) -> set[str]:
        """Write the file."""
        try:
            outputs.write_json(Path(self.filepath), session.last().report)
        except UserError as error:
            return refused(self, error)
        self.report({"INFO"}, f"Report written to {self.filepath}")
        return {"FINISHED"}


ROW = OperatorRow("export_report", 70, (CAD_SHADOW_OT_export_report,), group="picture", section="export", icon="EXPORT")
