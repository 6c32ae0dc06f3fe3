"""`cad_shadow.sun_hours`: hours of direct sun in the current view, as a picture, and on every face, as a mesh attribute. Esc cancels."""

from __future__ import annotations

import bpy

from ..blender import image_editor
from ..blender.sun_hours import FaceHours, hours_of_view, read_faces
from ..blender.sun_properties import sky_of, span_of
from ..studies.pending import Pending
from ..studies.sun.days import suns
from ..studies.sun.hours import HoursAsked, SunHours, hours_picture
from .background import JobOperator, on_thread
from .row import OperatorRow

IMAGE = f"{image_editor.NAME}: sun hours"
NO_SUN = "The sun does not shine there in the days and hours given: all hours are 0."
KEPT = "{} objects keep their hours in the mesh attribute sun_hours, the share of the sky in sky_view"


class CAD_SHADOW_OT_sun_hours(JobOperator, bpy.types.Operator):
    """Count the hours of direct sun, and the share of the sky that is seen: a picture of the current view with its scale, and on every face
    as the mesh attributes sun_hours and sky_view"""

    bl_idname = "cad_shadow.sun_hours"
    bl_label = "Sun Hours"
    bl_options = {"REGISTER", "UNDO"}

    def start(self, context: bpy.types.Context) -> Pending:
        """Read the faces and the view, then count."""
        props = context.scene.cad_shadow.sun
        span, place = span_of(props), sky_of(props)[1]
        asked = HoursAsked(suns(span, place), props.sky_directions)
        self._title = span.title(place)
        faces, complaints = read_faces(context)
        return on_thread(context, hours_of_view, asked, faces, complaints)

    def take(self, context: bpy.types.Context, result: tuple[SunHours, FaceHours]) -> None:
        """Show the picture and keep the faces' values."""
        seen, faces = result
        for line in [*faces.complaints, *([] if len(seen.asked.suns) else [NO_SUN])]:
            self.report({"WARNING"}, line)
        self.report({"INFO"}, KEPT.format(faces.keep()))
        picture = image_editor.displayed(hours_picture(seen, self._title))
        image_editor.show(context, image_editor.to_image(picture, IMAGE, is_data=True))


ROW = OperatorRow("sun_hours", 55, (CAD_SHADOW_OT_sun_hours,), group="picture")
