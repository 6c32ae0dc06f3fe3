"""`cad_shadow.animate_sun`: the day's sun as keyframes over the scene's frame range."""

from __future__ import annotations

import bpy

from ..blender.sun_properties import hours_of, sky_of
from ..blender.sun_turning import turn
from ..errors import UserError
from ..studies.sun.moments import moments
from .row import OperatorRow
from .sun_object import find_or_make
from .ticking import refused


class CAD_SHADOW_OT_animate_sun(bpy.types.Operator):
    """Move the sun through the day with one keyframe per frame, from the scene's first frame to its last"""

    bl_idname = "cad_shadow.animate_sun"
    bl_label = "Animate Sun"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set the keyframes."""
        scene = context.scene
        frames = range(scene.frame_start, scene.frame_end + 1)
        try:
            clock, place = sky_of(scene.cad_shadow.sun)
            day = moments(clock, place, *hours_of(scene.cad_shadow.sun), len(frames))
        except UserError as error:
            return refused(self, error)
        sun = find_or_make(context)
        sun.rotation_mode = "QUATERNION"
        last = None
        for frame, now in zip(frames, day, strict=True):
            turn(sun, now, place)
            if last is not None:
                sun.rotation_quaternion.make_compatible(last)
            last = sun.rotation_quaternion.copy()
            sun.keyframe_insert("rotation_quaternion", frame=frame)
        scene.frame_set(scene.frame_current)
        self.report({"INFO"}, f"The sun moves from {day[0].time} to {day[-1].time} in frames {frames[0]} to {frames[-1]}")
        return {"FINISHED"}


ROW = OperatorRow("animate_sun", 220, (CAD_SHADOW_OT_animate_sun,), group="sun")
