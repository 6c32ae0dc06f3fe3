"""`impostor`: capture and write. `impostor-path`: the life of impostors along a path. Scenes are read through Blender's render."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ...blender.impostors.chosen import ChosenImpostors
from ...blender.impostors.plane import write_plane
from ...blender.render_wish import RenderWish
from ...blender.rendering import animated, read
from ...errors import UserError
from ...images.png import encode_png
from ...images.srgb import srgb
from ...pipeline.impostors.baked import BakedImpostor
from ...pipeline.job import Job
from ...scene.plain_text import shown_name
from ...studies.impostors.asked import baked, choice_for
from ...studies.impostors.files import unique_names, write_impostor
from ...studies.impostors.path import PathFrame, csv_text, orbit, summaries, walk
from ...studies.outputs import write_bytes, write_json
from ...studies.report import head_of
from ...studies.terminal import complain

MIB = 1 << 20
TOLD_EVERY = 10


def impostor_command(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Capture from the view; images, JSON and, if asked for, a plane per impostor. One that fails stops no other."""
    chosen = ChosenImpostors.of(args.objects, stem.name)
    job = read(scene, replace(wish, marked=chosen.holders))
    groups = chosen.some(job.scene)
    entries, errors, done, gl = [], [], [], {}
    names = [stem.with_name(f"{stem.name}_{name}") for name in unique_names([group.name for group in groups])]
    if len(groups) == 1 and groups[0].key.kind == "scene":
        names = [stem.with_name(f"{stem.name}_impostor")]
    for path, result in zip(names, baked(job, groups, args.unlit), strict=True):
        if isinstance(result, UserError):
            errors.append(str(result))
            continue
        entry, files = write_impostor(path, result, job.scene, args.format)
        if args.plane:
            files.append(write_plane(path.with_name(f"{path.name}.blend"), result, entry))
        entries.append({**entry, "json": f"{path.name}.json"})
        done.append(_line(result, files))
        gl = result.gl
    errors += chosen.missing(groups)
    report = {
        **head_of(job.name, gl, job.settings),
        "impostors": entries,
        "warnings": list(job.warnings),
        "errors": errors,
    }
    write_json(stem.with_name(f"{stem.name}_report.json"), report)
    return report, "\n".join(done)


def _line(result: BakedImpostor, files: list[Path]) -> str:
    frame = result.frame
    return (
        f"{shown_name(result.name)}: {result.triangles:,} triangles in {frame.width}×{frame.height} texels, {result.bytes / MIB:.1f} MiB, "
        f"wrote {next(path.name for path in files if path.suffix == '.json')} and {len(files) - 1} more files"
    )


def path_command(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Run the path; the CSV, the report and, if asked for, the pictures. Break-even counts only if asked for, as all is measured anyway."""
    if "option_impostor_break_even" not in args:
        wish.settings = wish.settings.replaced(impostor={"break_even": False})
    chosen = ChosenImpostors.of(args.objects, stem.name)
    return _walked(scene, replace(wish, marked=chosen.holders), chosen, stem, args)


def _walked(
    scene: bpy.types.Scene, wish: RenderWish, chosen: ChosenImpostors, stem: Path, args: argparse.Namespace
) -> tuple[dict[str, object], str]:
    first = read(scene, wish)
    groups = chosen.some(first.scene)
    if args.orbit is not None:
        place, jobs = "angle_deg", orbit(first, args.orbit, args.steps or max(round(abs(args.orbit)), 1), groups)
    else:
        place, jobs = "frame", animated(scene, wish, args.from_frame, args.to_frame)
    choice = choice_for(groups, first.settings.impostor, exact=True)
    frames = list(walk(jobs, chosen.groups, choice, _teller(stem if args.pictures else None, args.quiet)))
    report = path_report(first, frames, place)
    report["errors"] += chosen.missing(groups)
    write_bytes(stem.with_name(f"{stem.name}_path.csv"), csv_text(frames).encode())
    write_json(stem.with_name(f"{stem.name}_report.json"), report)
    return report, summary(report)


def path_report(job: Job, frames: list[PathFrame], place: str) -> dict[str, object]:
    """The contract's report of a path; `details` has what its frames leave out."""
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


def _teller(pictures: Path | None, is_quiet: bool) -> Callable[[PathFrame], None]:
    """What is done with every frame: its picture written, a line said at each capture and now and then."""

    def tell(frame: PathFrame) -> None:
        row = frame.row()
        if not is_quiet and (row["stage"] == "regenerated" or frame.index % TOLD_EVERY == 0):
            quality = "" if row["psnr_db"] is None else f", {row['psnr_db']:.1f} dB"
            complain(f"    frame {frame.index}: {row['stage']}{quality}")
        if pictures is not None:
            picture = np.rint(255.0 * srgb(frame.picture)).astype(np.uint8)
            write_bytes(pictures.with_name(f"{pictures.name}_path_{frame.index:04d}.png"), encode_png(picture))

    return tell
