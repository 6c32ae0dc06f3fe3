"""`cad_shadow.place_sun`: the sun where it stands at the scene's place and time."""

from __future__ import annotations

from math import degrees

import bpy

from ..blender.sun_properties import sky_of
from ..errors import UserError
from ..studies.sun.moments import moment
from .row import OperatorRow
from .sun_object import find_or_make, put
from .ticking import refused


class CAD_SHADOW_OT_place_sun(bpy.types.Operator):
    """Turn the scene's sun to where it stands at this place and time (a sun is added if there is none) and let it cast the shadows"""

    bl_idname = "cad_shadow.place_sun"
    bl_label = "Place Sun"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Turn the sun."""
        props = context.scene.cad_shadow.sun
        try:
            clock, place = sky_of(props)
            now = moment(clock, place, props.hours)
        except UserError as error:
            return refused(self, error)
        put(context, find_or_make(context), props, now, place)
        text = f"The sun stands at azimuth {degrees(now.azimuth_rad):.1f}°, elevation {degrees(now.elevation_rad):.1f}°"
        self.report({"INFO"} if now.is_up else {"WARNING"}, text if now.is_up else text + ": it is night")
        return {"FINISHED"}


ROW = OperatorRow("place_sun", 210, (CAD_SHADOW_OT_place_sun,), group="sun", section="sun", icon="LIGHT_SUN")
