"""Place and time of a scene's sun, stored with it: `scene.cad_shadow.sun`. Angles of the map in degrees, as maps give them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from datetime import date, timedelta
from math import degrees, pi, radians

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty

from ..errors import SettingsError
from ..maths.sun import Clock, Place, nautical_offset_h
from ..studies.sun.days import DEFAULT_STEP_MIN, SKY_DIRECTIONS, SunSpan
from ..studies.sun.moments import DEFAULT_STEPS, Moment, moment
from .redraw import on_change
from .sun_turning import is_sun, sun_position_addon, turn


def _moved(self: CadShadowSun, context: bpy.types.Context) -> None:
    """The sun that casts the shadows goes where place and time say, at once. With a date that does not exist it stays where it is."""
    scene = self.id_data
    props = scene.cad_shadow
    sun = props.light if props.light_source == "OBJECT" else None
    if is_sun(sun):
        with suppress(SettingsError):  # the panel says so
            clock, place = sky_of(self)
            set_moment(scene, sun, self, moment(clock, place, self.hours), place)
    on_change(self, context)


def _hours(name: str, description: str, default: float, update: Callable = on_change) -> object:
    return FloatProperty(
        name=name, description=description, default=default, min=0.0, max=24.0, step=25, precision=2, options=set(), update=update
    )


class CadShadowSun(bpy.types.PropertyGroup):
    """Where on Earth the scene lies, and when it is looked at."""

    latitude: FloatProperty(
        name="Latitude",
        description="Degrees north of the equator, negative southwards",
        default=60.0,
        min=-90.0,
        max=90.0,
        precision=4,
        options=set(),
        update=_moved,
    )
    longitude: FloatProperty(
        name="Longitude",
        description="Degrees east of Greenwich, negative westwards",
        default=2.0,
        min=-180.0,
        max=180.0,
        precision=4,
        options=set(),
        update=_moved,
    )
    north_offset: FloatProperty(
        name="North Offset",
        description="Angle from the world's +Y to north, clockwise seen from above",
        subtype="ANGLE",
        default=0.0,
        soft_min=-pi,
        soft_max=pi,
        options=set(),
        update=_moved,
    )
    year: IntProperty(name="Year", description="Year of the date", default=2026, min=1, max=4000, options=set(), update=_moved)
    month: IntProperty(name="Month", description="Month of the date", default=6, min=1, max=12, options=set(), update=_moved)
    day: IntProperty(name="Day", description="Day of the month", default=21, min=1, max=31, options=set(), update=_moved)
    hours: _hours("Time", "Time of the day in hours: 13.5 is half past one. Moves the sun that casts the shadows", 12.0, _moved)
    use_utc_offset: BoolProperty(
        name="Set UTC Offset",
        description="Set the clock's distance from universal time by hand; off: the time zone that the longitude suggests, no summer time",
        options=set(),
        update=_moved,
    )
    utc_offset: FloatProperty(
        name="UTC Offset",
        description="Hours that the clock is ahead of universal time: 2 in Oslo in summer",
        default=0.0,
        min=-14.0,
        max=14.0,
        step=50,
        precision=2,
        options=set(),
        update=_moved,
    )
    use_hours: BoolProperty(
        name="Set Hours",
        description="Choose the hours of the study and the animation; off: from sunrise to sunset",
        options=set(),
        update=on_change,
    )
    start: _hours("From", "First hour of the study and the animation", 8.0)
    end: _hours("To", "Last hour of the study and the animation", 18.0)
    steps: IntProperty(
        name="Pictures",
        description="Pictures of the sun study",
        default=DEFAULT_STEPS,
        min=1,
        soft_max=48,
        max=400,
        options=set(),
        update=on_change,
    )
    hours_days: IntProperty(
        name="Days",
        description="Days from the date on that sun hours are counted for; of many, a dozen are looked at, and the hours are a mean day's",
        default=1,
        min=1,
        soft_max=366,
        max=3660,
        options=set(),
        update=on_change,
    )
    hours_step: FloatProperty(
        name="Step",
        description="Minutes from one sun to the next when sun hours are counted: half of them is how well the hours are known",
        default=DEFAULT_STEP_MIN,
        min=0.1,
        soft_min=1.0,
        soft_max=60.0,
        max=240.0,
        step=100,
        precision=1,
        options=set(),
        update=on_change,
    )
    sky_directions: IntProperty(
        name="Sky Directions",
        description="Directions that the share of the sky is looked for in; 0 leaves it out",
        default=SKY_DIRECTIONS,
        min=0,
        soft_max=1024,
        max=100_000,
        options=set(),
        update=on_change,
    )


def sky_of(props: CadShadowSun) -> tuple[Clock, Place]:
    """The clock and the place; raises `SettingsError` for a date that does not exist."""
    try:
        day = date(props.year, props.month, props.day)
    except ValueError as error:
        raise SettingsError(f"There is no {props.year}-{props.month:02d}-{props.day:02d}: correct the day of the month.") from error
    place = Place(radians(props.latitude), radians(props.longitude), props.north_offset)
    return Clock(day, props.utc_offset if props.use_utc_offset else nautical_offset_h(place.longitude_rad)), place


def hours_of(props: CadShadowSun) -> tuple[float | None, float | None]:
    """From and to, None where the day's light decides."""
    return (props.start, props.end) if props.use_hours else (None, None)


def span_of(props: CadShadowSun) -> SunSpan:
    """The days and hours that sun hours are counted for; raises `SettingsError`."""
    clock = sky_of(props)[0]
    try:
        last = clock.day + timedelta(days=props.hours_days - 1)
    except OverflowError as error:
        raise SettingsError("The last day lies beyond the year 9999: count fewer days.") from error
    return SunSpan(clock, last, props.hours_step, *hours_of(props))


def to_sun_position(theirs: bpy.types.PropertyGroup, props: CadShadowSun, sun: bpy.types.Object, hours: float) -> None:
    """Hand place, time and the sun to Blender's Sun Position add-on, which then moves the sun (its properties do so when written).

    The day is 1 while year and month change, so that no date on the way is impossible.
    """
    clock, place = sky_of(props)
    values = {
        "usage_mode": "NORMAL",
        "use_day_of_year": False,
        "use_daylight_savings": False,
        "day": 1,
        "year": clock.day.year,
        "month": clock.day.month,
        "latitude": degrees(place.latitude_rad),
        "longitude": degrees(place.longitude_rad),
        "north_offset": place.north_offset_rad,
        "UTC_zone": clock.utc_offset_h,
        "time": hours,
        "sun_object": sun,
    }
    for name, value in values.items():
        setattr(theirs, name, value)
    theirs.day = clock.day.day


def set_moment(scene: bpy.types.Scene, sun: bpy.types.Object, props: CadShadowSun, now: Moment, place: Place) -> None:
    """Move the sun to the moment."""
    theirs = sun_position_addon(scene)
    if theirs is None:
        turn(sun, now, place)
    else:
        to_sun_position(theirs, props, sun, now.hours)


def register() -> None:
    """Make the group known, before the settings that hold it."""
    bpy.utils.register_class(CadShadowSun)


def unregister() -> None:
    """Forget it."""
    bpy.utils.unregister_class(CadShadowSun)
