"""`impostor-path`: the life of impostors along a camera path, against direct rendering."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...images.png import encode_png
from ...images.srgb import srgb
from ...pipeline.job import Job
from ...scene.plain_text import shown_name
from ...studies.impostors.asked import choice_for
from ...studies.impostors.path import PathFrame, csv_text, orbit, summaries, walk
from ...studies.outputs import write_bytes, write_json
from ...studies.report import head_of
from ...studies.terminal import complain
from ..argument_types import finite, positive
from ..command import Command
from ..shared_arguments import SECTIONS, add_inputs, add_method, add_reporting, add_view
from .impostor import add_objects

if TYPE_CHECKING:
    import bpy

    from ...blender.impostors.chosen import ChosenImpostors
    from ...blender.render_wish import RenderWish

LINE_EVERY = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A path, objects, everything about a picture."""
    add_path(parser)
    add_objects(parser)
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser)
    add_method(parser, *SECTIONS)


def add_path(parser: argparse.ArgumentParser) -> None:
    """Where the camera goes."""
    group = parser.add_argument_group("path")
    group.add_argument("--from-frame", type=int, metavar="A", help="first frame of the scene's animation")
    group.add_argument("--to-frame", type=int, metavar="B", help="last frame of the scene's animation")
    group.add_argument("--orbit", type=finite, metavar="DEG", help="turn the camera by so many degrees about the impostors' vertical axis")
    group.add_argument("--steps", type=positive, metavar="N", help="steps of the orbit (default: one per degree)")
    group.add_argument("--pictures", action="store_true", help="also the picture of every frame, drawn with impostors")


def path_mistake(args: argparse.Namespace) -> str | None:
    """What is wrong with a path's arguments together; None when it is clear where the camera goes."""
    frames = (args.from_frame, args.to_frame)
    if (args.orbit is None) == (frames == (None, None)):
        return "say where the camera goes: --orbit DEG [--steps N], or --from-frame A --to-frame B"
    if args.orbit is not None:
        return None if 0.0 < abs(args.orbit) <= 3600.0 else "--orbit takes up to 3600 degrees, not 0"
    if None in frames:
        return "--from-frame and --to-frame belong together"
    if args.steps is not None:
        return "--steps belongs to --orbit"
    return None if frames[0] <= frames[1] else "the last frame comes before the first"


def impostor_path(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Run the path; the CSV, the report and, if asked for, the pictures. Break-even counts only if asked for, as all is measured anyway."""
    from ...blender.impostors.chosen import ChosenImpostors

    if "option_impostor_break_even" not in args:
        wish.settings = wish.settings.replaced(impostor={"break_even": False})
    chosen = ChosenImpostors.of(args.objects, stem.name)
    return _walked(scene, replace(wish, marked=chosen.holders), chosen, stem, args)


def _walked(
    scene: bpy.types.Scene, wish: RenderWish, chosen: ChosenImpostors, stem: Path, args: argparse.Namespace
) -> tuple[dict[str, object], str]:
    from ...blender.rendering import animated, read

    first = read(scene, wish)
    groups = chosen.some(first.scene)
    if args.orbit is not None:
        place, jobs = "angle_deg", orbit(first, args.orbit, args.steps or max(round(abs(args.orbit)), 1), groups)
    else:
        place, jobs = "frame", animated(scene, wish, args.from_frame, args.to_frame)
    choice = choice_for(groups, first.settings.impostor, exact=True)
    frames = list(walk(jobs, chosen.groups, choice, _frame_handler(stem if args.pictures else None, args.quiet)))
    report = path_report(first, frames, place)
    report["errors"] += chosen.missing(groups)
    write_bytes(stem.with_name(f"{stem.name}_path.csv"), csv_text(frames).encode())
    write_json(stem.with_name(f"{stem.name}_report.json"), report)
    return report, summary(report)


def path_report(job: Job, frames: list[PathFrame], place: str) -> dict[str, object]:
    """The report of a path; `details` has what its frames leave out."""
    rows = [frame.row() for frame in frames]
    impostors = summaries(frames)
    gl = frames[0].gl if frames else {}
    return {
        **head_of(job.name, gl, job.settings),
        "impostors": impostors,
        "frames": rows,
        "regenerations": sum(one["regenerations"] for one in impostors),
        "details": [frame.detail(place) for frame in frames],
        "warnings": list(job.warnings),
        "errors": [],
    }


def summary(report: dict[str, object]) -> str:
    """The report in a few lines."""
    quality = [row["psnr_db"] for row in report["frames"] if row["psnr_db"] is not None]
    worst = f"PSNR median {np.median(quality):.1f} dB, least {min(quality):.1f} dB" if quality else "no difference to direct rendering"
    lines = [f"{len(report['frames'])} frames, {report['regenerations']} regenerations; {worst}"]
    for one in report["impostors"]:
        stages = ", ".join(f"{count} {stage}" for stage, count in one["stages"].items())
        lines.append(f"    {shown_name(one['name'])}: {stages}")
    return "\n".join(lines)


def _frame_handler(pictures: Path | None, is_quiet: bool) -> Callable[[PathFrame], None]:
    """What is done with every frame: its picture written, a line said at each capture and now and then."""

    def handle(frame: PathFrame) -> None:
        row = frame.row()
        if not is_quiet and (row["stage"] == "regenerated" or frame.index % LINE_EVERY == 0):
            quality = "" if row["psnr_db"] is None else f", {row['psnr_db']:.1f} dB"
            complain(f"    frame {frame.index}: {row['stage']}{quality}")
        if pictures is not None:
            picture = np.rint(255.0 * srgb(frame.picture)).astype(np.uint8)
            write_bytes(pictures.with_name(f"{pictures.name}_path_{frame.index:04d}.png"), encode_png(picture))

    return handle


ROW = Command(
    "impostor-path",
    place=60,
    help="impostors along a camera path, against direct rendering",
    description="Run the life of impostors along a camera path: stages, predicted errors, measured errors; as CSV and in the report.",
    add_arguments=add_arguments,
    work=impostor_path,
    mistake=path_mistake,
)
