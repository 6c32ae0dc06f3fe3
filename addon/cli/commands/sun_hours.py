"""`sun-hours`: how long the sun shines on every pixel and every object of each input, and how much of the sky they see."""

from __future__ import annotations

import argparse
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import SettingsError
from ...images.exr import encode_exr
from ...images.png import encode_png
from ...maths.view import Light
from ...pipeline.job import Job
from ...studies import stopping
from ...studies.outputs import write_bytes, write_json, written
from ...studies.report import report_of
from ...studies.sun.days import DEFAULT_STEP_MIN, MOST_DAYS, SKY_DIRECTIONS, SunSpan, suns
from ...studies.sun.hours import HoursAsked, csv_text, hours_picture, object_rows, sky_picture, sun_hours
from ..argument_types import between, positive
from ..command import Command
from ..shared_arguments import SECTIONS, add_batch, add_inputs, add_method, add_reporting, add_view
from ..sun_arguments import add_place, sky

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish

ZENITH = np.array([0.0, 0.0, 1.0])
NO_SUN = "The sun does not shine there in the days and hours given: all hours are 0."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A place, days, and everything about a picture but its light."""
    group = parser.add_argument_group("sun")
    add_place(group, ("from this hour of every day on (default: sunrise)", "up to this hour of every day (default: sunset)"))
    group.add_argument(
        "--to-date", type=date.fromisoformat, metavar="YYYY-MM-DD", help="the last day of a range; hours are those of its mean day"
    )
    group.add_argument(
        "--days", type=positive, default=MOST_DAYS, metavar="N", help=f"days of a range that are looked at, evenly (default {MOST_DAYS})"
    )
    group.add_argument(
        "--step",
        type=between(0.1, 240),
        default=DEFAULT_STEP_MIN,
        metavar="MINUTES",
        help=f"from one sun to the next (default {DEFAULT_STEP_MIN:g})",
    )
    group.add_argument(
        "--sky-directions",
        type=between(0, 100_000, is_whole=True),
        default=SKY_DIRECTIONS,
        metavar="N",
        help=f"directions that the sky is looked for in; 0 leaves the share of the sky out (default {SKY_DIRECTIONS})",
    )
    parser.add_argument(
        "--blend", action="store_true", help="also the scene as a .blend file, with the hours of every face as mesh attribute sun_hours"
    )
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser, has_light_direction=False)
    add_method(parser, *SECTIONS)
    add_batch(parser)


def span_of(args: argparse.Namespace) -> SunSpan:
    """The days and hours asked for; raises `SettingsError`."""
    return SunSpan(sky(args)[0], args.to_date or args.date, args.step, args.start, args.end, args.days)


def mistake(args: argparse.Namespace) -> str | None:
    """What is wrong with days and hours together."""
    try:
        span_of(args)
    except SettingsError as error:
        return str(error)
    return None


def sun_hours_command(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Count, write pictures, exact values and the table, and report."""
    from ...blender.rendering import read

    span, place = span_of(args), sky(args)[1]
    asked = HoursAsked(suns(span, place), args.sky_directions)
    job = read(scene, replace(wish, light=lambda _scene, _camera: Light("sun", ZENITH, name="sun hours")))
    found = sun_hours(job, asked, lambda _fraction, _stage: None, stopping.is_asked)
    rows = object_rows(job.scene.object_names, found)
    files = {
        "sun_hours.png": encode_png(hours_picture(found, span.title(place))),
        "sun_hours.exr": encode_exr(found.channels()),
        "sun_hours.csv": csv_text(rows).encode(),
    }
    if found.sky_view is not None:
        files["sky_view.png"] = encode_png(sky_picture(found))
    for name, data in files.items():
        write_bytes(stem.with_name(f"{stem.name}_{name}"), data)
    kept = write_blend(scene, job, asked, stem.with_name(f"{stem.name}_sun_hours.blend")) if args.blend else []
    report = report_of(found.outcome.job, found.outcome.frame)
    report["warnings"] += [*kept, *([] if len(asked.suns) else [NO_SUN])]
    report["sun_hours"] = {**span.as_dict(place), "suns": len(asked.suns), "most": asked.most, "objects": rows}
    write_json(stem.with_name(f"{stem.name}_report.json"), report)
    return report, f"{len(asked.suns)} suns, up to {asked.most:.2f} h a day, wrote {', '.join(files)} to {stem.parent}"


def write_blend(scene: bpy.types.Scene, job: Job, asked: HoursAsked, path: Path) -> list[str]:
    """Write the scene as it is open, with the hours of its faces; a line for each object that cannot keep them."""
    import bpy

    from ...blender.face_values import faces_of
    from ...blender.sun_hours import face_hours

    layer = scene.view_layers[0]
    faces, complaints = faces_of(list(layer.objects), bpy.context.evaluated_depsgraph_get())
    face_hours(job, asked, faces, complaints, lambda _fraction, _stage: None, stopping.is_asked).keep()
    with written(path) as temporary:
        bpy.ops.wm.save_as_mainfile(filepath=str(temporary), copy=True, check_existing=False)
    return complaints


ROW = Command(
    "sun-hours",
    place=45,
    help="hours of direct sun",
    description="Count the hours of direct sun of a day, or of a mean day of a range, and the share of the sky that is seen: "
    "a picture with its legend, exact values, and a table of objects for each input.",
    add_arguments=add_arguments,
    work=sun_hours_command,
    mistake=mistake,
)
