"""`analyse`: the error of each input's shadows, without a picture."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...studies.outputs import write_json
from ..command import Command
from ..shared_arguments import SECTIONS, add_batch, add_inputs, add_method, add_passes, add_reporting, add_view

if TYPE_CHECKING:
    import bpy

    from ...blender.render_wish import RenderWish


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Everything about a picture; no sheet of pictures."""
    add_inputs(parser)
    add_reporting(parser)
    add_view(parser)
    add_method(parser, *SECTIONS)
    add_batch(parser, makes_pictures=False)
    add_passes(parser)


def analyse(scene: bpy.types.Scene, wish: RenderWish, stem: Path, args: argparse.Namespace) -> tuple[dict[str, object], str]:
    """Render without a picture; the report is written where --output or --report say."""
    from ...blender.rendering import render

    outcome = render(scene, wish)
    if args.output:
        write_json(stem.with_name(f"{stem.name}_report.json"), outcome.report)
    return outcome.report, summary(outcome.report)


def summary(report: dict[str, object]) -> str:
    """The report in a line."""
    measured = report["measured"]
    if not measured or measured["m_max"] is None:
        return "nothing measured: no lit surface in view"
    share = 100.0 * measured["share_above_1"]
    return (
        f"m median {measured['m_median']:.3g}, 95 % {measured['m_p95']:.3g}, max {measured['m_max']:.3g}; {share:.1f} % of pixels above 1"
    )


ROW = Command(
    "analyse",
    place=20,
    help="the error report without a picture",
    description="Measure the shadows' error; write no picture.",
    add_arguments=add_arguments,
    work=analyse,
)
