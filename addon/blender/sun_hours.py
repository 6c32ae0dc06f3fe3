"""Hours of sun for Blender: counted at the faces of a scene's objects and kept as attributes of their meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from ..pipeline.job import Job
from ..studies.pending import Cancels, Progress
from ..studies.sun.hours import HoursAsked, Parts, SunHours, hours_at, sun_hours
from .face_values import ObjectFaces, faces_of, keep

HOURS, SKY = "sun_hours", "sky_view"
"""The attributes of meshes."""


@dataclass(frozen=True, eq=False)
class FaceHours:
    """Objects with their faces, and the hours and the sky of all their places, one object after another; `complaints` of the others."""

    objects: list[ObjectFaces]
    hours: np.ndarray
    sky: np.ndarray | None
    complaints: list[str]

    def keep(self) -> int:
        """Write the attributes; gives how many objects have them."""
        ends, kept = np.cumsum([len(one.face) for one in self.objects]), 0
        for one, end in zip(self.objects, ends, strict=True):
            own = slice(end - len(one.face), end)
            done = keep(one, HOURS, one.means(self.hours[own]))
            if done and self.sky is not None:
                keep(one, SKY, one.means(self.sky[own]))
            kept += done
        return kept


def read_faces(context: bpy.types.Context) -> tuple[list[ObjectFaces], list[str]]:
    """The faces of what the view layer shows. On the main thread."""
    return faces_of(list(context.view_layer.objects), context.evaluated_depsgraph_get())


def face_hours(
    job: Job, asked: HoursAsked, faces: Sequence[ObjectFaces], complaints: list[str], say: Progress, is_given_up: Cancels
) -> FaceHours:
    """Count at all faces, on the worker, waiting for it. Any thread."""
    empty = np.empty((0, 3))
    points = np.concatenate([empty, *(one.points - job.scene.origin_ws for one in faces)])
    normals = np.concatenate([empty, *(one.normals for one in faces)])
    hours, sky = hours_at(job, asked, points, normals, Parts(say, 2), is_given_up)
    return FaceHours(list(faces), hours, sky, complaints)


def hours_of_view(
    job: Job, asked: HoursAsked, faces: Sequence[ObjectFaces], complaints: list[str], say: Progress, is_given_up: Cancels
) -> tuple[SunHours, FaceHours]:
    """The hours of what the view shows, and of all faces. Any thread."""
    seen = sun_hours(job, asked, lambda part, stage: say(0.5 * part, stage), is_given_up, objects=False)
    return seen, face_hours(job, asked, faces, complaints, lambda part, stage: say(0.5 + 0.5 * part, stage), is_given_up)
