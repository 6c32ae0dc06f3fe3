"""The scene's sun as an object: found or made, pointed at a moment's sun by Blender's Sun Position add-on where enabled, else by us."""

from __future__ import annotations

from math import pi

import bpy
from mathutils import Euler, Matrix

from ..blender.sun_properties import CadShadowSun, to_sun_position
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


def is_sun(ob: bpy.types.Object | None) -> bool:
    """True for an object that is a sun light."""
    return ob is not None and ob.type == "LIGHT" and ob.data.type == "SUN"


def sun_position_addon(scene: bpy.types.Scene) -> bpy.types.PropertyGroup | None:
    """The properties of Blender's Sun Position add-on, None where it is not enabled."""
    return getattr(scene, "sun_pos_properties", None)


def turn(sun: bpy.types.Object, moment: Moment, place: Place) -> None:
    """Turn the sun so that its light comes from the moment's direction; where it stands does not matter and is kept."""
    compass = moment.azimuth_rad + place.north_offset_rad
    rotation = Euler((moment.elevation_rad - pi / 2, 0.0, -compass)).to_matrix().to_4x4()
    sun.matrix_world = Matrix.Translation(sun.matrix_world.translation) @ rotation


def put(context: bpy.types.Context, sun: bpy.types.Object, props: CadShadowSun, moment: Moment, place: Place) -> None:
    """Move the sun to the moment."""
    theirs = sun_position_addon(context.scene)
    if theirs is None:
        turn(sun, moment, place)
    else:
        to_sun_position(theirs, props, sun, moment.hours)
    context.view_layer.update()
