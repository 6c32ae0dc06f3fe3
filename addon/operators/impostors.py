"""Marking impostors: `cad_shadow.impostor_create`, `.impostor_remove`, and capturing them anew: `.impostor_regenerate`."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..blender import session
from ..blender.impostors.marks import active_mark, all_marked, has_surface, is_marked, set_mark
from ..blender.snapshot import mark_of_id
from ..blender.snapshot.instances import listed
from ..errors import SceneError
from ..maths.relief.settings import ALL_AT_ONCE
from ..pipeline.job import Job
from ..scene.records import Mark
from ..studies.pending import Pending
from ..studies.run import Outcome, submit
from .background import JobOperator, view_read
from .row import OperatorRow
from .ticking import refused

ACTIVE = ("ACTIVE", "Chosen in the List", "The impostor chosen in the list")
SELECTED = ("SELECTED", "Selected Objects", "The selected objects that are impostors")
ALL = ("ALL", "All", "Every impostor of the file")
NOTHING_MARKED = "Nothing is marked as an impostor: select objects and press Make Impostors"
HIDDEN = "Those impostors have no surface in this view: unhide their objects."
OFF = "Impostors are switched off: set Impostors to Automatic or Manual"


class NeedsMarks:
    """Mix-in: grey while nothing is marked."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Grey with a reason without impostors."""
        if not all_marked():
            cls.poll_message_set(NOTHING_MARKED)
            return False
        return True


class NeedsImpostors(NeedsMarks):
    """Mix-in: grey while nothing is marked, or impostors are off."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Grey with a reason without impostors to draw."""
        if not super().poll(context):
            return False
        if context.scene.cad_shadow.impostor_use == "off":
            cls.poll_message_set(OFF)
            return False
        return True


def chosen_marks(context: bpy.types.Context, target: str) -> set[tuple[str, int]]:
    """(kind, number) of the marks that `target` means. Raises `SceneError` when there are none."""
    if target == "ACTIVE":
        mark = active_mark()
        found = [mark] if mark else []
        problem = "No impostor is chosen in the list: click on one."
    elif target == "SELECTED":
        found = [mark_of_id(h) for h in all_marked() if _is_selected(h, context.selected_objects)]
        problem = "None of the selected objects is an impostor: select one, or choose All."
    else:
        found, problem = [mark_of_id(holder) for holder in all_marked()], f"{NOTHING_MARKED}."
    if not found:
        raise SceneError(problem)
    return {(mark.kind, mark.uid) for mark in found}


def _is_selected(holder: bpy.types.ID, selected: list[bpy.types.Object]) -> bool:
    """An object that is selected, a collection of which something is."""
    if isinstance(holder, bpy.types.Object):
        return holder in selected
    return any(ob.name in holder.all_objects for ob in selected)


def is_one_of(mark: Mark, chosen: set[tuple[str, int]]) -> bool:
    """Whether a mark, or the copy of one, is among those chosen."""
    return (mark.kind, mark.uid) in chosen


