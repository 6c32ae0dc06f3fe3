"""A sun object turned to where the sun stands, by Blender's Sun Position add-on where that is enabled, else by us."""

from __future__ import annotations

from math import pi

import bpy
from mathutils import Euler, Matrix

from ..maths.sun import Place
from ..studies.sun.moments import Moment


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
