"""`cad_shadow.impostor_export`: impostors as files, as planes in the scene, or as packed images in the .blend."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy

from ..blender.impostors.plane import make_plane, pack_images
from ..blender.snapshot.instances import listed
from ..errors import SceneError, UserError
from ..pipeline.impostors.baked import BakedImpostor
from ..pipeline.job import Job
from ..studies.impostors.asked import baking, groups_of
from ..studies.impostors.files import metadata, unique_names, write_impostor
from ..studies.pending import Chained, Pending, ready
from .background import JobOperator, view_read
from .impostors import ACTIVE, ALL, HIDDEN, SELECTED, NeedsMarks, chosen_marks, is_one_of
from .row import OperatorRow
from .ticking import refused

Baked = tuple[Job, list[BakedImpostor | UserError]]
FORMATS = [
    ("png", "PNG", "8-bit colour with alpha, 16-bit depth, normal and object numbers"),
    ("exr", "OpenEXR", "Exact linear colour, depth in metres, normals, object numbers"),
    ("npz", "NumPy", "All arrays in one file"),
]


def captures(job: Job, chosen: set[tuple[str, int]], unlit: bool) -> Pending[Baked]:
    """Ask for the job and its captures. Raises `SceneError` when there is nothing to capture."""
    groups = tuple(group for group in groups_of(job.scene) if is_one_of(group.key, chosen))
    if not groups:
        raise SceneError(HIDDEN)
    return Chained(baking(job, groups, unlit), lambda found: ready((job, found)))


class CAD_SHADOW_OT_impostor_export(NeedsMarks, JobOperator, bpy.types.Operator):
    """Capture impostors from this view, shaded as a preview is, and keep their images: colour, depth, normal, object numbers, and all that
    is needed to draw them elsewhere as JSON"""

    bl_idname = "cad_shadow.impostor_export"
    bl_label = "Export Impostors"
    bl_options = {"REGISTER", "UNDO"}

    target: bpy.props.EnumProperty(name="Of", description="Which impostors", items=[ALL, ACTIVE, SELECTED])
    to: bpy.props.EnumProperty(
        name="To",
        description="What is made",
        items=[
            ("FILES", "Files", "Images and a JSON file in a folder"),
            ("PLANE", "Plane", "A plane at the impostor's place whose material shows it, its images packed into the .blend"),
            ("PACKED", "Packed Images", "Images packed into the .blend"),
        ],
    )
    format: bpy.props.EnumProperty(name="Format", description="Format of the images", items=FORMATS)
    unlit: bpy.props.BoolProperty(name="Unlit", description="Bare colours of the surfaces, to be relit with the normals", default=False)
    directory: bpy.props.StringProperty(
        name="Folder", description="Where the files go", subtype="DIR_PATH", default="", options={"SKIP_SAVE"}
    )
    filter_folder: bpy.props.BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for a folder when files are wanted."""
        if self.to != "FILES":
            return super().invoke(context, event)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def draw(self, _context: bpy.types.Context) -> None:
        """What the file browser's side shows."""
        layout = self.layout
        layout.use_property_split = True
        for name in ("target", "to", "unlit"):
            layout.prop(self, name)
        if self.to == "FILES":
            layout.prop(self, "format")

    def start(self, context: bpy.types.Context) -> Pending[Baked]:
        """Ask for the captures."""
        if self.to == "FILES" and not self.directory:
            raise SceneError("Choose a folder for the files (directory=…).")
        chosen = chosen_marks(context, self.target)
        return view_read(context, lambda reading: captures(reading.job(bpy.context), chosen, self.unlit))

    def take(self, context: bpy.types.Context, result: Baked) -> None:
        """Keep what was captured as asked."""
        job, found = result
        try:
            done = self._keep(context, job, found)
        except UserError as error:
            refused(self, error)
            return
        made = {"FILES": f"written to {self.directory}", "PLANE": "plane added at its place", "PACKED": "packed into the file"}
        if done:
            self.report({"INFO"}, f"{listed(done)}: {made[self.to]}")

    def _keep(self, context: bpy.types.Context, job: Job, results: list[BakedImpostor | UserError]) -> list[str]:
        """Files, planes or packed images of what could be captured; the names. What could not is reported."""
        good = [result for result in results if isinstance(result, BakedImpostor)]
        for error in results:
            if not isinstance(error, BakedImpostor):
                refused(self, error)
        keep: dict[str, Callable[[BakedImpostor, str], object]] = {
            "FILES": lambda one, name: write_impostor(Path(bpy.path.abspath(self.directory)) / name, one, job.scene, self.format),
            "PLANE": lambda one, name: _add(context, make_plane(one, metadata(one, job.scene, {}))),
            "PACKED": lambda one, name: pack_images(one, metadata(one, job.scene, {})),
        }
        for one, name in zip(good, unique_names([one.name for one in good]), strict=True):
            keep[self.to](one, name)
        return [one.name for one in good]


def _add(context: bpy.types.Context, plane: bpy.types.Object) -> None:
    """Put the plane into the active collection, selected."""
    context.collection.objects.link(plane)
    plane.select_set(True)


ROW = OperatorRow("impostor_export", 330, (CAD_SHADOW_OT_impostor_export,), group="impostors")
