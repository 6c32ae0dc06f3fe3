"""What the panels of camera and sun show."""

from __future__ import annotations

import bpy

from ...errors import SettingsError
from ..sun_properties import sky_of
from .words import paragraph


def draw_camera(self: bpy.types.Panel, _context: bpy.types.Context) -> None:
    """Helpers for the scene's camera."""
    column = self.layout.column(align=True)
    column.operator("cad_shadow.frame_camera", icon="OUTLINER_OB_CAMERA")
    column.operator("cad_shadow.fit_clip", icon="ARROW_LEFTRIGHT")


def draw_sun(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """Place and time of the sun."""
    layout, sun = self.layout, context.scene.cad_shadow.sun
    layout.use_property_split, layout.use_property_decorate = True, False
    for names in (("latitude", "longitude", "north_offset"), ("year", "month", "day"), ("hours",)):
        column = layout.column(align=True)
        for name in names:
            column.prop(sun, name)
    try:
        sky_of(sun)
    except SettingsError as error:
        paragraph(layout, context, str(error), "ERROR")
    layout.prop(context.window_manager, "cad_shadow_sun_path")
    row = layout.row(heading="UTC Offset")
    row.prop(sun, "use_utc_offset", text="")
    value = row.row()
    value.active = sun.use_utc_offset
    value.prop(sun, "utc_offset", text="")


def draw_sun_study(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """The sun over a day: pictures and keyframes."""
    layout, sun = self.layout, context.scene.cad_shadow.sun
    layout.use_property_split, layout.use_property_decorate = True, False
    layout.prop(sun, "use_hours")
    column = layout.column(align=True)
    column.active = sun.use_hours
    column.prop(sun, "start")
    column.prop(sun, "end")
    layout.prop(sun, "steps")
    column = layout.column(align=True)
    column.operator("cad_shadow.sun_study", icon="IMAGE_REFERENCE")
    column.operator("cad_shadow.animate_sun", icon="KEYTYPE_KEYFRAME_VEC")


def draw_sun_hours(self: bpy.types.Panel, context: bpy.types.Context) -> None:
    """How long the sun shines on what."""
    layout, sun = self.layout, context.scene.cad_shadow.sun
    layout.use_property_split, layout.use_property_decorate = True, False
    for name in ("hours_days", "hours_step", "sky_directions"):
        layout.prop(sun, name)
    layout.operator("cad_shadow.sun_hours", icon="LIGHT_SUN")
