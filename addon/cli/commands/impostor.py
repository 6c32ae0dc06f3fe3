"""`impostor`: relief impostors captured from the view of each input, and written."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import UserError
from ...pipeline.impostors.baked import BakedImpostor
from ...scene.plain_text import shown_name
from ...studies.impostors.asked import baked
from ...studies.impostors.files import unique_names, write_impostor
from ...studies.outputs import write_json
from ...studies.report import head_of
from ..command import Command
from ..shared_arguments import FORMATS, SECTIONS, add_inputs, add_method, add_reporting, add_view

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish

MIB = 1 << 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Objects, everything about a picture, what is written."""
    add_objects(parser)
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser)
    add_method(parser, *SECTIONS)
    add_capture(parser)


def add_objects(parser: argparse.ArgumentParser) -> None:
    """What is captured."""
    parser.add_argument_group("impostors").add_argument(
        "--object",
        dest="objects",
        action="append",
        metavar="NAME",
        help="an object, an assembly's empty or a collection; may be given several times; patterns (pump*) make one impostor of each match "
        "(default: what is marked in the .blend, else all as one)",
    )


def add_capture(parser: argparse.ArgumentParser) -> None:
    """What is written of a capture."""
    group = parser.add_argument_group("output")
    group.add_argument(
        "--format", choices=FORMATS, default="png", help="images: 8-bit colour and 16-bit depth (png), exact values (exr), all in one (npz)"
    )
    group.add_argument("--unlit", action="store_true", help="bare colours of the surfaces, to be relit with the normals")
    group.add_argument("--plane", action="store_true", help="also a .blend with a plane whose material shows the impostor, at its place")


def impostor(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Capture from the view; images, JSON and, if asked for, a plane per impostor. One that fails stops no other."""
    from ...blender.impostors.chosen import ChosenImpostors
    from ...blender.impostors.plane import write_plane
    from ...blender.rendering import read

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


ROW = Command(
    "impostor",
    place=50,
    help="capture relief impostors",
    description="Capture objects from the view: colour, depth, normal, ids as images; critical points and how to draw them as JSON.",
    add_arguments=add_arguments,
    work=impostor,
)
