"""The scene's sun as an object: found or made, pointed at a moment's sun by Blender's Sun Position add-on where enabled, else by us."""

from __future__ import annotations

import bpy

from ..blender.sun_properties import CadShadowSun, set_moment
from ..blender.sun_turning import is_sun
from ..maths.sun import Place
from ..studies.sun.moments import Moment

NAME = "CAD Sun"


def find_or_make(context: bpy.types.Context) -> bpy.types.Object:
    """The chosen light where it is a sun, else the active object, else the first visible sun, else a new one; it becomes the chosen one."""
    props, layer = context.scene.cad_shadow, context.view_layer
    wishes = [props.light if props.light_source == "OBJECT" else None, layer.objects.active, *layer.objects]
    sun = next((ob for ob in wishes if is_sun(ob) and ob.name in layer.objects and ob.visible_get()), None)
    if sun is None:
        sun = bpy.data.objects.new(NAME, bpy.data.lights.new(NAME, "SUN"))
        sun.data.energy = 1.0  # as Add > Light > Sun makes it; Blender's data has 10, which bleaches everything
        context.scene.collection.objects.link(sun)
        context.view_layer.update()
    props.light_source, props.light = "OBJECT", sun
    return sun


def put(context: bpy.types.Context, sun: bpy.types.Object, props: CadShadowSun, moment: Moment, place: Place) -> None:
    """Move the sun to the moment."""
    set_moment(context.scene, sun, props, moment, place)
    context.view_layer.update()
