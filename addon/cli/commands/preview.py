"""`preview`: one picture of each input, its passes written and reported."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...images.png import encode_png
from ...images.whole import check_picture
from ...pipeline.render_passes import USUAL_PASSES
from ...studies.light_view import SIZE as LIGHT_VIEW_SIZE
from ...studies.light_view import light_picture
from ...studies.outputs import write_bytes, write_json, write_npz, write_pass, written
from ...studies.run import Outcome
from ..command import Command
from ..shared_arguments import SECTIONS, add_batch, add_inputs, add_method, add_passes, add_reporting, add_view

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Everything about a picture."""
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser)
    add_method(parser, *SECTIONS)
    add_batch(parser)
    add_passes(parser)
    parser.add_argument(
        "--light-view",
        action="store_true",
        help="also what the light sees: surfaces in the colour of their shadow map, outlines of maps and view",
    )


def preview(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render and write the passes and the report."""
    from ...blender.rendering import render

    wanted = args.passes or (USUAL_PASSES if args.format == "npz" else ("combined",))
    wish.passes = wanted
    written_files = []
    if args.format != "npz" and "combined" in wanted:
        path = stem.with_name(f"{stem.name}_combined.{args.format}")
        with written(path, check_picture) as temporary:
            outcome = render(scene, wish, temporary)
        written_files.append(path.name)
    else:
        outcome = render(scene, wish)
    written_files += write_data(outcome, stem, wanted, args.format)
    if args.light_view:
        path = stem.with_name(f"{stem.name}_light_view.png")
        write_bytes(path, encode_png(light_picture(outcome.job, outcome.frame.plan, LIGHT_VIEW_SIZE)))
        written_files.append(path.name)
    write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, f"{outcome.report['timing_ms']['total'] / 1e3:.2f} s, wrote {', '.join(written_files)} to {stem.parent}"


def write_data(outcome: Outcome, stem: Path, wanted: tuple[str, ...], kind: str) -> list[str]:
    """Write what is not the combined picture; gives the files' names."""
    if kind == "npz":
        path = stem.with_name(f"{stem.name}.npz")
        write_npz(path, outcome, wanted)
        return [path.name]
    paths = {name: stem.with_name(f"{stem.name}_{name}.{kind}") for name in wanted if name != "combined"}
    for name, path in paths.items():
        write_pass(path, name, outcome)
    return [path.name for path in paths.values()]


ROW = Command(
    "preview",
    place=10,
    help="render the inputs",
    description="Render each input and write its passes and its report.",
    add_arguments=add_arguments,
    work=preview,
)