class CAD_SHADOW_OT_impostor_create(bpy.types.Operator):
    """Mark the selected objects, or the active collection as a whole, as impostors: previews then draw them from a texture with depth.
    The objects stay as they are and stay selectable"""

    bl_idname = "cad_shadow.impostor_create"
    bl_label = "Make Impostors"
    bl_options = {"REGISTER", "UNDO"}

    target: bpy.props.EnumProperty(
        name="Of",
        description="What becomes an impostor",
        items=[
            ("OBJECTS", "Selected Objects", "Each selected object becomes an impostor of its own; an empty stands for all below it"),
            ("COLLECTION", "Active Collection", "All objects of the active collection become one impostor"),
        ],
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Grey with a reason when there is nothing that could be one."""
        if any(has_surface(ob) for ob in context.selected_objects):
            return True
        collection = context.collection
        if collection is not None and collection != context.scene.collection and any(map(has_surface, collection.all_objects)):
            return True
        cls.poll_message_set("Select an object with a surface, or make a collection with such objects the active one")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set the marks."""
        if self.target == "COLLECTION":
            wanted = [context.collection]
            if context.collection == context.scene.collection:
                self.report({"ERROR"}, "The scene's own collection cannot be an impostor: put the objects into one of its collections")
                return {"CANCELLED"}
            left_out = [] if any(map(has_surface, context.collection.all_objects)) else wanted
        else:
            wanted = list(context.selected_objects)
            left_out = [ob for ob in wanted if not has_surface(ob)]
        if left_out:
            self.report({"WARNING"}, f"Nothing to draw of {listed([one.name for one in left_out])}: not made impostors")
        made = [one for one in wanted if one not in left_out and not is_marked(one)]
        for one in made:
            set_mark(one, True)
        if not made:
            self.report({"INFO"}, "Nothing to do: they are impostors already" if len(left_out) < len(wanted) else "Nothing became one")
            return {"CANCELLED"}
        self.report({"INFO"}, f"{listed([one.name for one in made])}: captured with the next picture")
        return {"FINISHED"}


class CAD_SHADOW_OT_impostor_remove(NeedsMarks, bpy.types.Operator):
    """Make impostors ordinary objects again, drawn as geometry"""

    bl_idname = "cad_shadow.impostor_remove"
    bl_label = "Remove Impostors"
    bl_options = {"REGISTER", "UNDO"}

    target: bpy.props.EnumProperty(name="Of", description="Which impostors", items=[ACTIVE, SELECTED, ALL])

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Take the marks away."""
        try:
            chosen = chosen_marks(context, self.target)
        except SceneError as error:
            return refused(self, error)
        removed = [holder for holder in all_marked() if is_one_of(mark_of_id(holder), chosen)]
        for holder in removed:
            set_mark(holder, False)
        self.report({"INFO"}, f"{listed([holder.name for holder in removed])}: drawn as geometry again")
        return {"FINISHED"}


class CAD_SHADOW_OT_impostor_regenerate(NeedsImpostors, JobOperator, bpy.types.Operator):
    """Capture impostors anew from what this viewport shows"""

    bl_idname = "cad_shadow.impostor_regenerate"
    bl_label = "Regenerate Impostors"
    bl_options = {"REGISTER"}

    target: bpy.props.EnumProperty(
        name="Of",
        description="Which impostors",
        items=[ACTIVE, SELECTED, ("STALE", "Stale", "Those whose object has changed or whose predicted error is over its limit"), ALL],
        default="ALL",
    )

    def start(self, context: bpy.types.Context) -> Pending:
        """Ask for a picture with new captures."""
        chosen = None if self.target == "STALE" else chosen_marks(context, self.target)
        return view_read(context, lambda reading: submit(captured_anew(reading.job(bpy.context), chosen)))

    def finish(self, context: bpy.types.Context, outcome: Outcome) -> None:
        """Say what was captured, and what could not be."""
        reports = session.impostors()
        fresh = [r.name for r in reports if r.stage == "regenerated"]
        failed = [r for r in reports if "cannot be captured" in r.reason]
        for report in failed:
            self.report({"WARNING"}, f"{report.name}: {report.reason}")
        self.report({"INFO"}, f"Captured anew: {listed(fresh)}" if fresh else "Nothing was captured: none needs it, or none is in view")


def captured_anew(job: Job, chosen: set[tuple[str, int]] | None) -> Job:
    """The job with new captures of the marks chosen, None: of those that need it. Raises `SceneError` when none of them is there."""
    choice = job.impostors
    if choice is None:
        raise SceneError(HIDDEN)
    if chosen is None:
        return replace(job, impostors=replace(choice, settings=replace(choice.settings, use="automatic", regenerations=ALL_AT_ONCE)))
    keys = frozenset(group.key for group in choice.groups if is_one_of(group.key, chosen))
    if not keys:
        raise SceneError(HIDDEN)
    return replace(job, impostors=replace(choice, settings=replace(choice.settings, use="manual"), regenerate=keys))


ROW = OperatorRow(
    "impostors", 310, (CAD_SHADOW_OT_impostor_create, CAD_SHADOW_OT_impostor_remove, CAD_SHADOW_OT_impostor_regenerate), group="impostors"
)
