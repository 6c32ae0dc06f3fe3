"""Scripting: hours of direct sun and the share of the sky, of a view's pixels and of the faces of a scene's objects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import date as Date
from math import radians

import bpy
import numpy as np

from ..blender.face_values import faces_of
from ..blender.rendering import read
from ..blender.sun_hours import FaceHours, face_hours
from ..maths.sun import Clock, Place, nautical_offset_h
from ..maths.view import Light
from ..studies.sun.days import DEFAULT_STEP_MIN, MOST_DAYS, SKY_DIRECTIONS, SunSpan, suns
from ..studies.sun.hours import HoursAsked, SunHours, hours_picture, object_rows
from ..studies.sun.hours import sun_hours as count
from .view import wish_for

ZENITH = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class SunHoursResult:
    """Hours of sun: of the pixels, of the objects, and of the faces of mesh objects where those were asked for."""

    found: SunHours
    faces: FaceHours | None
    title: str

    @property
    def hours(self) -> np.ndarray:
        """(h, w) hours of a day, or of the mean day of the range; NaN where nothing is seen."""
        return self.found.hours

    @property
    def sky_view(self) -> np.ndarray | None:
        """(h, w) share of the sky that is seen, 0…1; None where no sky was looked for."""
        return self.found.sky_view

    @property
    def most(self) -> float:
        """Hours that a place has which nothing shades."""
        return self.found.asked.most

    @property
    def picture(self) -> np.ndarray:
        """(h + legend, w, 3) uint8: the hours in color above their scale."""
        return hours_picture(self.found, self.title)

    @property
    def objects(self) -> list[dict[str, object]]:
        """A dictionary for every object: area_m2, samples, sun_hours_mean, sun_hours_min, sun_hours_max, sky_view_mean."""
        return object_rows(self.found.outcome.job.scene.object_names, self.found)

    def keep(self) -> int:
        """Write the mesh attributes `sun_hours` and `sky_view` of faces; gives how many objects have them."""
        return 0 if self.faces is None else self.faces.keep()


def sun_hours(
    scene: bpy.types.Scene | None = None,
    *,
    latitude: float,
    longitude: float,
    date: Date,
    to_date: Date | None = None,
    step_minutes: float = DEFAULT_STEP_MIN,
    hours: tuple[float | None, float | None] = (None, None),
    days: int = MOST_DAYS,
    utc_offset: float | None = None,
    north_offset: float = 0.0,
    sky_directions: int = SKY_DIRECTIONS,
    faces: bool = False,
    **arguments: object,
) -> SunHoursResult:
    """Count the hours of direct sun of a scene (default: the one in the window) in a view; `arguments` as for `preview`, without a light.

    Degrees; `hours` from and to (None: sunrise, sunset); of a range up to `to_date` at most `days` days are looked at. `faces`: also of all
    faces, to `keep` them. Raises `UserError`.
    """
    scene = scene or bpy.context.scene
    place = Place(radians(latitude), radians(longitude), radians(north_offset))
    clock = Clock(date, nautical_offset_h(place.longitude_rad) if utc_offset is None else utc_offset)
    span = SunSpan(clock, to_date or date, step_minutes, *hours, days)
    asked = HoursAsked(suns(span, place), sky_directions)
    sun = Light("sun", ZENITH, name="sun hours")
    job = read(scene, replace(wish_for(scene, **arguments), light=lambda _scene, _camera: sun))
    found = count(job, asked, _unsaid, _never)
    of_faces = None
    if faces:
        kept, complaints = faces_of(list(scene.view_layers[0].objects), bpy.context.evaluated_depsgraph_get())
        of_faces = face_hours(job, asked, kept, complaints, _unsaid, _never)
    return SunHoursResult(found, of_faces, span.title(place))


def _unsaid(_fraction: float, _stage: str) -> None:
    """Nobody watches."""


def _never() -> bool:
    return False
