"""`cad_shadow.copy_diagnostics`: what someone who helps needs to know, on the clipboard."""

from __future__ import annotations

import bpy

from ..blender import session
from ..blender.properties import settings_from
from ..studies.diagnostics import diagnostics
from .row import OperatorRow


def host() -> dict[str, object]:
    """What Blender says of itself."""
    app = bpy.app
    built = f"{app.build_platform.decode()}, {app.build_commit_date.decode()}"
    return {"version": app.version_string, "build": built, "background": app.background, "render engine": bpy.context.scene.render.engine}


class CAD_SHADOW_OT_copy_diagnostics(bpy.types.Operator):
    """Copy versions, OpenGL, preferences, changed settings and the last errors to the clipboard, for a report of a problem"""

    bl_idname = "cad_shadow.copy_diagnostics"
    bl_label = "Copy Diagnostics"
    bl_options = {"REGISTER"}

    with_paths: bpy.props.BoolProperty(
        name="With Paths", description="Keep the paths that messages name; they hold names of folders and files", default=False
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Copy the text."""
        last = session.last()
        settings = settings_from(context.scene.cad_shadow)
        text = diagnostics(host(), settings, None if last is None else last.report, self.with_paths)
        context.window_manager.clipboard = text
        self.report({"INFO"}, "Diagnostics copied: paste them into your report")
        return {"FINISHED"}


ROW = OperatorRow("copy_diagnostics", 510, (CAD_SHADOW_OT_copy_diagnostics,), group="help")
